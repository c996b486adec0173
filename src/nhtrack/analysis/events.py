"""What went wrong on wheels, when and for whom: slipping, lifted wheels, robots stuck, leaning, tipped over, touching.

A row of a recording stands for the control period that ends at its time: its wheel loads are means and its utilisation
is the worst over that period. An event therefore begins where the period of its first row begins and ends at the time
of its last row. Rows without a break in which a condition holds are one spell; spells that are too short for their kind
are left out, and those of one robot that are less than `GAP` apart are one event, whichever wheel they are of.

Only wheels on a floor have events: a run on the ideal integrator has none. A condition that compares what is not known
(NaN: a virtual root, telemetry before the first period) does not hold, and a kind whose variables or dimensions a
recording lacks is not looked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nhtrack import se2
from nhtrack.analysis.event import Event, EventKind
from nhtrack.analysis.spells import begins, joined_spells, lasting
from nhtrack.analysis.touches import touches
from nhtrack.recording import COMPONENTS, Recording
from nhtrack.simulation.faults import REASONS, TIPPED_OVER

# Friction utilisation from which a wheel is at its limit: contact forces of a sliding wheel are within 1e-5 of 1.
AT_LIMIT = 0.99
# [m/s] Slip speed from which a wheel at its limit slides. Regularised friction lets a wheel that holds creep at up to
# 1e-6 m/s (docs/fidelity.md); a wheel can be at its limit and yet creep, while the other one holds the axle.
CREEP = 1e-3
# [s] How long a wheel must bear no load and be clear of the floor. Wheels that slide on MuJoCo's own contacts hop, some
# 30 ms at a time, which is a height of g t^2/8 = 1 mm; over a tenth of a second they bear what wheels do that stand.
LIFTED = 0.1
# Share of the wheels' radius above which no wheel hops: one that is as high is off the floor at once.
HIGH = 0.1
# Share of the wheels' radius from which a wheel is clear of the floor.
CLEAR = 0.005
# [s] How long a robot must hardly move. A robot that turns round at its motors' limits does so for some 0.01 s.
STUCK = 0.5
# Share of the speed that motors without load give the wheels, below which a robot hardly moves ...
STILL = 0.02
# ... and above which its wheels spin: then they turn at five times the speed of the ground below them, or more.
SPINNING = 0.1
# Share of a control period from which a motor that its limits cut counts as being there.
CUT = 0.5
# [rad] Tilt from which a robot leans, 5 degrees: hopping wheels that slide at 3 m/s tilt it by 3 or 4 degrees.
LEANING = np.radians(5.0)


def find_events(recording: Recording) -> tuple[Event, ...]:
    """Returns the events of a run, by their start, then in the order of robots and kinds.

    - `slipping`: a wheel at its friction limit (`AT_LIMIT`) that slips faster than `CREEP`; its largest slip speed.
    - `hopping`: a wheel that slides as above, where its loads are not to be trusted: `contact.model: default`, or
      friction that could tip the robot; its largest load.
    - `wheel off the floor`: a wheel that bears no load and is clear of the floor by more than `CLEAR`, for `LIFTED` or
      longer, or as high as `HIGH`; how high it rose. Loads are means over control periods, since the contact forces of
      a sliding wheel chatter from one physics step to the next, and such a wheel hops.
    - `stuck`: a robot that hardly moves for `STUCK` or longer although a wheel spins or a motor is at its limit;
      largest speed at a wheel's rim. Turning on the spot is motion: the way of the axle and that of the wheels about it
      count, over a control period. Slow and fast are shares (`STILL`, `SPINNING`) of the speed that motors without load
      give the wheels, so that robots of any size are measured by what they can do.
    - `leaning`: a tilt beyond `LEANING`; largest tilt.
    - `tipped`: the run ended because the robot tipped over; largest tilt recorded until then.
    - `touched`: two robots in contact; see `nhtrack.analysis.touches`.
    """
    if recording.backend != "mujoco":
        return ()
    rules = [rule for rule in _RULES if rule.is_known(recording)]
    found = [event for part in recording.shares() for rule in rules for event in _events_of(part, rule)]
    found += [*_tipping(recording), *touches(recording)]
    places = {name: place for place, name in enumerate(recording.robots)}
    return tuple(sorted(found, key=lambda event: (event.start, places[event.robot])))


# What is looked for ---------------------------------------------------------------------------------------------------


class Condition(NamedTuple):
    """Where a condition holds and how bad it is there.

    Attributes:
        holds: shape (t, n, 2) for wheels, (t, n, 1) for robots.
        badness: of the worse wheel, shape (t, n).
        sure: where it is an event however short its spell is, of the shape of `holds`; nowhere by default.
    """

    holds: np.ndarray
    badness: np.ndarray
    sure: np.ndarray | None = None


@dataclass(frozen=True)
class EventRule:
    """How events of one kind are told from a recording.

    Attributes:
        kind: the kind of event.
        measure: what the badness is.
        unit: unit of the badness.
        condition: reads the condition from a recording.
        variables: variables that it needs.
        dimensions: of the robot that it needs.
        shortest: how long the condition must hold without a break, unless it is sure [s].
    """

    kind: EventKind
    measure: str
    unit: str
    condition: Callable[[Recording], Condition]
    variables: tuple[str, ...]
    dimensions: tuple[str, ...] = ()
    shortest: float = 0.0

    def is_known(self, recording: Recording) -> bool:
        """Returns whether the recording has what the condition needs."""
        known = not any(np.isnan(getattr(recording.robot, name)) for name in self.dimensions)
        return known and set(self.variables) <= set(recording.dataset.data_vars)


def slip_speed(recording: Recording) -> np.ndarray:
    """Returns the speed of each wheel's contact point where the wheel slides, zero elsewhere [m/s], shape (t, n, 2)."""
    speed = np.hypot(recording["longitudinal_slip"].values, recording["lateral_slip"].values[..., None])
    slips = (recording["friction_utilisation"].values >= AT_LIMIT) & (speed > CREEP)
    return np.where(slips, speed, 0.0)


def wheel_places(recording: Recording) -> np.ndarray:
    """Returns where wheels touch the floor, left and right [m], shape (t, n, 2, 2)."""
    pose, b = recording["pose"].values, recording.robot.half_separation
    across = np.array([[0.0, b], [0.0, -b]])
    return np.asarray(se2.act(pose[:, :, None], np.broadcast_to(across, (*pose.shape[:2], 2, 2))))


def _slipping(recording: Recording) -> Condition:
    speed = slip_speed(recording)
    return Condition(speed > 0, speed.max(axis=-1))


def _hopping(recording: Recording) -> Condition:
    """Returns where wheels slide on friction with which the model does not know their loads, `simulation.sliding`."""
    slides, load = slip_speed(recording) > 0, recording["wheel_load"].values.max(axis=-1)
    if not slides.any():
        return Condition(slides, load)
    friction = recording.scene.ground.friction_at(wheel_places(recording))
    return Condition(slides & (friction >= recording.robot.trusted_friction), load)


def _off_the_floor(recording: Recording) -> Condition:
    clearance = recording["wheel_clearance"].values
    radius, free = recording.robot.wheel_radius, recording["wheel_load"].values <= 0
    clear, high = free & (clearance > CLEAR * radius), free & (clearance > HIGH * radius)
    return Condition(clear, clearance.max(axis=-1), high)


def _stuck(recording: Recording) -> Condition:
    wheel_radius, half_separation, _, no_load_speed, _ = recording.robot
    # Means over the period: velocities of a jammed robot chatter from one physics step to the next.
    x, y, theta = np.moveaxis(np.diff(recording["pose"].values, axis=0, prepend=np.nan), -1, 0)
    moved = np.hypot(x, y) + half_separation * np.abs(theta)
    period = recording.time - begins(recording.time)
    still = moved < STILL * wheel_radius * no_load_speed * period[:, None]
    spin = np.abs(recording["wheel_speed"].values).max(axis=-1)
    cut = recording["torque_saturation"].values.max(axis=-1)
    stuck = still & ((spin > SPINNING * no_load_speed) | (cut > CUT))
    return Condition(stuck[..., None], wheel_radius * spin)


def _leaning(recording: Recording) -> Condition:
    tilt = recording["tilt"].values
    return Condition((tilt > LEANING)[..., None], tilt)


_DRIVE = ("wheel_radius", "half_separation", "no_load_speed")

_RULES = (
    EventRule(
        "slipping", "slip speed", "m/s",
        _slipping, ("friction_utilisation", "longitudinal_slip", "lateral_slip"),
    ),
    EventRule(
        "hopping", "largest load", "N", _hopping,
        ("friction_utilisation", "longitudinal_slip", "lateral_slip", "wheel_load", "pose"),
        ("half_separation", "trusted_friction"),
    ),
    EventRule(
        "wheel off the floor", "height", "m",
        _off_the_floor, ("wheel_load", "wheel_clearance"), ("wheel_radius",), shortest=LIFTED,
    ),
    EventRule(
        "stuck", "rim speed", "m/s",
        _stuck, ("pose", "wheel_speed", "torque_saturation"), _DRIVE, shortest=STUCK,
    ),
    EventRule("leaning", "tilt", "rad", _leaning, ("tilt",)),
)  # fmt: skip


# From conditions to events --------------------------------------------------------------------------------------------


def _events_of(recording: Recording, rule: EventRule) -> list[Event]:
    time, begin = recording.time, begins(recording.time)
    holds, badness, sure = rule.condition(recording)
    wheels = np.zeros_like(holds)
    for place in np.ndindex(holds.shape[1:]):
        each = (slice(None), *place)
        wheels[each] = lasting(holds[each], time, rule.shortest, None if sure is None else sure[each])
    robots: np.ndarray = np.any(wheels, axis=-1)
    return [
        Event(
            rule.kind, robot, _wheel(wheels[rows, i]), float(begin[rows.start]), float(time[rows.stop - 1]),
            rule.measure, float(badness[rows, i].max()), rule.unit,
        )
        for i, robot in enumerate(recording.robots)
        for rows in joined_spells(robots[:, i], time)
    ]  # fmt: skip


def _wheel(holds: np.ndarray) -> str | None:
    """Returns which wheels an event is of, from its rows: shape (k, 2), or (k, 1) for the robot as a whole."""
    if holds.shape[-1] == 1:
        return None
    left, right = COMPONENTS["wheel"]
    return "both" if holds.any(axis=0).all() else (left if holds[:, 0].any() else right)


def _tipping(recording: Recording) -> list[Event]:
    """Returns the event of a robot that tipped over, at the end of the period that was not recorded any more."""
    ended = recording.divergence
    if ended is None or ended.reason != REASONS[TIPPED_OVER]:
        return []
    robot, time = ended.robot, ended.time
    tilt = recording["tilt"][:, recording.robots.index(robot)].values
    return [Event("tipped", robot, None, time, time, "tilt", float(tilt.max()), "rad")]
