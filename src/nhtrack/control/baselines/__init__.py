"""Rival tracking laws from the literature, each as its source has it, on the accelerations that this project commands.

They see the leader from the follower: `e = (e_x, e_y, e_theta)`, the leader's pose in the follower's frame, with

    e_x' = omega e_y - v + V_x,   e_y' = -omega e_x + V_y,   e_theta' = omega_r - omega,

(v, omega) the follower's velocities, omega_r the leader's turning rate, V = R(e_theta) (v_r, v_yr) the leader's
velocity in the follower's frame. Laws whose source commands velocities share one inner loop (`inner_loop`).
"""

from collections.abc import Mapping
from typing import TypeAlias

from nhtrack.control.baselines.feedback_linearisation import FeedbackLinearisation
from nhtrack.control.baselines.jiang_nijmeijer import JiangNijmeijer
from nhtrack.control.baselines.kanayama import Kanayama
from nhtrack.control.baselines.look_ahead import LookAhead
from nhtrack.control.baselines.samson import Samson

Baseline: TypeAlias = type[FeedbackLinearisation | JiangNijmeijer | Kanayama | LookAhead | Samson]

# By the names that scenarios call them.
BASELINES: Mapping[str, Baseline] = {
    "kanayama": Kanayama,
    "samson": Samson,
    "jiang_nijmeijer": JiangNijmeijer,
    "feedback_linearisation": FeedbackLinearisation,
    "look_ahead": LookAhead,
}

__all__ = ["BASELINES", "FeedbackLinearisation", "JiangNijmeijer", "Kanayama", "LookAhead", "Samson"]
