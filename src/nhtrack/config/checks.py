"""What the keys of a scenario mean together: clocks, graph, input.

The checks read the raw tree and skip what they cannot understand, so that a misspelt gain does not hide a
cycle in the graph: every fault of a file is reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from pydantic import ValidationError

from nhtrack.config.physics import Physics
from nhtrack.config.robots import LeaderSection, Start
from nhtrack.config.scenario import Scenario
from nhtrack.config.similarity_section import SimilaritySection
from nhtrack.config.tree import Path, lookup
from nhtrack.config.video import Video, film_fault
from nhtrack.network import network_faults
from nhtrack.references import ReferenceInputError, input_kind
from nhtrack.section import Finding, is_bounded

Checks = Callable[[Mapping[str, Any], FilePath], Iterator[Finding]]

MOST_PERIODS = 2_000_000  # five and a half hours at 100 Hz; more takes too long to look at beforehand
AUTO_PERIODS = 2000  # where inputs are tried as long as `time: auto` leaves the control periods open
MOST_STEPS = 1e7  # physics steps in a control period; beyond it the schema's bounds have the word
_SAME = 1e-6  # how far a start may be from where the input begins, as a share and at all
INPUT: Path = ("leader", "input")


def findings(tree: Any, directory: FilePath, checks: Checks) -> Iterator[Finding]:
    """Yields what is wrong between the keys of a tree, as path and message.

    Args:
        tree: the raw tree; anything in it may be of the wrong type.
        directory: what relative robot files start from.
        checks: of the robot.
    """
    if not isinstance(tree, Mapping):
        return
    clock = Clock.of(tree)
    yield from clock_findings(clock)
    yield from _network_findings(tree)
    yield from checks(tree, directory)
    yield from input_findings(lookup(tree, INPUT), clock, INPUT)
    yield from _start_findings(lookup(tree, ("leader",)))
    yield from _film_findings(lookup(tree, ("video",)), clock)


def no_checks(tree: Mapping[str, Any], directory: FilePath) -> Iterator[Finding]:
    """Yields nothing."""
    yield from ()


@dataclass(frozen=True)
class Clock:
    """The times a tree gives, None where it gives no positive number; defaults where it gives nothing.

    Attributes:
        duration: [scenario time].
        scale: robot seconds per scenario time unit [s].
        control_rate: [Hz].
        timestep: physics step [s].
    """

    duration: float | None
    scale: float | None
    control_rate: float | None
    timestep: float | None

    @classmethod
    def of(cls, tree: Mapping[str, Any]) -> Clock:
        """Returns the times of a tree."""
        return cls(
            positive(lookup(tree, ("duration",))),
            positive(lookup(tree, ("similarity", "time"), SimilaritySection.model_fields["time"].default)),
            positive(lookup(tree, ("control_rate",), Scenario.model_fields["control_rate"].default)),
            positive(lookup(tree, ("physics", "timestep"), Physics.model_fields["timestep"].default)),
        )

    @property
    def periods(self) -> float | None:
        """Control periods in the duration, not rounded."""
        if self.duration is None or self.scale is None or self.control_rate is None:
            return None
        return self.duration * self.scale * self.control_rate

    @property
    def times(self) -> np.ndarray | None:
        """Scenario times at which the input is sampled: the middles of the periods, shape (periods,).

        Where the time scale is not a number, `AUTO_PERIODS` stand for the periods still unknown.
        """
        periods = self.periods if self.scale is not None else AUTO_PERIODS
        if periods is None or self.duration is None or not 0.999 <= periods <= MOST_PERIODS:
            return None
        return (np.arange(round(periods)) + 0.5) * (self.duration / periods)


def positive(value: Any) -> float | None:
    """Returns a positive finite number as a float, anything else as None."""
    return float(value) if is_bounded(value) and value > 0 else None


def clock_findings(clock: Clock) -> Iterator[Finding]:
    """Yields faults of durations and rates that do not fit each other."""
    rate, timestep = clock.control_rate, clock.timestep
    if rate is not None and timestep is not None:
        steps = 1.0 / timestep / rate
        if steps < MOST_STEPS and (round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps):
            yield ("control_rate",), _rate_message(rate, timestep)
    if clock.periods is None or clock.duration is None or clock.scale is None or rate is None:
        return
    if clock.periods < 0.999:
        seconds = clock.duration * clock.scale
        yield (
            ("duration",),
            f"{seconds:g} s on the robot's clock, less than one control period of {1 / rate:g} s",
        )
    elif clock.periods > MOST_PERIODS:
        yield ("duration",), f"{clock.periods:.3g} control periods; a run has at most {MOST_PERIODS}"


def _rate_message(rate: float, timestep: float) -> str:
    physics_rate = 1.0 / timestep
    if rate > physics_rate:
        return f"{rate:g} Hz is faster than physics ({physics_rate:g} Hz); lower it, or physics.timestep"
    steps = math.floor(physics_rate / rate)
    counts = range(max(1, steps - 50), steps + 50)
    nearest = sorted((physics_rate / n for n in counts), key=lambda near: abs(near - rate))
    offers = " or ".join(f"{near:g}" for near in [near for near in nearest if _exact(near)][:2])
    return (
        f"{rate:g} Hz does not divide the physics rate of {physics_rate:g} Hz, "
        f"the inverse of physics.timestep {timestep:g} s" + (f"; try {offers} Hz" if offers else "")
    )


def _exact(rate: float) -> bool:
    """Returns whether a rate survives being written down with the digits that messages show."""
    return abs(float(f"{rate:g}") - rate) < 1e-9 * rate


def _network_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields faults of names and parents."""
    leader = lookup(tree, ("leader", "name"), LeaderSection.model_fields["name"].default)
    followers = lookup(tree, ("followers",))
    if not isinstance(followers, list) or not isinstance(leader, str):
        return
    parents: dict[str, Sequence[str]] = {leader: ()}
    place: dict[str, int] = {}
    for i, follower in enumerate(followers):
        name = lookup(follower, ("name",))
        if not isinstance(name, str):
            continue
        if name in parents:
            other = "the leader" if name == leader else f"followers[{place[name]}]"
            yield ("followers", i, "name"), f"two robots are called {name!r}: {other} is the other one"
            continue
        place[name] = i
        # A list that cannot be read is the schema's fault to report; for the graph it tracks the leader.
        parents[name] = _names(lookup(follower, ("parents",))) or (leader,)
        given = lookup(follower, ("weights",))
        if isinstance(given, list) and _names(lookup(follower, ("parents",))):
            expected = len(parents[name]) - 1
            if len(given) != expected:
                message = f"expected one weight fewer than parents, {expected} here, got {len(given)}"
                yield ("followers", i, "weights"), message
    # Where a name cannot be read, "no such robot" could blame the line that spells it right.
    every_name_known = all(isinstance(lookup(follower, ("name",)), str) for follower in followers)
    for fault in network_faults(parents):
        if fault.robot in place and (every_name_known or not fault.unknown):
            at: Path = ("followers", place[fault.robot], "parents")
            yield (at if fault.parent is None else (*at, fault.parent)), fault.message


def _names(value: Any) -> tuple[str, ...]:
    """Returns a list of texts as a tuple, anything else as ()."""
    readable = isinstance(value, list) and all(isinstance(item, str) for item in value)
    return tuple(value) if readable else ()


def input_findings(given: Any, clock: Clock, at: Path) -> Iterator[Finding]:
    """Yields faults of an input on the control grid.

    Args:
        given: the raw input.
        clock: the times of the run.
        at: path of the input.
    """
    if isinstance(given, Mapping):
        for path, message in input_kind(given).findings(given, clock.times):
            yield (*at, *path), message


def _start_findings(leader: Any) -> Iterator[Finding]:
    """Yields a start of the leader that is not where its input begins."""
    given = lookup(leader, ("input",))
    try:
        asked = input_kind(given).model_validate(given).start()
        start = Start.model_validate(lookup(leader, ("start",)))
    except (ValidationError, ReferenceInputError, TypeError):
        return  # told where start and input are judged
    for key, expected in zip(("pose", "twist"), asked or (), strict=False):
        if expected is not None and not np.allclose(getattr(start, key), expected, rtol=_SAME, atol=_SAME):
            shown = ", ".join(f"{value:.9g}" for value in expected)
            yield ("leader", "start", key), f"the input begins elsewhere: write {key}: [{shown}], or leave it out"


def _film_findings(video: Any, clock: Clock) -> Iterator[Finding]:
    """Yields a film that is too long."""
    if not isinstance(video, Mapping) or clock.duration is None or clock.scale is None:
        return
    speed, fps = positive(video.get("speed")), positive(video.get("fps", Video.model_fields["fps"].default))
    if fps is not None and (unmade := film_fault(clock.duration * clock.scale, int(fps), speed)):
        yield ("video", "speed"), unmade
