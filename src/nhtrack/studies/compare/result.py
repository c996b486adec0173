"""What a comparison of laws found: who ran, how they did, what there is to say of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.config.scenario import Scenario
from nhtrack.presentation.shown import Room
from nhtrack.recording import Recording
from nhtrack.recording.versions import versions
from nhtrack.settling import settling_limits
from nhtrack.studies.compare.ranking import Standing, best, standing
from nhtrack.studies.run.result import Outcome
from nhtrack.studies.tune.box import require_budget
from nhtrack.studies.tune.objective import Objective, ObjectiveError
from nhtrack.studies.tune.result import Tuning
from nhtrack.views import drawn_by

_LEAST = 0.5  # [m] shown around a leader that stands and whose followers begin beside it


@dataclass(frozen=True)
class Search:
    """How the gains of every law are searched before it runs.

    Attributes:
        objective: what is wanted.
        budget: how many sets of gains are run for each law.
    """

    objective: Objective
    budget: int


def search_of(budget: int | None, objective: str | None) -> Search | None:
    """Returns how gains are to be searched, or None where no budget is given.

    Raises:
        ObjectiveError: an objective that cannot be understood, or one without a search.
        TuningError: a budget too small.
    """
    if budget is None:
        if objective is not None:
            raise ObjectiveError("says what --tune wants; add --tune N")
        return None
    require_budget(budget)
    return Search(Objective.parse(objective or "late"), budget)


@dataclass(frozen=True, repr=False)
class Comparison:
    """What a comparison left behind.

    Attributes:
        scenario: what was compared in, with its own law, and with its time scale as a number.
        entrants: the same under each law, with the gains it ran with, by the laws' labels.
        outcomes: of the laws that were run; fewer than the entrants where the user stopped it.
        search: how gains were searched, or None.
        tunings: of the laws whose search found gains.
        notes: how the comparison went about, in sentences.
        folder: where the files are, or None for a comparison in memory.
        files: the files written, in the order of writing.
        skipped: what was asked for and could not be made, with the reason.
    """

    scenario: Scenario
    entrants: Mapping[str, Scenario]
    outcomes: Mapping[str, Outcome]
    search: Search | None
    tunings: Mapping[str, Tuning]
    notes: tuple[str, ...]
    folder: Path | None
    files: tuple[Path, ...] = ()
    skipped: tuple[str, ...] = ()

    @property
    def recordings(self) -> dict[str, Recording]:
        """The runs by the laws' labels."""
        return {label: outcome.recording for label, outcome in self.outcomes.items()}

    @property
    def standings(self) -> tuple[Standing, ...]:
        """How the laws did."""
        return tuple(standing(label, each.recording, each.summary) for label, each in self.outcomes.items())

    @property
    def completed(self) -> bool:
        """Whether at least one law completed its run."""
        return any(each.recording.outcome == "completed" for each in self.outcomes.values())

    @property
    def interrupted(self) -> bool:
        """Whether the user stopped it."""
        ended = [each.recording.outcome for each in self.outcomes.values()]
        return "interrupted" in ended or len(ended) < len(self.entrants)

    @property
    def no_film(self) -> str:
        """Why there is no film, if there is none."""
        mark = "no video: "
        reasons = [reason.removeprefix(mark) for reason in self.skipped if reason.startswith(mark)]
        if not self.completed:
            reasons.append("no law completed its run")
        return next(iter(reasons), "none was asked for")

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with runs, in sentences: what every law has to hear once, then law by law."""
        told = {label: each.summary["warnings"] for label, each in self.outcomes.items()}
        first, *rest = told.values()
        common = [warning for warning in first if rest and all(warning in others for others in rest)]
        single = [f"{label}: {each}" for label, warnings in told.items() for each in warnings if each not in common]
        missing = [f"{label}: not run, the comparison was interrupted" for label in self.entrants if label not in told]
        return tuple(f"every law: {warning}" for warning in common) + tuple(single + missing)

    @property
    def tree(self) -> dict[str, Any]:
        """Plain values for JSON."""
        standings, similarity = self.standings, self.scenario.similarity
        return {
            "name": self.scenario.name,
            "backend": self.scenario.backend,
            "similarity": {"length": similarity.length, "time": similarity.time},
            "settling_limits": settling_limits(similarity.length)._asdict(),
            "search": None if self.search is None else self._search_tree(self.search),
            "laws": [each.row | self._law_tree(each.label) for each in standings],
            "best": {measure: standings[place].label for measure, place in best(standings).items()},
            "notes": self.notes,
            "warnings": self.warnings,
            "scenario": self.scenario.model_dump(mode="json"),
            "versions": versions(),
        }

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"Comparison({self.scenario.name!r}: {', '.join(self.outcomes)})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: how the laws did, and all of them in one drawing."""
        return drawn_by("nhtrack.studies.compare.view.comparison_html", self)

    def _search_tree(self, search: Search) -> dict[str, Any]:
        return {"objective": str(search.objective), "budget": search.budget, "seed": self.scenario.seed}

    def _law_tree(self, label: str) -> dict[str, Any]:
        tuning = self.tunings.get(label)
        found = None
        if tuning is not None:
            before = tuning.cost_before if math.isfinite(tuning.cost_before) else None
            gains = {"gains": tuning.gains, "gains_before": tuning.gains_before}
            found = {**gains, "cost": tuning.cost, "cost_before": before}
        return {"law": self.entrants[label].law.model_dump(mode="json"), "tuning": found}


def room_of(recordings: Sequence[Recording]) -> Room:
    """Returns the part of the floor [m] that is worth showing: as much again on all sides as leader and starts span.

    A law that loses its robots would otherwise shrink all others to a dot.
    """
    root = max(recordings, key=lambda recording: len(recording.time))["pose"].values[:, 0, :2]
    points = np.concatenate([root, recordings[0]["pose"].values[0, :, :2]])
    low, high = points.min(axis=0), points.max(axis=0)
    around = max(float((high - low).max()), _LEAST)
    return float(low[0]) - around, float(high[0]) + around, float(low[1]) - around, float(high[1]) + around
