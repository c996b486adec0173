"""What a campaign file may say: which laws meet which references, from how many starts, and what counts as arrival.

A campaign is a scenario with one follower whose law, reference and start vary. The keys that it shares with a scenario
mean the same; everything is in scenario units.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Annotated, Any, TypeAlias

from pydantic import AfterValidator, Field

from nhtrack.config.checks import Checks, Clock, clock_findings
from nhtrack.config.families import DRAWN, SETS
from nhtrack.config.family_findings import family_findings
from nhtrack.config.family_sections import FamilyChoice, FamilyLeader, GridFamily, bundled_leader
from nhtrack.config.law_sections import Law
from nhtrack.config.link import Delay, Noise
from nhtrack.config.physics import Physics
from nhtrack.config.robot_section import RobotChoice, RobotSection
from nhtrack.config.similarity_section import SimilaritySection
from nhtrack.config.tree import lookup
from nhtrack.config.values import Backend, RunName
from nhtrack.errors import did_you_mean
from nhtrack.section import Finding, Section, fault, is_bounded
from nhtrack.settling import HEADING, POSITION

_LABEL = re.compile(r"[A-Za-z][A-Za-z0-9_ -]{0,39}\Z")  # it names files


class Starts(Section):
    """Where followers begin: a disc around the leader, seen from which x points ahead."""

    count: int = Field(default=1000, ge=1, le=1_000_000, description="starts for every law and family [1]")
    seed: int = Field(
        default=0, ge=0, description="seed of the starts, of `random` and `random-walk`, and of `noise` [1]"
    )
    radius: float = Field(default=10.0, ge=0, description="radius of the disc [scenario length]")
    speed: float = Field(default=1.0, ge=0, description="largest |v| [scenario length/time]")
    turning: float = Field(default=1.0, ge=0, description="largest |omega| [rad/scenario time]")
    special: float = Field(
        default=0.1,
        ge=0,
        le=1,
        description="share of starts that are special: on the leader, with any heading and turned round by pi; heading "
        "opposite to the leader's; on its axis; half of each at rest [1]",
    )


class Arrival(Section):
    """When a follower has settled: its errors stay this small until the end."""

    position: float = Field(default=POSITION, gt=0, description="largest distance from the place [scenario length]")
    heading: float = Field(default=HEADING, gt=0, description="largest heading error [rad]")
    last: float = Field(default=15.0, gt=0, description="how long before the end it counts [scenario time]")


class TuningSection(Section):
    """Gains that are searched before a law is tried, anew for every family, as `nhtrack tune` does."""

    laws: Annotated[tuple[str, ...], Field(strict=False, min_length=1)] = Field(description="labels of these laws")
    budget: int = Field(default=256, ge=8, description="sets of gains tried for every law and family [1]")
    starts: int = Field(default=8, ge=1, le=100, description="followers of the run that is tuned [1]")
    seed: int = Field(default=1, ge=0, description="seed of their starts, and of the search [1]")


def _label(text: str) -> str:
    if not _LABEL.match(text):
        raise fault(f"expected a letter and up to 39 letters, digits, spaces, '-' or '_', got {text!r}")
    return text


def _members(family: Any) -> tuple[Any, ...]:
    return SETS.get(family, (family,)) if isinstance(family, str) else (family,)


def _with_sets(families: tuple[Any, ...]) -> tuple[Any, ...]:
    """Returns families with the members of sets in place of their names."""
    return tuple(member for family in families for member in _members(family))


Label: TypeAlias = Annotated[str, AfterValidator(_label)]


class Campaign(Section):
    """Laws against references from many random starts."""

    name: RunName = Field(description="names the campaign and its results folder")
    description: str = Field(default="", description="one line for people, shown by `nhtrack list`")
    duration: float = Field(default=80.0, gt=0, description="how long every run lasts [scenario time]")
    similarity: SimilaritySection = Field(
        default=SimilaritySection(),
        description="scenario units to metres and seconds; `time: auto` takes the smallest at which every family's "
        "leader and `probes` followers fit under the first law, without its limits",
    )
    backend: Backend = Field(
        default="ideal", description="`ideal`: the integrator the theory speaks of; `mujoco`: wheels and friction"
    )
    robot: RobotChoice = Field(
        default=RobotSection(file="nh_mini"),
        description="a bundled robot, a robot's file relative to the campaign's, or a section that says more of it",
    )
    physics: Physics = Field(default=Physics(), description="how MuJoCo steps")
    control_rate: float = Field(default=100.0, gt=0, description="control periods per second on the robot's clock [Hz]")
    delay: Delay = 0
    noise: Noise = Field(
        default=Noise(),
        description="what a law sees amiss of its own robot; start i has that of a scenario with the seed "
        "`starts.seed` + i",
    )
    laws: Annotated[dict[Label, Law], Field(min_length=1)] = Field(
        description="the laws by the labels that tables call them by, gains in scenario units"
    )
    families: Annotated[
        tuple[FamilyChoice, ...], Field(strict=False, min_length=1), AfterValidator(_with_sets)
    ] = Field(
        default=SETS["slow"],
        description="the references: names of bundled ones; `slow` or `quick`, which mean all of a set; or sections",
    )
    starts: Starts = Field(default=Starts(), description="where followers begin")
    arrival: Arrival = Field(default=Arrival(), description="what counts as converged")
    tuning: TuningSection | None = Field(
        default=None, description="gains to be searched first; null takes them as they are"
    )
    probes: int = Field(default=24, ge=1, le=200, description="starts that `time: auto` looks at, for every family [1]")

    @property
    def family_names(self) -> tuple[str, ...]:
        """Names of the families, in order, and of the points of grids."""
        return tuple(name for each in self.families for name in ((each,) if isinstance(each, str) else each.names))

    @property
    def grids(self) -> tuple[GridFamily, ...]:
        """The families over grids."""
        return tuple(family for family in self.families if isinstance(family, GridFamily))

    def family(self, name: str) -> FamilyLeader | None:
        """Returns the leader of a family, or of a point of a grid; None where it is another one for every start."""
        own = next((each for each in self.families if not isinstance(each, str) and name in each.names), None)
        if own is not None:
            return own.leader(name)
        return None if name in DRAWN else bundled_leader(name)

    @property
    def tuned_at(self) -> dict[str, str]:
        """At which family gains for each are tuned: for the points of a grid, at the one in the middle."""
        return {name: name for name in self.family_names} | {
            name: grid.middle for grid in self.grids for name in grid.names
        }

    @property
    def periods(self) -> int:
        """Control periods of a run.

        Raises:
            TypeError: see `SimilaritySection.time_scale`.
        """
        return max(1, round(self.duration * self.similarity.time_scale * self.control_rate))


def campaign_findings(tree: Any, directory: FilePath, checks: Checks) -> Iterator[Finding]:
    """Yields what is wrong between the keys of a campaign's tree; see `nhtrack.config.checks.findings`."""
    if not isinstance(tree, Mapping):
        return
    clock = Clock.of({"duration": Campaign.model_fields["duration"].default, **tree})
    yield from clock_findings(clock)
    yield from checks(tree, directory)
    yield from _arrival_findings(tree, clock)
    yield from _tuning_findings(tree)
    yield from family_findings(tree, clock)


def _arrival_findings(tree: Mapping[str, Any], clock: Clock) -> Iterator[Finding]:
    last = lookup(tree, ("arrival", "last"), Arrival.model_fields["last"].default)
    if clock.duration is not None and is_bounded(last) and last > clock.duration:
        yield ("arrival", "last"), f"{last:g} is longer than a run, which lasts {clock.duration:g}"


def _tuning_findings(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields labels to be tuned that no law has."""
    laws, wanted = lookup(tree, ("laws",)), lookup(tree, ("tuning", "laws"))
    if not isinstance(laws, Mapping) or not isinstance(wanted, list):
        return
    for i, label in enumerate(wanted):
        if isinstance(label, str) and label not in laws:
            yield ("tuning", "laws", i), f"no law labelled {label!r}; {did_you_mean(label, tuple(laws))}"
