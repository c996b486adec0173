"""What the keys of a scenario mean together: graph, clocks, inputs, robot.

The checks read the raw tree and skip what they cannot understand, so that a misspelt gain does not hide a cycle in the
graph: every fault of a file is reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from nhtrack import assets
from nhtrack.errors import did_you_mean
from nhtrack.network import network_faults
from nhtrack.reference import Expression, Reference, ReferenceInputError, Segments, Signal, Table, make_segments, make_signal
from nhtrack.scenario.schema import CsvInput, Leader, Physics, Scenario, Similarity, TableInput
from nhtrack.scenario.tree import Path, lookup

Finding = tuple[Path, str]

MOST_PERIODS = 2_000_000  # five and a half hours at 100 Hz; beyond it a recording no longer fits in memory


@dataclass(frozen=True)
class Clock:
    """The control instants of a scenario.

    Attributes:
        periods: number of control periods.
        step: control period in scenario time.
    """

    periods: int
    step: float

    @property
    def times(self) -> np.ndarray:
        """Scenario times at which the input is sampled, shape (periods,)."""
        return np.arange(self.periods) * self.step


def findings(tree: Any, directory: FilePath) -> Iterator[Finding]:
    """Yields what is wrong between the keys of a tree, as path and message.

    Args:
        tree: the raw tree; anything in it may be of the wrong type.
        directory: what relative robot files start from.
    """
    if not isinstance(tree, Mapping):
        return
    yield from _clock_findings(tree)
    yield from _network_findings(tree)
    yield from _robot_findings(tree, directory)
    yield from _input_findings(tree)


def _number(tree: Mapping[str, Any], path: Path, default: Any) -> float | None:
    """Returns the positive number at a path, or None where it is not one; `default` where the key is absent."""
    value = lookup(tree, path, default)
    good = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value) and value > 0
    return float(value) if good else None


def _control_rate(tree: Mapping[str, Any]) -> float | None:
    return _number(tree, ("control_rate",), Scenario.model_fields["control_rate"].default)


def clock(tree: Mapping[str, Any]) -> Clock | None:
    """Returns the control instants of a tree, or None where they cannot be told or nothing would be left of them."""
    rate, duration = _control_rate(tree), _number(tree, ("duration",), None)
    scale = _number(tree, ("similarity", "time"), Similarity.model_fields["time"].default)
    if rate is None or duration is None or scale is None:
        return None
    count = duration * scale * rate
    return Clock(round(count), 1.0 / (rate * scale)) if 0.999 <= count <= MOST_PERIODS else None


def _clock_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields faults of durations and rates that do not fit each other."""
    rate, duration = _control_rate(tree), _number(tree, ("duration",), None)
    scale = _number(tree, ("similarity", "time"), Similarity.model_fields["time"].default)
    timestep = _number(tree, ("physics", "timestep"), Physics.model_fields["timestep"].default)
    if rate is None:
        return
    if timestep is not None:
        steps = 1.0 / (timestep * rate)
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
            yield ("control_rate",), _rate_message(rate, timestep)
    if duration is None or scale is None:
        return
    count = duration * scale * rate
    if count < 0.999:
        yield (
            ("duration",),
            f"{duration:g} is {duration * scale:g} s on the robot's clock, shorter than one control period of {1 / rate:g} s",
        )
    elif count > MOST_PERIODS:
        yield ("duration",), f"{duration:g} takes {count:.3g} control periods; at most {MOST_PERIODS} fit in a recording"


def _rate_message(rate: float, timestep: float) -> str:
    physics_rate = 1.0 / timestep
    if rate > physics_rate:
        return f"{rate:g} Hz is faster than physics steps ({physics_rate:g} Hz); lower it or physics.timestep"
    below, above = math.floor(physics_rate / rate), math.floor(physics_rate / rate) + 1
    return (
        f"{rate:g} Hz does not divide the physics rate of {physics_rate:g} Hz (timestep {timestep:g} s): a control period must "
        f"hold a whole number of steps; nearest rates: {physics_rate / above:.6g} and {physics_rate / below:.6g} Hz"
    )


def _network_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields faults of names and parents."""
    leader = lookup(tree, ("leader", "name"), Leader.model_fields["name"].default)
    followers = lookup(tree, ("followers",), [])
    if not isinstance(followers, list) or not isinstance(leader, str):
        return
    parents: dict[str, list[str]] = {leader: []}
    place: dict[str, int] = {}
    whole = True  # whether every follower could be read: else "no such parent" could blame the wrong line
    for i, follower in enumerate(followers):
        name, others = lookup(follower, ("name",)), lookup(follower, ("parents",))
        readable = isinstance(others, list) and bool(others) and all(isinstance(other, str) for other in others)
        if not isinstance(name, str):
            whole = False
            continue
        if name in parents:
            taken = "the leader" if name == leader else f"follower {place[name] + 1}"
            yield ("followers", i, "name"), f"two robots are called {name!r}: it is {taken} too"
            continue
        place[name] = i
        parents[name] = list(others) if readable else [leader]
        if readable and len(others) > 1:
            yield (
                ("followers", i, "parents"),
                f"{name!r} has {len(others)} parents; this version tracks exactly one (consensus over several is not in it yet)",
            )
    for fault in network_faults(parents):
        if fault.robot in place and (whole or not fault.message.startswith("no robot")):
            at: Path = ("followers", place[fault.robot], "parents")
            yield (at if fault.parent is None else (*at, fault.parent)), fault.message


def _robot_findings(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    robot = lookup(tree, ("robot",), Scenario.model_fields["robot"].default)
    if not isinstance(robot, str) or not robot or robot in assets.robots():
        return
    if is_robot_file(robot):
        if not (directory / robot).is_file():
            yield ("robot",), f"no MJCF file {str(directory / robot)!r}"
    else:
        yield ("robot",), f"no robot {robot!r}; {did_you_mean(robot, assets.robots())}, or a path to an MJCF file (.xml)"


def is_robot_file(robot: str) -> bool:
    """Returns whether a scenario's `robot` is a path to an MJCF file rather than a bundled name."""
    return robot.endswith(".xml") or "/" in robot


def _input_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields faults of inputs on the control grid: no finite value, or a table that does not cover it."""
    grid, given = clock(tree), lookup(tree, ("leader", "input"))
    if not isinstance(given, Mapping):
        return
    at: Path = ("leader", "input")
    if "table" in given:
        yield from _table_findings(given, (*at, "table"), grid)
        return
    if grid is None:
        return
    for name in ("u_x", "u_theta"):
        signal = _signal(given.get(name))
        if signal is not None:
            try:
                signal(grid.times)
            except ReferenceInputError as error:
                yield (*at, name), str(error)


def _signal(value: Any) -> Signal | None:
    """Returns the signal of a raw value of the file, or None where its form is at fault."""
    try:
        if isinstance(value, list):
            return make_segments([(piece.get("until"), piece["value"]) for piece in value])
        return make_signal(value)
    except (ReferenceInputError, TypeError, ValueError, KeyError, AttributeError, OverflowError):
        return None


def _table_findings(given: Mapping[str, Any], at: Path, grid: Clock | None) -> Iterator[Finding]:
    columns = {name: lookup(given, ("table", name)) for name in ("t", "u_x", "u_theta")}
    if not all(isinstance(column, (list, tuple)) and column for column in columns.values()):
        return
    times = columns["t"]
    try:
        for name in ("u_x", "u_theta"):
            Table(tuple(times), tuple(columns[name]))
    except (ReferenceInputError, TypeError) as error:
        if isinstance(error, ReferenceInputError):
            yield at, str(error)
        return
    if times[0] > 0:
        yield at, f"the first row is at t = {times[0]:g}; a table starts at 0 or before"
    last = grid.times[-1] if grid is not None else -math.inf
    if given.get("interpolation") == "linear" and times[-1] < last - 1e-9 * abs(last):
        yield at, f"the last row is at t = {times[-1]:g}, but the input is asked until t = {last:g}; add rows or hold `previous`"


def make_reference(scenario: Scenario) -> Reference:
    """Returns the leader's reference of a loaded scenario, in scenario units.

    Raises:
        ReferenceInputError: an input that only a scenario built by hand can have.
    """
    given = scenario.leader.input
    if isinstance(given, TableInput):
        table = given.table
        return Reference.from_table(table.t, table.u_x, table.u_theta, given.interpolation)
    if isinstance(given, CsvInput):
        raise ReferenceInputError(f"the CSV file {given.csv!r} has not been read; load the scenario through nhtrack.load")
    return Reference(_make_signal(given.u_x), _make_signal(given.u_theta))


def _make_signal(value: Any) -> Expression | Segments:
    if isinstance(value, tuple):
        return make_segments([(piece.until, piece.value) for piece in value])
    return make_signal(value)

