"""What the report says of the paper's examples: figures of merit beside what the paper claims."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nhtrack.analysis.metrics import (
    heading_error,
    late_rows,
    limits_of,
    position_error,
    robot_figures,
    settling_times,
    smallest_separation,
)
from nhtrack.presentation.numbers import quantity, seconds, share
from nhtrack.presentation.shown import within
from nhtrack.recording import Recording
from nhtrack.settling import LATE
from nhtrack.studies.paper.page import (
    FOLLOWER_HEADER,
    START_HEADER,
    farthest,
    follower_rows,
    leader_path,
    settings,
    start_rows,
)
from nhtrack.studies.paper.report import NEAR, ExampleSection, WordTable
from nhtrack.studies.paper.result import ExampleRuns

CLAIMS = {
    1: "From this start the follower converges to a leader that accelerates along a smooth path: its errors in "
    "position and heading go to zero (Theorem 1).",
    2: "The same law converges to a leader that stops, turns on the spot and drives on, whose path has corners.",
    3: "The follower turns one way round from the heading pi and the other way round from -pi, and converges from "
    "both.",
    4: "All followers, that with two parents among them, converge to the leader's place and heading (Theorem 2).",
    5: "All followers converge to their places in the frame of what they track (Theorem 3).",
}
_SHRINKS = 0.5  # an error that is not below this share of what it was a moment ago has stopped shrinking
_TURNS = "example3"  # scenarios in which it matters which way round the follower turns


class Merit(NamedTuple):
    """Figures of a run, the worst of its followers.

    Attributes:
        began: how far the farthest follower began from what it tracks [m].
        late: largest position error late in the run [m].
        before: the same of as long a time just before [m].
        heading: largest heading error late in the run [rad].
        settled: whether all of them did, see `nhtrack.settling`.
    """

    began: float
    late: float
    before: float
    heading: float
    settled: bool

    @property
    def mark(self) -> str:
        """What came of the claim that errors go to zero."""
        if self.settled:
            return "reached"
        return "near" if self.late <= NEAR * self.began else "missed"


def merit(recording: Recording) -> Merit:
    """Returns the figures of a run, which is at least two control periods long."""
    position, heading = position_error(recording)[:, 1:], np.abs(heading_error(recording)[:, 1:])
    late = late_rows(recording)
    before = slice(max(0, 2 * late.start - len(position)), late.start)
    began, end, earlier, turned = (
        float(values.max()) for values in (position[0], position[late], position[before], heading[late])
    )
    settled = bool(np.isfinite(settling_times(recording)[1:]).all())
    return Merit(began, end, earlier, turned, settled)


def sections(done: Sequence[ExampleRuns], folder: Path) -> list[ExampleSection]:
    """Returns what the report says of examples.

    Args:
        done: with their runs.
        folder: where the figures are.
    """
    return [_section(runs, folder) for runs in done]


def paper_command(done: Sequence[ExampleRuns]) -> str:
    """Returns the command that runs examples."""
    numbers = ",".join(str(runs.example.number) for runs in done)
    words = ["nhtrack", "paper", "--examples", numbers]
    return shlex.join(words + ([] if done[0].wheels else ["--backend", "ideal"]))


def _section(runs: ExampleRuns, folder: Path) -> ExampleSection:
    example = runs.example
    scenarios = {name: recording.scenario for name, recording in runs.shown.items()}
    marks = [merit(recording).mark for recording in runs.shown.values()]
    return ExampleSection(
        example.number,
        example.title,
        example.text,
        CLAIMS[example.number],
        max(marks, key=("reached", "near", "missed").index),
        _verdicts(runs),
        [(figure.caption, folder / f"{figure.name}.png") for figure in example.figures],
        [_merits(name, runs) for name in runs.shown],
        [
            WordTable("What each follower makes of what it tracks", FOLLOWER_HEADER, follower_rows(runs), words=2),
            *([_robots(runs)] if runs.wheels else []),
            *(
                WordTable(f"Initial conditions of paper/{name}", START_HEADER, start_rows(scenario))
                for name, scenario in scenarios.items()
            ),
        ],
        [line.replace("`", "") for line in settings(next(iter(scenarios.values())))],
    )


# In words -------------------------------------------------------------------------------------------------------------


def _verdicts(runs: ExampleRuns) -> list[str]:
    told = [_ending(name, recording, len(runs.shown) > 1) for name, recording in runs.shown.items()]
    told += [_turning(name, run) for name, run in runs.shown.items() if name.startswith(_TURNS)]
    told += [_wheels(run) for run in runs.wheels.values()][:1]
    touching = [run for run in runs.wheels.values() if run.scenario.physics.robot_contact]
    return told + [_closest(run) for run in touching]


def _ending(name: str, recording: Recording, named: bool) -> str:
    """Returns how near followers come, and whether they still come nearer at the end."""
    found, scale = merit(recording), recording.length_scale
    which = f"In {name} followers" if named else "Followers"
    settle = f"{'settle' if found.settled else 'do not settle'} {within(limits_of(recording))} of their places"
    still = "and still shrinks" if found.late <= _SHRINKS * found.before else "and has stopped shrinking"
    late, began, before = (quantity(value / scale, "m") for value in (found.late, found.began, found.before))
    return (
        f"{which} {settle} on the floor: they are within {late} in the last {share(LATE)} of the run, "
        f"{share(found.late / found.began)} of the {began} from which the farthest began, and within "
        f"{quantity(found.heading, 'rad')}; the distance was up to {before} just before, {still}."
    )


def _turning(name: str, recording: Recording) -> str:
    """Returns which way round a follower turned, seen from its leader, and how far."""
    seen = recording["pose"].values[:, 1, 2] - recording["leader_pose"].values[:, 1, 2]
    turned = float(seen[-1] - seen[0])
    way = "anticlockwise" if turned > 0 else "clockwise"
    return f"In {name} the follower turns {way} by {abs(turned) / math.pi:.3g} pi."


def _wheels(recording: Recording) -> str:
    gap, use = _largest(recording, "gap_position_rms"), _largest(recording, "peak_utilisation")
    return (
        f"Wheels and ideal twin part by {quantity(gap, 'm')} RMS on the floor, and wheels use at most "
        f"{'an unknown share' if use is None else share(use)} of the friction there is."
    )


def _closest(recording: Recording) -> str:
    found = smallest_separation(recording)
    assert found is not None  # robots that touch are more than one
    names = " and ".join(found.robots)
    return f"The closest two robots came: {quantity(found.distance, 'm')} between {names}, at {seconds(found.time)}."


# Tables ---------------------------------------------------------------------------------------------------------------


def _merits(name: str, runs: ExampleRuns) -> list[str]:
    """Returns the row of a scenario in the overview."""
    recording, ideal, wheels = runs.shown[name], runs.ideal[name], runs.wheels.get(name)
    use = None if wheels is None else _largest(wheels, "peak_utilisation")
    return [
        name,
        quantity(farthest(recording), "m"),
        *("-" if run is None else share(merit(run).late / leader_path(run)) for run in (ideal, wheels)),
        quantity(merit(recording).heading, "rad"),
        "-" if wheels is None else quantity(_largest(wheels, "gap_position_rms"), "m"),
        "-" if use is None else share(use),
    ]


def _robots(runs: ExampleRuns) -> WordTable:
    """Returns how far each robot's wheels and its ideal twin part, on the floor, and what they asked of it."""
    rows = [
        [
            robot if len(runs.wheels) == 1 else f"{robot}, {name}",
            quantity(figures["path_length"], "m"),
            quantity(figures["gap_position_rms"], "m"),
            quantity(figures["gap_position_max"], "m"),
            quantity(figures["gap_heading_max"], "rad"),
            "-" if figures["peak_utilisation"] is None else share(figures["peak_utilisation"]),
            share(figures["torque_saturation_share"]),
        ]
        for name, recording in runs.wheels.items()
        for robot, figures in robot_figures(recording).items()
    ]
    header = ["robot", "path", "gap RMS", "gap max", "heading gap max", "peak friction utilisation"]
    return WordTable("How far wheels and ideal twin part, on the floor", [*header, "time at the torque limit"], rows)


def _largest(recording: Recording, figure: str) -> float | None:
    known = [value for each in robot_figures(recording).values() if (value := each[figure]) is not None]
    return max(known, default=None)
