"""The ideal integrator against scipy, against itself, and against the contract of a simulation."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tolerances as tol
from angles import ANY_ANGLES, poses, twists
from drives import DRIVE
from nhtrack.errors import SimulationDiverged
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive.losses import WheelLosses
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State

pytestmark = pytest.mark.property


class Motion(NamedTuple):
    """One robot over one control period of dt [s]: pose (3,), twist (3,), input (2,)."""

    g: np.ndarray
    xi: np.ndarray
    u: np.ndarray
    dt: float

    @property
    def reach(self) -> float:
        """Bound on the length of the path [m]."""
        return self.dt * (abs(self.xi[0]) + self.dt * abs(self.u[0]))

    @property
    def position_rounding(self) -> float:
        """What adding a path to a position and rotating it by a rounded heading may cost [m]."""
        turned = self.dt * (abs(self.xi[2]) + self.dt * abs(self.u[1]))
        size = math.hypot(self.g[0], self.g[1]) + self.reach
        return size * tol.ALGEBRA + self.reach * tol.ANGLE_SUM * (abs(self.g[2]) + turned)

    @property
    def heading_rounding(self) -> float:
        """What adding up the terms of a heading may cost [rad]."""
        turned = self.dt * (abs(self.xi[2]) + self.dt * abs(self.u[1]))
        return tol.ANGLE_SUM * (abs(self.g[2]) + turned)


def motions() -> list[Motion]:
    """Motions of any size that turn less than pi in the period, from any pose, and one that turns by all of it."""
    rng = np.random.default_rng(6)
    found = [Motion(np.array([0.0, 0.0, math.pi]), np.array([1.0, 0.0, -3.0]), np.array([1.0, 3.0]), 1.0)]
    for g, (v, u_x, _), turns in zip(poses(7), twists(8)[::3], rng.uniform(-2, 2, (len(ANY_ANGLES), 2)), strict=False):
        dt = 10 ** rng.uniform(-4, 0)
        found.append(Motion(g, np.array([v, 0.0, turns[0] / dt]), np.array([u_x / dt, turns[1] / dt**2]), dt))
    return found


def scipy_flow(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Pose and twist after the period by DOP853, the position counted from where it begins."""

    def rate(_: float, y: np.ndarray) -> list[float]:
        theta, v, omega = y[2], y[3], y[4]
        return [v * math.cos(theta), v * math.sin(theta), omega, motion.u[0], motion.u[1]]

    begin = [0.0, 0.0, motion.g[2], motion.xi[0], motion.xi[2]]
    absolute = 1e-13 * np.array([motion.reach, motion.reach, 1.0, motion.reach / motion.dt, 1 / motion.dt])
    solution = solve_ivp(rate, (0.0, motion.dt), begin, method="DOP853", rtol=1e-12, atol=absolute + 1e-300)
    x, y, theta, v, omega = solution.y[:, -1]
    return np.array([motion.g[0] + x, motion.g[1] + y, theta]), np.array([v, 0.0, omega])


def step_ideal(motion: Motion) -> State:
    simulation = IdealSimulation(("robot",), DRIVE, motion.dt)
    simulation.reset(State(0.0, motion.g[None], motion.xi[None]))
    return simulation.step(motion.u[None])


# -- the flow ---------------------------------------------------------------------------------------


def test_step_equals_scipy() -> None:
    for motion in motions():
        g, xi = scipy_flow(motion)
        state = step_ideal(motion)
        offset = np.abs(state.g[0] - g)
        assert offset[:2].max() <= tol.DOP853 * motion.reach + motion.position_rounding
        assert offset[2] <= tol.DOP853 + motion.heading_rounding
        assert np.abs(state.xi[0] - xi)[0] <= tol.DOP853 * motion.reach / motion.dt
        assert np.abs(state.xi[0] - xi)[2] <= tol.DOP853 / motion.dt
        assert state.xi[0, 1] == 0.0


# -- batches ----------------------------------------------------------------------------------------


def test_batched_simulation_is_exactly_its_members() -> None:
    rng = np.random.default_rng(1)
    g, xi = rng.uniform(-3, 3, (4, 2, 3)), rng.uniform(-1, 1, (4, 2, 3)) * [1, 0, 1]
    inputs = rng.uniform(-2, 2, (20, 4, 2, 2))
    batch = IdealSimulation(("a", "b"), DRIVE, 0.01)
    batch.reset(State(0.0, g, xi))
    last, telemetry = [batch.step(u) for u in inputs][-1], batch.telemetry()
    for member in range(4):
        single = IdealSimulation(("a", "b"), DRIVE, 0.01)
        single.reset(State(0.0, g[member], xi[member]))
        alone = [single.step(u) for u in inputs[:, member]][-1]
        np.testing.assert_array_equal(last.g[member], alone.g)
        np.testing.assert_array_equal(last.xi[member], alone.xi)
        for name, values in single.telemetry().items():
            np.testing.assert_array_equal(telemetry[name][member], values, err_msg=name)


@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning", "ignore:invalid value:RuntimeWarning")
def test_divergence_in_a_batch_names_the_simulation() -> None:
    """A finite command, the largest double: so fast is no robot."""
    simulation = IdealSimulation(("a", "b"), DRIVE, 1.0)
    simulation.reset(State(0.0, np.zeros((3, 2, 3)), np.zeros((3, 2, 3))))
    u = np.zeros((3, 2, 2))
    u[2, 1, 0] = np.finfo(float).max
    with pytest.raises(SimulationDiverged, match=r"ran away: robot 'b' at t = 1\.000 s \(simulation 2\)"):
        simulation.step(u)


@pytest.mark.parametrize(("began", "size", "reach"), [(2.0, 0.5, 2000.0), (2.0, 3.0, 3000.0), (0.0, 1.0, 1000.0)])
@pytest.mark.parametrize("keep_going", [False, True])
def test_a_robot_is_lost_a_thousand_times_as_far_off_as_it_began(
    began: float, size: float, reach: float, keep_going: bool
) -> None:
    """From the leader, wherever that is by now; or a thousand times as far as the scenario is large."""
    simulation = IdealSimulation(("a", "b"), DRIVE, 1.0, keep_going=keep_going, size=size)
    g, xi = np.zeros((2, 2, 3)), np.zeros((2, 2, 3))
    g[..., 0] = 1e6, 1e6 + began
    xi[:, 0, 0] = 5e5
    xi[:, 1, 0] = 5e5 - began + reach * np.array([0.999, 1.001])
    simulation.reset(State(0.0, g, xi))
    u = np.zeros((2, 2, 2))
    if keep_going:
        state = simulation.step(u)
        assert simulation.lost.tolist() == [False, True]
        np.testing.assert_array_equal(state.g[1], g[1])
        return
    with pytest.raises(SimulationDiverged, match=r"ran away: robot 'b' at t = 1\.000 s \(simulation 1\)"):
        simulation.step(u)


@pytest.mark.parametrize("losses", [WheelLosses(), WheelLosses((1e-3, 2e-3), (0.01, 0.02))])
def test_telemetry_is_what_the_reduced_model_says(losses: WheelLosses) -> None:
    """Torques, speeds and loads of the twist at the end of the period; utilisation of the worse of its ends."""
    drive = replace(DRIVE, losses=losses)
    simulation = IdealSimulation(("robot",), drive, 0.1, Ground(0.5))
    u = np.array([[0.4, -3.0]])
    begun = simulation.reset(State(0.0, np.zeros((1, 3)), np.array([[0.3, 0.0, 2.0]])))
    state = simulation.step(u)
    motion = (state.xi[:, 0], state.xi[:, 2], u[:, 0], u[:, 1])
    told = simulation.telemetry()
    np.testing.assert_allclose(told["wheel_torque"], drive.wheel_torques(*motion), rtol=tol.ROUNDED_SUM)
    np.testing.assert_allclose(told["wheel_speed"], drive.wheel_speeds(motion[0], motion[1]), rtol=tol.ROUNDED_SUM)
    np.testing.assert_allclose(told["wheel_load"], drive.wheel_loads(*motion), rtol=tol.ROUNDED_SUM)
    before = drive.friction_utilisation(begun.xi[:, 0], begun.xi[:, 2], u[:, 0], u[:, 1], 0.5)
    predicted = np.maximum(before, drive.friction_utilisation(*motion, 0.5))
    np.testing.assert_allclose(told["friction_utilisation_predicted"], predicted, rtol=tol.ROUNDED_SUM)
    assert (predicted > 0).all()


@pytest.mark.parametrize(("u_theta", "saturated"), [(0.0, 0.0), (500.0, 1.0)])
def test_telemetry_says_where_motors_would_saturate(u_theta: float, saturated: float) -> None:
    simulation = IdealSimulation(("robot",), DRIVE, 0.001)
    simulation.reset(State(0.0, np.zeros((1, 3)), np.zeros((1, 3))))
    simulation.step(np.array([[0.0, u_theta]]))
    np.testing.assert_array_equal(simulation.telemetry()["torque_saturation"], [[saturated, saturated]])
