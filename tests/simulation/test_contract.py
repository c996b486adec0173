"""Both simulations keep the contract, and one that breaks it fails."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from drives import DRIVE
from nhtrack.se2 import wrap
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from nhtrack.simulation.state import Simulation, State
from nhtrack.testing import SimulationContract


@cache
def scene(names: tuple[str, ...]) -> Scene:
    return make_scene(SceneSpec(names))


class TestIdealSimulation(SimulationContract):
    def make(self) -> Simulation:
        return IdealSimulation(self.names, DRIVE, self.dt)


@pytest.mark.slow
class TestMujocoSimulation(SimulationContract):
    def make(self) -> Simulation:
        return MujocoSimulation(scene(self.names), self.dt)


class Lent(IdealSimulation):
    """Hands out the arrays that it works on."""

    def step(self, u: np.ndarray) -> State:
        state = super().step(u)
        return state._replace(g=self.motion.g[0])


class Sideways(IdealSimulation):
    """Exchanges x and y, and takes off whole turns."""

    def step(self, u: np.ndarray) -> State:
        state = super().step(u)
        return state._replace(g=np.stack([*state.g.T[[1, 0]], wrap(state.g[:, 2])], axis=-1))


class Lenient(IdealSimulation):
    """Takes whatever it is given."""

    def reset(self, state: State) -> State:
        return super().reset(state._replace(xi=state.xi * [1.0, 0.0, 1.0]))

    def step(self, u: np.ndarray) -> State:
        return super().step(np.nan_to_num(u, posinf=0.0))


@pytest.mark.parametrize(
    ("kind", "broken"),
    [
        (Lent, ["test_the_caller_owns_what_it_got"]),
        (Sideways, ["test_robots_move_the_way_they_point", "test_states_have_the_shape_of_the_start"]),
        (Lenient, ["test_states_that_no_robots_can_have_are_refused",
                   "test_a_command_that_is_not_finite_names_robot_and_time"]),
    ],
)  # fmt: skip
def test_a_simulation_that_breaks_the_contract_fails(kind: type[IdealSimulation], broken: list[str]) -> None:
    class Contract(SimulationContract):
        def make(self) -> Simulation:
            return kind(self.names, DRIVE, self.dt)

    for name in broken:
        with pytest.raises(AssertionError):
            getattr(Contract(), name)()
