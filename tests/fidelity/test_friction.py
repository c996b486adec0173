"""Friction alone holds the robots: without it, at its limit, and what must not happen below it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import brentq

from motions import AT_REST, Run, drive, make_simulation, state
from nhtrack.errors import SimulationDiverged
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.contact import FrictionRow
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.simulation.state import State
from tolerances import (
    BREAK_AWAY,
    CREEP,
    MOTOR_BALANCE,
    TURNING_SLIP,
    UTILISATION,
)

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]

ONE = SceneSpec(("robot",))


class TestTurningSlip:
    """MuJoCo leaves the rate of the contact frame out of its rows: a turning wheel slides at v omega / b."""

    def test_law_in_mujocos_own_reading(self) -> None:
        """The same by `mj_step` alone, velocity and heading taken as MuJoCo pairs them."""
        scene = make_scene(replace(ONE, rate_correction=False))
        model, data, at = scene.model, mujoco.MjData(scene.model), scene.addresses
        model.geom_solref[at.tyres.ravel()] = 0.01, 1
        pose, twist = np.zeros((1, 3)), np.array([[0.3, 0.0, 2.0]])
        data.qpos, data.qvel = scene.qpos_of(pose, np.zeros((1, 2))), scene.qvel_of(pose, twist)
        for _ in range(200):
            v, omega = np.hypot(*data.qvel[at.root_qvel[0] :][:2]), data.qvel[at.root_qvel[0] + 5]
            zero = np.zeros(())
            data.ctrl[at.motors[0]] = scene.drive.wheel_torques(v, omega, zero, zero)
            mujoco.mj_step(model, data)
        v_x, v_y = data.qvel[at.root_qvel[0] :][:2]
        w, z = data.qpos[at.root_qpos[0] + 3], data.qpos[at.root_qpos[0] + 6]
        theta = 2 * np.arctan2(z, w)
        lateral, forward = (
            np.cos(theta) * v_y - np.sin(theta) * v_x,
            np.cos(theta) * v_x + np.sin(theta) * v_y,
        )
        expected = -forward * omega / FrictionRow.of(model, int(at.tyres[0, 0])).damping
        assert lateral == pytest.approx(expected, rel=TURNING_SLIP)


Motion = tuple[float, float, float, float]  # v, omega, u_x, u_theta


@dataclass(frozen=True)
class Manoeuvre:
    """A motion that asks for more friction the larger its parameter s; friction coefficient, duration [s]."""

    motion: Callable[[float], Motion]
    friction: float
    duration: float
    largest: float

    def arrays(self, s: float) -> tuple[np.ndarray, ...]:
        return tuple(np.array(float(value)) for value in self.motion(s))


MANOEUVRES = {
    "speeding up": Manoeuvre(lambda s: (0, 0, s, 0), 0.15, 0.05, 5.0),
    "braking": Manoeuvre(lambda s: (0.5, 0, -s, 0), 0.15, 0.05, 5.0),
    "turning": Manoeuvre(lambda s: (0.3, s, 0, 0), 0.2, 0.2, 20.0),
    "spinning up": Manoeuvre(lambda s: (0, 0, 0, s), 0.1, 0.01, 80.0),
}
SEEN = ("lateral_slip", "longitudinal_slip", "friction_utilisation", "torque_saturation", "wheel_load")


def run_side_by_side(manoeuvre: Manoeuvre, parameters: np.ndarray) -> Run:
    """Returns a batch of runs, one for each parameter."""
    v, omega, u_x, u_theta = (
        np.array(column) for column in zip(*map(manoeuvre.arrays, parameters), strict=True)
    )
    xi = np.stack([v, np.zeros_like(v), omega], axis=-1)[:, None]
    simulation = make_simulation(replace(ONE, friction=manoeuvre.friction), dt=0.01, batch=(len(parameters),))
    u = np.stack([u_x, u_theta], axis=-1)[:, None]
    periods = round(manoeuvre.duration / 0.01)
    run = drive(simulation, np.broadcast_to(u, (periods, *u.shape)), State(0.0, np.zeros_like(xi), xi), SEEN)
    assert not run.telemetry["torque_saturation"].any()
    return run


def largest_utilisation(model: DiffDrive, manoeuvre: Manoeuvre, s: float) -> float:
    return float(model.friction_utilisation(*manoeuvre.arrays(s), manoeuvre.friction).max())


def sideways_reserve(model: DiffDrive, manoeuvre: Manoeuvre, s: float) -> float:
    """What the two wheels together can still bear sideways [N], each within its own Coulomb circle."""
    motion = manoeuvre.arrays(s)
    wrench, load = model.ground_wrench(*motion), model.wheel_loads(*motion)
    forward = (wrench.f_x + np.array([-1, 1]) * wrench.tau / model.half_separation) / 2
    circle = (manoeuvre.friction * load) ** 2 - forward**2
    return float((np.sign(circle) * np.sqrt(np.abs(circle))).sum() - abs(wrench.f_y))


@pytest.mark.parametrize("name", MANOEUVRES)
def test_break_away(name: str) -> None:
    """A wheel reaches its limit where the reduced model says and passes side force on to the other.

    When both are there the axle slides.
    """
    manoeuvre, model = MANOEUVRES[name], make_scene(ONE).drive
    one = brentq(lambda s: largest_utilisation(model, manoeuvre, s) - 1, 1e-3, manoeuvre.largest)
    both = brentq(lambda s: sideways_reserve(model, manoeuvre, s), 1e-3, manoeuvre.largest)
    below, above = 1 - BREAK_AWAY, 1 + BREAK_AWAY
    parameters = np.array([0.5 * one, below * one, above * one, below * both, above * both])
    telemetry = run_side_by_side(manoeuvre, parameters).telemetry
    used = telemetry["friction_utilisation"][-1, :, 0].max(axis=-1)
    expected = [largest_utilisation(model, manoeuvre, s) for s in parameters[:2]]
    np.testing.assert_allclose(used[:2], expected, rtol=0, atol=UTILISATION)
    assert used[1] < 1
    assert used[2] == pytest.approx(1, abs=CREEP)  # a Coulomb force does not leave its cone
    forward, sideways = (telemetry[f"{kind}_slip"][-1, :, 0] for kind in ("longitudinal", "lateral"))
    slip = np.hypot(np.abs(forward).max(axis=-1), sideways)
    assert slip[3] < CREEP
    assert slip[4] > 10 * CREEP


class TestMotors:
    def test_what_the_motors_cannot_give_is_recorded(self) -> None:
        simulation = make_simulation(ONE, dt=0.01)
        motor = simulation.drive.motor
        inputs = np.tile([[[6.0, 0.0]]], (10, 1, 1))
        seen = ("torque_saturation", "wheel_torque", "wheel_torque_demand")
        run = drive(simulation, inputs, AT_REST, seen)
        assert (run.telemetry["torque_saturation"][1:] == 1).all()
        np.testing.assert_array_equal(run.telemetry["wheel_torque"][1:], motor.torque_limit)
        assert (run.telemetry["wheel_torque_demand"] > motor.torque_limit).all()
        possible = simulation.drive.acceleration(*run.xi[-1, 0, [0, 2]], np.full(2, motor.torque_limit))
        gained = (run.xi[-1] - run.xi[4]) / (run.time[-1] - run.time[4])
        np.testing.assert_allclose(gained[0, [0, 2]], possible, rtol=0, atol=MOTOR_BALANCE)


class TestDivergence:
    def test_a_robot_that_tips_is_named_with_its_time(self) -> None:
        """v omega = 36 m/s^2 is more than g b/h = 19.5 m/s^2, and friction 3 holds the wheels to it."""
        simulation = make_simulation(SceneSpec(("calm", "wild"), friction=3.0), dt=0.01)
        start = state(((0, 0, 0), (0, 0)), ((1, 0, 0), (2.4, 15)))
        with pytest.raises(SimulationDiverged, match="tipped over: robot 'wild'") as caught:
            drive(simulation, np.zeros((100, 2, 2)), start)
        assert caught.value.robot == "wild"
        assert 0 < caught.value.time < 1
        assert caught.value.batch == 0

    def test_in_a_batch_the_simulation_is_named_too(self) -> None:
        simulation = make_simulation(replace(ONE, friction=3.0), dt=0.01, batch=(3,))
        xi = np.array([[[0.0, 0, 0]], [[2.4, 0, 15]], [[0.1, 0, 0]]])
        with pytest.raises(SimulationDiverged, match="tipped over") as caught:
            drive(simulation, np.zeros((100, 3, 1, 2)), State(0.0, np.zeros_like(xi), xi))
        assert caught.value.batch == 1
