"""What an event on wheels is, and how it is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

EventKind = Literal["slipping", "hopping", "wheel off the floor", "stuck", "leaning", "tipped", "touched"]


@dataclass(frozen=True)
class Touch:
    """How two robots touched, beside how fast they closed in.

    Attributes:
        other: name of the other robot.
        contact_time: how long their hulls were in contact within the event [s].
        impulse: of the normal forces between them [N s].
        overlap: how far their hulls overlapped at the most [m].
    """

    other: str
    contact_time: float
    impulse: float
    overlap: float


@dataclass(frozen=True)
class Event:
    """Something that went wrong, once.

    Attributes:
        kind: what happened.
        robot: name of the robot.
        wheel: `left`, `right` or `both`; None where the robot as a whole is meant.
        start: when it began, on the robot's clock [s].
        end: when it ended, or where the recording ends [s].
        measure: what `worst` is.
        worst: how bad it was, in `unit`.
        unit: unit of `worst`.
        touch: of robots that touched each other; `robot` is the one that comes first.
    """

    kind: EventKind
    robot: str
    wheel: str | None
    start: float
    end: float
    measure: str
    worst: float
    unit: str
    touch: Touch | None = None

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots that it happened to."""
        return (self.robot,) if self.touch is None else (self.robot, self.touch.other)


def sentences(events: Sequence[Event]) -> tuple[str, ...]:
    """Returns one sentence for each robot or pair and kind: for how long, since when, how bad.

    Of robots that touched one more says since when there is no comparison with ideal twins, which pass through.
    """
    groups: dict[tuple[tuple[str, ...], EventKind], list[Event]] = {}
    for event in events:
        groups.setdefault((event.robots, event.kind), []).append(event)
    told = [f"{' and '.join(robots)} {_sentence(kind, group)}" for (robots, kind), group in groups.items()]
    touched = first_touch(events)
    if touched is not None:
        told.append(f"robots touched first at {touched:.3g} s: ideal twins pass through, gaps to them are until then")
    return tuple(told)


def first_touch(events: Sequence[Event]) -> float | None:
    """Returns when robots of a run touched first [s], or None."""
    return min((event.start for event in events if event.kind == "touched"), default=None)


_SENTENCES: dict[EventKind, str] = {
    "slipping": "slid: a wheel was at its friction limit for {seconds:.2g} s, first at {first:.3g} s, "
    "sliding at up to {worst:.2g} m/s",
    "hopping": "hopped on wheels that slid: for {seconds:.2g} s, first at {first:.3g} s; what they bear there, "
    "{worst:.3g} N at the most, is MuJoCo's and not Coulomb's (docs/fidelity.md)",
    "wheel off the floor": "lifted {wheels}: off the floor for {seconds:.2g} s, first at {first:.3g} s",
    "stuck": "was stuck: hardly moved for {seconds:.2g} s, first at {first:.3g} s, while its wheels turned at up to "
    "{worst:.2g} m/s at their rims",
    "leaning": "leaned: for {seconds:.2g} s, first at {first:.3g} s, by up to {degrees:.2g} degrees",
    "tipped": "tipped over: at {first:.3g} s; it leaned by {degrees:.2g} degrees in the last row that is recorded",
    "touched": "touched {times}: in contact for {contact:.2g} s, first at {first:.3g} s, closing in at up to "
    "{worst:.2g} m/s, with an impulse of {impulse:.2g} N s, hulls overlapping by up to {overlap:.2g} mm",
}


def _sentence(kind: EventKind, events: Sequence[Event]) -> str:
    worst = max(event.worst for event in events)
    wheels, touches = {event.wheel for event in events}, [event.touch for event in events if event.touch is not None]
    return _SENTENCES[kind].format(
        seconds=sum(event.end - event.start for event in events),
        first=events[0].start,
        worst=worst,
        degrees=np.degrees(worst),
        times={1: "once", 2: "twice"}.get(len(events), f"{len(events)} times"),
        contact=sum(touch.contact_time for touch in touches),
        impulse=sum(touch.impulse for touch in touches),
        overlap=1e3 * max((touch.overlap for touch in touches), default=0.0),
        wheels="its wheels" if len(wheels) > 1 or "both" in wheels else f"its {events[0].wheel} wheel",
    )
