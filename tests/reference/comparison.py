"""How far a recording is from the run of the array code, and whether a switch of the law explains it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from nhtrack.config.scenario import Scenario
from nhtrack.recording import Recording

POSITION = 1e-9  # [m] two implementations of one motion: rounding, amplified by the gains
HEADING = 1e-7  # [rad] the same while a follower passes its leader by millimetres, where angles are that of short lines
JUMP = 1e-6  # [m/s^2, rad/s^2] smallest difference of inputs that counts as a switch
SUDDEN = 1e3  # a switch makes inputs differ by so many times as much as in all periods before

USUAL = 20  # periods whose changes of the input are the usual ones
UNUSUAL = 10  # times the usual change of an input make a jump

Run = Mapping[str, np.ndarray]

_ANGLES = ("pose", "leader_pose", "ideal_pose", "error")  # whose last component is one
_TWINS_OWN = "ideal_pose"


@dataclass(frozen=True)
class Difference:
    """The largest difference of a quantity, where and when."""

    size: float
    time: float
    robot: str


@dataclass(frozen=True)
class Switch:
    """A law that decided otherwise in one of two runs whose poses still agreed."""

    time: float
    robot: str
    jump: float


@dataclass
class Comparison:
    """Two runs of a scenario.

    Attributes:
        rows: how many rows were compared.
        largest: the largest differences by quantity, in all rows.
        position: largest difference of positions before the switch, or in all rows where there is none [m].
        heading: the same of headings [rad].
        exceeded: when poses first differ by more than POSITION or HEADING [s], or None.
        switch: what explains it, or None.
        ends: when the two runs end, where only one of them diverged.
    """

    rows: int
    largest: dict[str, Difference] = field(default_factory=dict)
    position: float = 0.0
    heading: float = 0.0
    exceeded: float | None = None
    switch: Switch | None = None
    ends: tuple[float, float] | None = None

    @property
    def is_same(self) -> bool:
        """Whether the runs are the same motion until a switch of the law, if there is one."""
        together = self.position <= POSITION and self.heading <= HEADING
        return together and (self.switch is not None or (self.exceeded is None and self.ends is None))


def shortened(scenario: Scenario, periods: int) -> Scenario:
    """Returns a scenario with so many control periods at most."""
    if periods >= scenario.periods:
        return scenario
    return scenario.model_copy(
        update={"duration": periods / (scenario.control_rate * scenario.similarity.time_scale)}
    )


def arrays_of(recording: Recording) -> dict[str, np.ndarray]:
    """Returns time and all variables of a recording as arrays."""
    names = ("time", *map(str, recording.dataset.data_vars))
    return {name: np.asarray(recording.dataset[name].values) for name in names}


def compare(reference: Run, found: Run, robots: tuple[str, ...], *, cut: bool = False) -> Comparison:
    """Returns the comparison of a run with the reference.

    Args:
        reference: from `reference.run.run_reference`.
        found: from `arrays_of`.
        robots: their names, root first.
        cut: whether one of the two was made to end before the other; else one that ends earlier diverged.
    """
    lengths = len(reference["time"]), len(found["time"])
    rows = min(lengths) - (lengths[0] != lengths[1])  # the last row of a run commands nothing
    comparison = Comparison(rows)
    if lengths[0] != lengths[1] and not cut:
        comparison.ends = float(reference["time"][-1]), float(found["time"][-1])
    one, other = ({name: values[:rows] for name, values in run.items()} for run in (reference, found))
    time = one["time"]
    names = [name for name in one if name in other and one[name].shape == other[name].shape]
    apart = {name: _apart(name, one[name], other[name]) for name in names}
    for name in names:
        comparison.largest |= _largest(name, apart[name], time, robots)
    unlike = sorted((set(one) | set(other)) - set(names))
    comparison.largest |= {f"{name} (absent or other shape)": Difference(np.inf, 0.0, "") for name in unlike}
    gaps = [_length(_difference(run["pose"], run[_TWINS_OWN])[..., :2]) for run in (one, other)]
    comparison.largest["gap to twin [m]"] = _at(_difference(*gaps), time, robots)
    headings = [np.abs(run["pose"][..., 2] - run[_TWINS_OWN][..., 2]) for run in (one, other)]
    comparison.largest["gap to twin [rad]"] = _at(_difference(*headings), time, robots)

    position, heading = _length(apart["pose"][..., :2]), np.abs(apart["pose"][..., 2])
    beyond = ((position > POSITION) | (heading > HEADING)).any(axis=1)
    end = rows
    if beyond.any():
        first = int(beyond.argmax())
        comparison.exceeded = float(time[first])
        comparison.switch = _switch(one["input"], apart["input"], time, robots, first)
        if comparison.switch is not None:
            end = int(np.searchsorted(time, comparison.switch.time)) + 1
    comparison.position, comparison.heading = float(position[:end].max()), float(heading[:end].max())
    return comparison


def _switch(
    inputs: np.ndarray, apart: np.ndarray, time: np.ndarray, robots: tuple[str, ...], first: int
) -> Switch | None:
    """Returns the switch that sets inputs apart before poses are, or None where they part gradually."""
    size = np.abs(apart).max(axis=-1)
    earlier = np.zeros(len(robots))
    for k in range(first + 1):
        for robot in np.flatnonzero(size[k] > np.maximum(JUMP, SUDDEN * earlier)):
            component = int(np.abs(apart[k, robot]).argmax())
            switched = _jumps(inputs[:, robot, component], k, size[k, robot])
            return Switch(float(time[k]), robots[robot], float(size[k, robot])) if switched else None
        earlier = np.maximum(earlier, size[k])
    return None


def _jumps(values: np.ndarray, k: int, size: float) -> bool:
    """Returns whether the reference's own input jumps about as far within two periods: so little rounding moves it."""
    changes = np.abs(np.diff(values))
    before, near = changes[max(k - 2 - USUAL, 0) : max(k - 2, 0)], changes[max(k - 2, 0) : k + 3]
    if len(before) < USUAL // 2:
        return False
    jump = float(np.nanmax(near))
    return jump / 4 <= size <= 2 * jump and jump >= UNUSUAL * float(np.median(before))


def _difference(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns a - b, 0 where both are the same or no number, infinite where one of them is no number."""
    with np.errstate(invalid="ignore"):
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        return np.where(same, 0.0, np.nan_to_num(a - b, nan=np.inf))


def _apart(name: str, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    apart = _difference(a, b)
    if name == "error":
        apart[..., 2] = (apart[..., 2] + np.pi) % (2 * np.pi) - np.pi
    return apart


def _length(apart: np.ndarray) -> np.ndarray:
    return np.hypot(apart[..., 0], apart[..., 1])


def _largest(name: str, apart: np.ndarray, time: np.ndarray, robots: tuple[str, ...]) -> dict[str, Difference]:
    if name in _ANGLES:
        parts = {f"{name} [m]": _length(apart[..., :2]), f"{name} [rad]": np.abs(apart[..., 2])}
    elif apart.ndim == 3:
        parts = {name: np.abs(apart).max(axis=-1)}
    else:
        parts = {name: np.abs(apart)}
    return {part: _at(sizes, time, robots) for part, sizes in parts.items()}


def _at(sizes: np.ndarray, time: np.ndarray, robots: tuple[str, ...]) -> Difference:
    """Returns the largest of sizes, shape (t,), (t, robots) or (t, anything)."""
    sizes = np.abs(sizes).reshape(len(sizes), -1)
    row, column = np.unravel_index(sizes.argmax(), sizes.shape)
    robot = robots[column] if sizes.shape[1] == len(robots) else ""
    return Difference(float(sizes[row, column]), float(time[row]), robot)
