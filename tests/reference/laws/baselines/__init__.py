"""Rival laws from the literature, as arrays."""

from collections.abc import Mapping
from typing import TypeAlias

from reference.laws.baselines.feedback_linearisation import FeedbackLinearisation
from reference.laws.baselines.jiang_nijmeijer import JiangNijmeijer
from reference.laws.baselines.kanayama import Kanayama
from reference.laws.baselines.look_ahead import LookAhead
from reference.laws.baselines.samson import Samson

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
