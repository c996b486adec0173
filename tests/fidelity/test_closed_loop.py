"""Example 3 on wheels from both sides of the antipode, and the contract of the simulation on wheels."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from nhtrack.simulation.state import State
from nhtrack.studies.run.run import simulate
from nhtrack.testing import SimulationContract
from tolerances import TWIN_HEADING_REGRESSION

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]


def record(name: str, **changes: float) -> Recording:
    """Returns the recording of a bundled scenario that ran to its end."""
    outcome = simulate(load(name).model_copy(update=changes))
    assert outcome.failure is None
    return outcome.recording


def test_pi_and_minus_pi_turn_opposite_ways_on_wheels_too() -> None:
    """One pose, two initial conditions: the runs are each other's mirror images."""
    one, other = (
        record(f"paper/example3_{start}", duration=1.0)["pose"].sel(robot="follower")
        for start in ("pi", "minus_pi")
    )
    turned = [float(run[-1, 2] - run[0, 2]) for run in (one, other)]
    assert turned[0] < -1
    assert turned[1] > 1
    aside = [float(run[:, 1].values[np.abs(run[:, 1].values).argmax()]) for run in (one, other)]
    assert aside[0] * aside[1] < 0
    np.testing.assert_allclose(one * [1, -1, -1], other, rtol=0, atol=TWIN_HEADING_REGRESSION)


@cache
def scene(virtual_root: bool) -> Scene:
    return make_scene(SceneSpec(SimulationContract.names, virtual_root=virtual_root))


@pytest.mark.parametrize("virtual_root", [False, True], ids=["real", "virtual"])
@pytest.mark.parametrize("batch", [(), (3,)], ids=["single", "batch"])
def test_batches_and_virtual_roots(batch: tuple[int, ...], virtual_root: bool) -> None:
    """Shapes, clock, and telemetry that has the names and shapes of the ideal simulation's, NaN for a virtual root."""
    simulation, one = MujocoSimulation(scene(virtual_root), 0.01, batch), SimulationContract().start()
    ideal = IdealSimulation(simulation.names, simulation.drive, 0.01)
    start = State(2.0, np.tile(one.g, (*batch, 1, 1)), np.tile(one.xi, (*batch, 1, 1)))
    for each in (simulation, ideal):
        placed = each.reset(start)
        np.testing.assert_array_equal(placed.g, start.g)  # headings unwrapped
        np.testing.assert_array_equal(placed.xi, start.xi)
        now = each.step(np.full((*batch, 3, 2), 0.2))
        assert now.t == pytest.approx(2.01)
        assert now.g.shape == now.xi.shape == start.g.shape
    assert simulation.qpos.shape == (*batch, simulation.scene.model.nq)
    seen, expected = simulation.telemetry(), ideal.telemetry()
    assert seen.keys() == expected.keys()
    for name, values in seen.items():
        assert values.shape == expected[name].shape, name
        bodies = np.moveaxis(values, len(batch), 0)
        assert np.isfinite(bodies[1:]).all(), name
        assert np.isnan(bodies[0]).all() == virtual_root, name


@pytest.mark.parametrize("dt", [0.0105, 0.0005, 0.0])
def test_a_period_is_a_whole_number_of_steps(dt: float) -> None:
    with pytest.raises(ValueError, match=r"not a whole number of physics steps of 0\.001 s"):
        MujocoSimulation(scene(False), dt)
