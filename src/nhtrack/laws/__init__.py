"""Tracking laws, one file each: scalar functions of one follower that the loop compiles."""

from nhtrack.laws.contract import Follower, Gain, Leader, Limits
from nhtrack.laws.law import Law, LawError, LawKind
from nhtrack.laws.registry import law_in, law_named, laws

__all__ = ["Follower", "Gain", "Law", "LawError", "LawKind", "Leader", "Limits", "law_in", "law_named", "laws"]
