"""What a sweep leaves behind."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import Sweep
from nhtrack.studies.sweep.parts import COMPLETED
from nhtrack.views import drawn_by

_ASIDE = 4  # values of an axis of which each may have a map of its own


@dataclass(frozen=True, repr=False)
class SweepResults:
    """What a sweep left behind.

    Attributes:
        sweep: what was asked for.
        base: its scenario.
        runs: a row for every run: axes, metrics, outcome and reason; see docs/sweep.md.
        metrics: the columns that are metrics, in order.
        folder: where all of it is.
        files: the files written.
        warnings: what was known to go wrong before it ran, in sentences.
    """

    sweep: Sweep
    base: Scenario
    runs: pd.DataFrame
    metrics: tuple[str, ...]
    folder: Path
    files: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()

    @cached_property
    def completed(self) -> pd.DataFrame:
        """The rows of runs that were neither lost nor refused."""
        return self.runs[self.runs["outcome"] == COMPLETED]

    @cached_property
    def varied(self) -> list[str]:
        """The axes that have more than one value."""
        return [key for key in self.sweep.axes if self.runs[key].nunique() > 1]

    @cached_property
    def known(self) -> list[str]:
        """The metrics that some run has a value of."""
        return [name for name in self.metrics if np.isfinite(self.completed[name]).any()]

    @property
    def mapped(self) -> list[str]:
        """The two axes whose values are all combined, and a third of few values, if there is one; else none."""
        if self.sweep.sample is not None or len(self.varied) not in (2, 3):
            return []
        if len(self.varied) == 2:
            return self.varied
        counts = {key: len(self.sweep.labels(key)) for key in self.varied}
        aside = min(counts, key=lambda key: counts[key])
        return [*(key for key in self.varied if key != aside), aside] if counts[aside] <= _ASIDE else []

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"SweepResults({self.sweep.name!r}, {len(self.runs)} runs in {self.folder})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: smallest, median and largest of each metric, and a drawing."""
        return drawn_by("nhtrack.studies.sweep.view.sweep_html", self)
