"""Example 3 on wheels from both sides of the antipode, and the contract of the simulation on wheels."""

from __future__ import annotations

import numpy as np
import pytest

from motions import make_simulation, state
from nhtrack.experiment.load import load
from nhtrack.recording import COMPONENTS, VARIABLES, Recording
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.simulation.state import State
from nhtrack.studies.run.run import simulate
from tolerances import TWIN_HEADING_REGRESSION

pytestmark = pytest.mark.slow

def record(name: str, **changes: float) -> Recording:
    """Returns the recording of a bundled scenario that ran to its end."""
    outcome = simulate(load(name).model_copy(update=changes))
    assert outcome.failure is None
    return outcome.recording


def test_pi_and_minus_pi_turn_opposite_ways_on_wheels_too() -> None:
    """One pose, two initial conditions: the runs are each other's mirror images."""
    one, other = (
        record(f"paper/example3_{start}", duration=3.0)["pose"].sel(robot="follower")
        for start in ("pi", "minus_pi")
    )
    turned = [float(run[-1, 2] - run[0, 2]) for run in (one, other)]
    assert turned[0] < -1
    assert turned[1] > 1
    aside = [float(run[:, 1].values[np.abs(run[:, 1].values).argmax()]) for run in (one, other)]
    assert aside[0] * aside[1] < 0
    np.testing.assert_allclose(one * [1, -1, -1], other, rtol=0, atol=TWIN_HEADING_REGRESSION)


@pytest.mark.parametrize("virtual_root", [False, True], ids=["real", "virtual"])
@pytest.mark.parametrize("batch", [(), (3,)], ids=["single", "batch"])
class TestContract:
    NAMES = ("root", "f1", "f2")

    @pytest.fixture
    def simulation(self, virtual_root: bool, batch: tuple[int, ...]) -> MujocoSimulation:
        return make_simulation(SceneSpec(self.NAMES, virtual_root=virtual_root), 0.01, batch)

    @pytest.fixture
    def start(self, batch: tuple[int, ...]) -> State:
        one = state(((0, 0, 0), (0.1, 0.5)), ((1, 0, 4.0), (0, 0)), ((0, 1, -7.0), (0.2, -1)))
        return State(2.0, np.zeros((*batch, 3, 3)) + one.g, np.zeros((*batch, 3, 3)) + one.xi)

    def test_reset_places_robots_where_it_is_told(self, simulation: MujocoSimulation, start: State) -> None:
        placed = simulation.reset(start)
        assert placed.t == start.t
        np.testing.assert_array_equal(placed.g, start.g)  # headings unwrapped, 4 and -7 rad
        np.testing.assert_array_equal(placed.xi, start.xi)

    def test_states_are_the_callers_to_keep(self, simulation: MujocoSimulation, start: State) -> None:
        given, u = State(start.t, start.g.copy(), start.xi.copy()), np.full((*start.g.shape[:-1], 2), 0.2)
        placed = simulation.reset(given)
        given.g[...], given.xi[...] = 99, 99  # must not reach the simulation
        held = State(placed.t, placed.g.copy(), placed.xi.copy())
        first = simulation.step(u)
        kept = first.g.copy(), first.xi.copy()
        placed.g[...] = -99
        u[...] = 99
        second = simulation.step(np.full_like(u, 0.2))
        np.testing.assert_array_equal(held.g, start.g)
        np.testing.assert_array_equal(first.g, kept[0])
        np.testing.assert_array_equal(first.xi, kept[1])
        assert np.abs(second.g - start.g).max() < 0.1

    def test_clock_and_shapes(self, simulation: MujocoSimulation, start: State) -> None:
        simulation.reset(start)
        for period in (1, 2, 3):
            now = simulation.step(np.zeros((*start.g.shape[:-1], 2)))
            assert now.t == pytest.approx(2.0 + 0.01 * period)
            assert now.g.shape == now.xi.shape == start.g.shape
        assert simulation.qpos.shape == (*start.g.shape[:-2], simulation.scene.model.nq)

    def test_telemetry_is_the_ideal_simulations(
        self, simulation: MujocoSimulation, start: State, virtual_root: bool
    ) -> None:
        """The same names and shapes from both simulations, so that a recording need not ask which one ran."""
        ideal = IdealSimulation(self.NAMES, simulation.drive, 0.01)
        for each in (simulation, ideal):
            each.reset(start)
            each.step(np.full((*start.g.shape[:-1], 2), 0.2))
        seen, expected = simulation.telemetry(), ideal.telemetry()
        assert seen.keys() == expected.keys()
        for name, values in seen.items():
            components = tuple(len(COMPONENTS[dim]) for dim in VARIABLES[name].dims)
            assert values.shape == expected[name].shape == (*start.g.shape[:-1], *components), name
            bodies = values.reshape(-1, 3, *components)
            assert np.isfinite(bodies[:, 1:]).all(), name
            assert np.isnan(bodies[:, 0]).all() == virtual_root, name

    def test_telemetry_is_the_callers_to_keep(self, simulation: MujocoSimulation, start: State) -> None:
        simulation.reset(start)
        simulation.step(np.full((*start.g.shape[:-1], 2), 0.2))
        seen = simulation.telemetry()
        kept = {name: values.copy() for name, values in seen.items()}
        simulation.step(np.full((*start.g.shape[:-1], 2), -0.7))
        for name, values in seen.items():
            np.testing.assert_array_equal(values, kept[name], err_msg=name)

    def test_lateral_velocity_is_refused(self, simulation: MujocoSimulation, start: State) -> None:
        start.xi[..., 1, 1] = 0.1
        with pytest.raises(ValueError, match="v_y must be zero"):
            simulation.reset(start)


@pytest.mark.parametrize("dt", [0.0105, 0.0005, 0.0])
def test_a_period_is_a_whole_number_of_steps(dt: float) -> None:
    with pytest.raises(ValueError, match=r"not a whole number of physics steps of 0\.001 s"):
        MujocoSimulation(make_scene(SceneSpec(("a",))), dt)
