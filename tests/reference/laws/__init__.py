"""Tracking laws as pure functions of arrays: follower, leader and memory."""

from reference.laws.baselines import BASELINES, FeedbackLinearisation, JiangNijmeijer, Kanayama, LookAhead, Samson
from reference.laws.law import Law, Leader, Memory, Robots
from reference.laws.limits import Limits
from reference.laws.published import Published
from reference.laws.stabiliser import Stabiliser
from reference.laws.universal import Universal

__all__ = [
    "BASELINES", "FeedbackLinearisation", "JiangNijmeijer", "Kanayama", "Law", "Leader", "Limits", "LookAhead",
    "Memory", "Published", "Robots", "Samson", "Stabiliser", "Universal",
]  # fmt: skip
