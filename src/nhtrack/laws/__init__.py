"""Tracking laws, one file each: scalar functions of one follower that the loop compiles."""

from nhtrack.compiled import compiled
from nhtrack.laws.contract import Follower, Gain, Leader, LeaderMotion, Limits
from nhtrack.laws.law import Law, LawKind
from nhtrack.laws.own_file import LawError
from nhtrack.laws.registry import faulty_laws, law_in, law_named, law_of_text, laws

__all__ = [
    "Follower", "Gain", "Law", "LawError", "LawKind", "Leader", "LeaderMotion", "Limits", "compiled", "faulty_laws",
    "law_in", "law_named", "law_of_text", "laws",
]  # fmt: skip
