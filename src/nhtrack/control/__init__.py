"""Tracking laws: pure functions of follower, leader and memory."""

from nhtrack.control.baselines import FeedbackLinearisation, JiangNijmeijer, Kanayama, LookAhead, Samson
from nhtrack.control.law import Law, Leader, Memory, Robots
from nhtrack.control.limits import Limits
from nhtrack.control.log_feedback import log_feedback
from nhtrack.control.published import Published
from nhtrack.control.stabiliser import Stabiliser
from nhtrack.control.universal import Universal

__all__ = [
    "FeedbackLinearisation", "JiangNijmeijer", "Kanayama", "Law", "Leader", "Limits", "LookAhead", "Memory",
    "Published", "Robots", "Samson", "Stabiliser", "Universal", "log_feedback",
]  # fmt: skip
