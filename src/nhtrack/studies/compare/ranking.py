"""How laws did in one scenario: a row of figures for each, and which is best at what."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from nhtrack.recording import Recording


@dataclass(frozen=True)
class Standing:
    """How one law did, the worst follower each; None where a figure is not known or not finite.

    Late errors and the settling time are known of whole runs only. The others are of what was recorded.

    Attributes:
        label: what the law is called here.
        outcome: of its run: `completed`, `interrupted` or `diverged: ...`.
        end: how far it got [s].
        late_position_error: worst over the last 15 % of the run [m].
        late_heading_error: the same of the heading [rad].
        settling_time: when the last follower settled, None where one never does [s].
        gap_position_rms: distance from the ideal twin [m].
        peak_utilisation: share of the friction limit that a wheel used [1].
        torque_saturation_share: share of the time in which a motor was at its limits [1].
        effort_x: RMS of the forward accelerations commanded, over all followers and the run [m/s^2].
        effort_theta: the same of the angular accelerations [rad/s^2].
    """

    label: str
    outcome: str
    end: float
    late_position_error: float | None
    late_heading_error: float | None
    settling_time: float | None
    gap_position_rms: float | None
    peak_utilisation: float | None
    torque_saturation_share: float | None
    effort_x: float | None
    effort_theta: float | None

    @property
    def completed(self) -> bool:
        """Whether the run did."""
        return self.outcome == "completed"

    @property
    def row(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


_ALIKE = 0.01  # share by which figures differ that mean the same


class Measure(NamedTuple):
    """A figure of the standings.

    Attributes:
        heading: of its column.
        unit: its unit, `%` for a share.
        rounding: what it differs by, in SI units, where runs differ by nothing that means anything: a micrometre or a
            microradian, within which wheels follow their twins; a control period at 100 Hz; a thousandth of a share.
        praise: what is said of the best at it.
    """

    heading: str
    unit: str
    rounding: float
    praise: str

    def ties(self, best: float, next_best: float) -> bool:
        """Returns whether two figures, the smaller first, differ by less than means anything."""
        return next_best - best <= (1 + 1e-9) * max(self.rounding, _ALIKE * best)


MEASURES: Mapping[str, Measure] = {
    "late_position_error": Measure("late", "m", 1e-6, "is nearest to its place late in the run"),
    "late_heading_error": Measure("late heading", "rad", 1e-6, "keeps its heading best late in the run"),
    "settling_time": Measure("settled", "s", 0.01, "settles first"),
    "gap_position_rms": Measure("gap RMS", "m", 1e-6, "is closest to its ideal twin"),
    "peak_utilisation": Measure("friction", "%", 1e-3, "asks least of the floor"),
    "torque_saturation_share": Measure("saturation", "%", 1e-3, "has its motors at their limits least often"),
    "effort_x": Measure("RMS u_x", "m/s²", 1e-6, "speeds up and brakes least"),
    "effort_theta": Measure("RMS u_theta", "rad/s²", 1e-6, "turns in and out of bends least"),
}


def standing(label: str, recording: Recording, summary: dict[str, Any]) -> Standing:
    """Returns how a law did.

    Args:
        label: what to call it.
        recording: its run.
        summary: the figures of that, see `nhtrack.analysis.metrics.summary`.
    """
    followers = summary["followers"].values()
    robots = [summary["robots"][name] for name in recording.followers]
    whole = recording.outcome == "completed"
    effort_x, effort_theta = control_effort(recording)
    return Standing(
        label,
        recording.outcome,
        float(recording.time[-1]),
        _worst(followers, "late_position_error") if whole else None,
        _worst(followers, "late_heading_error") if whole else None,
        _worst(followers, "settling_time") if whole else None,
        _worst(robots, "gap_position_rms"),
        _worst(robots, "peak_utilisation"),
        _worst(robots, "torque_saturation_share"),
        effort_x,
        effort_theta,
    )


def best(standings: Sequence[Standing]) -> dict[str, int]:
    """Returns the place of the law with the smallest value of each measure, of those whose runs completed.

    A measure that not at least two of them have, or of which the two smallest tie, has no best.
    """
    places = {}
    for measure, kind in MEASURES.items():
        known = [(getattr(each, measure), i) for i, each in enumerate(standings) if each.completed]
        ranked = sorted((value, i) for value, i in known if value is not None)
        if len(ranked) > 1 and not kind.ties(ranked[0][0], ranked[1][0]):
            places[measure] = ranked[0][1]
    return places


@np.errstate(over="ignore", invalid="ignore")  # a run that diverges may have asked for anything
def control_effort(recording: Recording) -> tuple[float | None, float | None]:
    """Returns the RMS of u_x [m/s^2] and u_theta [rad/s^2] over the followers and the periods of a run."""
    u = recording["input"].values[:-1, 1:]  # nothing is commanded at the end of a run
    if not u.size:
        return None, None
    mean = np.sqrt((u**2).mean(axis=(0, 1)))
    x, theta = (float(value) if np.isfinite(value) else None for value in mean)
    return x, theta


def _worst(figures: Iterable[dict[str, float | None]], name: str) -> float | None:
    """Returns the largest of a figure, or None where one of them is not known."""
    values = [each[name] for each in figures]
    known = [value for value in values if value is not None]
    return max(known) if len(known) == len(values) else None
