"""One law against one family: the scenario of any one start, and the simulation of many."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from nhtrack import se2
from nhtrack.arrays import Array
from nhtrack.config.campaign import Campaign
from nhtrack.config.family_sections import FamilyLeader
from nhtrack.config.law_sections import Law
from nhtrack.config.robots import FollowerSection, LeaderSection, Start
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import Experiment, build, seeds_of
from nhtrack.references import InputSection, Segment, SignalInput
from nhtrack.simulation.state import State
from nhtrack.studies.campaign.draw import REFERENCES, Draw, Pieces, draw_starts

FOLLOWER = "follower"


@dataclass(frozen=True)
class Cell:
    """A law and a family of a campaign whose time scale is a number.

    Attributes:
        campaign: the campaign.
        label: of the law.
        family: its name.
        gains: found by tuning, in place of the law's own.
    """

    campaign: Campaign
    label: str
    family: str
    gains: Mapping[str, float] = field(default_factory=dict)

    @property
    def law(self) -> Law:
        """The law with its gains, and with limits that are the same for all starts and references."""
        law = self.campaign.laws[self.label].model_copy(update=dict(self.gains))
        limits = getattr(law, "limits", None)
        if limits is None:
            return law
        return law.model_copy(update={"limits": limits.model_copy(update={"everywhere": True})})

    @cached_property
    def draw(self) -> Draw:
        """All starts, seen from the leader's."""
        return draw_starts(self.campaign.starts)

    @cached_property
    def family_leader(self) -> FamilyLeader | None:
        """What the leader does, or None where it is something else for every start."""
        return self.campaign.family(self.family)

    @cached_property
    def _leader_start(self) -> Start:
        return Start(pose=(0.0, 0.0, 0.0)) if self.family_leader is None else self.family_leader.start

    @cached_property
    def _poses(self) -> Array:
        """Where followers begin, shape (b, 3) [scenario length, rad]."""
        return se2.compose(np.array(self._leader_start.pose), self.draw.pose)

    @cached_property
    def _pieces(self) -> Pieces | None:
        """Random references, one for each start, or None for a family that has a single one."""
        if self.family_leader is not None:
            return None
        return REFERENCES[self.family](self.campaign.starts, self.campaign.duration, self._period)

    @property
    def _period(self) -> float:
        """Control period [scenario time]."""
        return 1 / (self.campaign.control_rate * self.campaign.similarity.time_scale)

    def scenario(self, *starts: int, virtual: bool = True) -> Scenario:
        """Returns the scenario of some starts, which share the first one's reference; it runs as the campaign did.

        Args:
            *starts: their indices.
            virtual: whether the leader is a marker, as in a campaign, or a robot of its own.
        """
        campaign = self.campaign
        names = [FOLLOWER] if len(starts) == 1 else [f"{FOLLOWER}{start}" for start in starts]
        return Scenario(
            name=f"{campaign.name}-{self.label}-{self.family}-{'-'.join(map(str, starts[:3]))}".replace(" ", "_"),
            duration=campaign.duration,
            similarity=campaign.similarity,
            backend=campaign.backend,
            robot=campaign.robot,
            physics=campaign.physics,
            control_rate=campaign.control_rate,
            delay=campaign.delay,
            noise=campaign.noise,
            seed=self._seed(starts[0]),
            leader=LeaderSection(virtual=virtual, start=self._leader_start, input=self._input(starts[0])),
            followers=tuple(
                FollowerSection(name=name, parents=("leader",), start=self._start(start))
                for name, start in zip(names, starts, strict=True)
            ),
            law=self.law,
        )

    def experiment(self, starts: slice) -> Experiment:
        """Returns the experiment of many starts side by side, arrays of shape (b, 2, ...)."""
        one = build(self.scenario(starts.start))
        pose, twist = self._poses[starts], self.draw.twist[starts]
        rolling = np.stack([twist[:, 0], np.zeros(len(twist)), twist[:, 1]], axis=-1)
        g, xi = (np.repeat(values[None], len(pose), axis=0) for values in (one.start.g, one.start.xi))
        g[:, 1], xi[:, 1] = one.similarity.poses_to_robot(pose), one.similarity.twists_to_robot(rolling)
        inputs = np.repeat(one.inputs[:, None], len(pose), axis=1)
        if self._pieces is not None:
            inputs = one.similarity.inputs_to_robot(self._pieces.sample(len(one.inputs), starts))
        seeds = seeds_of(*(self._seed(starts.start + i) for i in range(len(pose))))
        return replace(one, start=State(0.0, g, xi), inputs=inputs, link=replace(one.link, seeds=seeds))

    def _seed(self, start: int) -> int:
        """Returns the seed of a start's noise."""
        return self.campaign.starts.seed + start

    def _start(self, start: int) -> Start:
        x, y, theta = map(float, self._poses[start])
        v, omega = map(float, self.draw.twist[start])
        return Start(pose=(x, y, theta), twist=(v, omega))

    def _input(self, start: int) -> InputSection:
        """Returns the reference of a start as a scenario has it."""
        if self.family_leader is not None:
            return self.family_leader.input
        assert self._pieces is not None  # the one family without an input of its own
        ends = [float(end * self._period) for end in self._pieces.ends[start]]
        kept = 1 + sum(end < self.campaign.duration for end in ends)
        signals = (
            tuple(Segment(until=end, value=float(value)) for end, value in zip(ends[:kept], values, strict=False))
            for values in self._pieces.values[start].T
        )
        return SignalInput(u_x=next(signals), u_theta=next(signals))
