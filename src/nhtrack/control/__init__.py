"""Tracking laws: pure functions of follower, leader and memory."""

from nhtrack.control.law import Law, Leader, Memory, Robots
from nhtrack.control.log_feedback import log_feedback
from nhtrack.control.published import Published
from nhtrack.control.stabiliser import Stabiliser

__all__ = ["Law", "Leader", "Memory", "Published", "Robots", "Stabiliser", "log_feedback"]
