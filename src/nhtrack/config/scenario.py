"""What a scenario file may say: every key, its type, its unit, its bounds.

This model and those of its sections are the single source of the JSON Schema (`nhtrack schema`) and of
docs/scenario.md. They judge one key at a time; what several keys mean together is judged in `nhtrack.config.checks`,
and `nhtrack.config.load` runs both.

"Scenario units" below are whatever length and time unit the file is written in; `similarity` maps them to
metres and seconds. Angles are radians everywhere.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from nhtrack.config.law_sections import Law
from nhtrack.config.link import Delay, Noise
from nhtrack.config.physics import Physics
from nhtrack.config.robot_section import RobotChoice, RobotSection
from nhtrack.config.robots import FollowerSection, LeaderSection
from nhtrack.config.similarity_section import SimilaritySection
from nhtrack.config.values import Backend, RunName
from nhtrack.config.video import Video
from nhtrack.section import Section
from nhtrack.views import drawn_by


class Record(Section):
    """What of a run is kept."""

    every: int = Field(
        default=1,
        ge=1,
        description="every so many control periods a row is kept, and one at the end; what wheels did is then told of "
        "the period before each row only [1]",
    )


class Scenario(Section):
    """One experiment: who moves, by what law, on which ground, for how long."""

    name: RunName = Field(description="names the run and its results folder")
    description: str = Field(default="", description="one line for people, shown by `nhtrack list`")
    duration: float = Field(gt=0, description="how long the run lasts [scenario time]")
    similarity: SimilaritySection = Field(
        default=SimilaritySection(), description="scenario units to metres and seconds"
    )
    backend: Backend = Field(
        default="mujoco",
        description="`mujoco`: wheels, friction, motors; `ideal`: the integrator the theory speaks of",
    )
    robot: RobotChoice = Field(
        default=RobotSection(file="nh_mini"),
        description="a bundled robot, a robot's file relative to the scenario file, or a section that says more of it",
    )
    physics: Physics = Field(default=Physics(), description="how MuJoCo steps")
    control_rate: float = Field(default=100.0, gt=0, description="control periods per second on the robot's clock [Hz]")
    delay: Delay = 0
    noise: Noise = Field(default=Noise(), description="what a law sees amiss of its own robot; drawn from `seed`")
    seed: int = Field(default=0, ge=0, description="seed of the noise, all that is random in a run [1]")
    leader: LeaderSection = Field(description="the root of the network")
    followers: Annotated[tuple[FollowerSection, ...], Field(strict=False, min_length=1)] = Field(
        description="the robots that track others"
    )
    virtual_leader: Literal["convex", "exact"] = Field(
        default="convex",
        description="twist of a virtual leader between several parents: `convex` combines theirs, as the paper prints "
        "it; `exact` differentiates the geodesic between them",
    )
    formation: Literal["printed", "exact"] = Field(
        default="printed",
        description="twist of a leader displaced by `offset`: `printed` as if its attitude stood still, as in the "
        "paper; `exact` with the attitude's motion",
    )
    law: Law = Field(description="the law every follower obeys, with gains in scenario units")
    record: Record = Field(default=Record(), description="what of the run is kept")
    video: Video = Field(default=Video(), description="how the film of the run is made")

    def _repr_html_(self) -> str:
        """Returns what a notebook shows of the scenario."""
        return drawn_by("nhtrack.studies.run.scenario_view.scenario_html", self)

    @property
    def periods(self) -> int:
        """Number of control periods: `duration` on the robot's clock, rounded to whole periods.

        Raises:
            TypeError: see `SimilaritySection.time_scale`.
        """
        return max(1, round(self.duration * self.similarity.time_scale * self.control_rate))

    @property
    def parents(self) -> dict[str, tuple[str, ...]]:
        """Parents of every robot by name, root first; what `nhtrack.network.Network.from_parents` takes."""
        return {self.leader.name: ()} | {follower.name: follower.parents for follower in self.followers}

    @property
    def weights(self) -> dict[str, tuple[float, ...]]:
        """Fold weights of the followers that give them; what `nhtrack.network.Network.from_parents` takes."""
        return {follower.name: follower.weights for follower in self.followers if follower.weights is not None}
