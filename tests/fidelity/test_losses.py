"""Losses at the wheel joints: compensated, they leave the drive as exact as without; alone, they are the textbook's."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lossy import Loss, write_lossy
from nhtrack.effects.motors import Motors
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.state import State
from nhtrack.studies.fidelity import suite
from nhtrack.studies.fidelity.bench import Bench
from nhtrack.studies.fidelity.losses import coast, coasting_down
from nhtrack.studies.fidelity.motion import PoseError, drive_open_loop, middles, open_loop_errors, state_of
from nhtrack.studies.fidelity.open_loop import TIMESTEPS
from tolerances import COAST, COAST_OF_STEP, LOST_POSITION, REVERSING_ORDER, SECOND_ORDER

pytestmark = pytest.mark.fidelity

VISCOUS, DRY = (1e-3, 0.0), (0.0, 0.01)
CASES: dict[str, tuple[Loss, Loss]] = {
    "damping": (VISCOUS, VISCOUS),
    "frictionloss": (DRY, DRY),
    "both": ((1e-3, 0.01), (1e-3, 0.01)),
    "unequal": ((1e-3, 0.005), (5e-4, 0.01)),
}
ROLLING = state_of(((0, 0, 0.4), (0.25, 0.0)))


def ahead(t: np.ndarray) -> np.ndarray:
    """Accelerations from 0.25 m/s: speeds from 0.15 to 0.35 m/s, turns both ways; no wheel comes below 0.08 m/s."""
    return np.stack([0.1 * np.cos(t), 1.4 * np.cos(1.5 * t)], axis=-1)


def halting(t: np.ndarray) -> np.ndarray:
    """Accelerations from rest that begin at nothing, let wheels stand every 5 s, and send them back and forth."""
    k = 2 * np.pi / 5
    return k * np.stack([0.15 * np.sin(k * t), 2.0 * np.sin(k * t) * np.cos(0.7 * k * t)], axis=-1)


def errors(robot: str, signal: object, start: State) -> list[PoseError]:
    bench = Bench(robot)
    return open_loop_errors((bench.simulation(timestep=h) for h in TIMESTEPS), signal, 10.0, start)  # type: ignore[arg-type]


def order(found: list[float]) -> float:
    return float(np.polyfit(np.log(TIMESTEPS), np.log(found), 1)[0])


def path_length(signal: object, v: float) -> float:
    t = middles(10.0, 1e-3)
    return float(np.abs(v + np.cumsum(signal(t)[:, 0]) * 1e-3).sum() * 1e-3)  # type: ignore[operator]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_where_no_wheel_reverses_a_drive_is_as_exact_as_without_losses(tmp_path: Path, case: str) -> None:
    with_losses, without = (errors(robot, ahead, ROLLING) for robot in (write_lossy(tmp_path, *CASES[case]), "nh_mini"))
    at_1_ms = TIMESTEPS.index(0.001)
    assert with_losses[at_1_ms].position <= LOST_POSITION * path_length(ahead, 0.25)
    assert with_losses[at_1_ms].position <= 1.1 * without[at_1_ms].position
    assert order([error.position for error in with_losses]) >= SECOND_ORDER
    assert order([error.heading for error in with_losses]) >= SECOND_ORDER


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_reversals_and_rest_keep_budgets_of_their_own(tmp_path: Path, case: str) -> None:
    found = errors(write_lossy(tmp_path, *CASES[case]), halting, state_of(((0, 0, 0), (0, 0))))
    assert found[TIMESTEPS.index(0.001)].position <= LOST_POSITION * path_length(halting, 0.0)
    assert order([error.position for error in found]) >= REVERSING_ORDER


def coasted(robot: str, v: float, omega: float, duration: float) -> tuple[DiffDrive, np.ndarray, np.ndarray]:
    """Returns the reduced model, and times and (v, omega) of a robot without torque from its first step on."""
    bench = Bench(robot)
    simulation = bench.simulation(effects=(Motors(torque_limit=1e-12),))
    inputs, start = np.zeros((round(duration / simulation.dt), 1, 2)), state_of(((0, 0, 0), (v, omega)))
    run = drive_open_loop(simulation, inputs, start)
    return bench.drive, run.time[1:] - run.time[1], run.xi[1:, 0, ::2]


@pytest.mark.parametrize(("damping", "dry"), [(1e-3, 0.0), (0.0, 0.01), (1e-3, 0.01), (3e-3, 2e-3)])
def test_coasting_down_is_the_closed_form(tmp_path: Path, damping: float, dry: float) -> None:
    """m_eff v' = -(2 d/r^2) v - 2 c/r: exponential, linear, or both, until it stands."""
    drive, time, motion = coasted(write_lossy(tmp_path, (damping, dry)), 0.3, 0.0, 1.5)
    r, v = drive.wheel_radius, motion[0, 0]
    rate, deceleration = 2 * damping / (r * r * drive.m_eff), 2 * dry / (r * drive.m_eff)
    if rate:
        expected = (v + deceleration / rate) * np.exp(-rate * time) - deceleration / rate
        stop = np.log1p(v * rate / deceleration) / rate if dry else np.inf
    else:
        expected, stop = v - deceleration * time, v / deceleration
    rolling = time < stop - 1e-3
    assert np.abs(motion[rolling, 0] - expected[rolling]).max() <= COAST * v
    stopping = np.abs(motion[~rolling, 0] - np.where(time < stop, expected, 0.0)[~rolling])
    assert stopping.max(initial=0.0) <= COAST_OF_STEP * deceleration
    if dry:
        distance = float(np.sum((motion[1:, 0] + motion[:-1, 0]) / 2) * 1e-3)
        exact = stop * (v - deceleration * stop / 2) if not rate else (v - deceleration * stop) / rate
        assert distance == pytest.approx(exact, rel=COAST)
        assert np.abs(motion[time > stop + 0.05]).max() <= 1e-9  # what stands, stays


def test_constant_torques_move_a_robot_as_scipy_integrates_its_equations(tmp_path: Path) -> None:
    """The equations written anew: Newton and Euler for (v, omega), losses d w + c sign(w) on each wheel.

    No law, no compensation and no rate correction; at 0.2 ms, since the turning slip without it is of first order.
    """
    left, right = (1e-3, 0.003), (4e-4, 0.002)
    scene = Bench(write_lossy(tmp_path, left, right)).scene(timestep=2e-4)
    drive, model, at = scene.drive, scene.model, scene.addresses
    torque, begin, duration = np.array([0.014, 0.012]), (0.2, 0.5), 0.5

    def rate(_: float, y: np.ndarray) -> list[float]:
        v, omega = y
        r, b = drive.wheel_radius, drive.half_separation
        pushed = [
            (tau - d * w - c * np.sign(w)) / r
            for tau, (d, c), w in zip(torque, (left, right), ((v - b * omega) / r, (v + b * omega) / r), strict=True)
        ]
        offset = drive.mass * drive.com[0]
        v_dot = (sum(pushed) + offset * omega**2) / drive.m_eff
        return [v_dot, (b * (pushed[1] - pushed[0]) - offset * omega * v) / drive.J_eff]

    data = mujoco.MjData(model)
    data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
    first = np.array(begin) - model.opt.timestep / 2 * np.array(rate(0.0, np.array(begin)))  # half a step before
    data.qvel = scene.qvel_of(np.zeros((1, 3)), np.array([[first[0], 0.0, first[1]]]))
    data.ctrl[at.motors[0]] = torque
    steps = round(duration / model.opt.timestep)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    w_left, w_right = data.qvel[at.wheel_qvel[0]]
    found = drive.wheel_radius * np.array([w_left + w_right, (w_right - w_left) / drive.half_separation]) / 2
    end = duration - model.opt.timestep / 2
    exact = solve_ivp(rate, (0, end), begin, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    assert np.abs(exact - begin).min() > 0.1  # it does move otherwise
    np.testing.assert_allclose(found, exact, rtol=COAST)


@pytest.mark.slow
def test_only_robots_with_losses_are_measured_for_them(tmp_path: Path) -> None:
    assert list(coasting_down(Bench("nh_mini"))) == []
    found = suite.measure(suite.Task(write_lossy(tmp_path, (1e-3, 0.005), (5e-4, 0.01)), "coasting_down"))
    assert len(found) == 4
    assert all(finding.ok for finding in found), found
    assert {finding.group for finding in found} == {"Losses at the wheel joints"}


@pytest.mark.slow
def test_a_brake_that_the_reduced_model_does_not_know_of_breaks_the_budget(tmp_path: Path) -> None:
    def stickier(scene):  # type: ignore[no-untyped-def]
        scene.model.dof_frictionloss[scene.addresses.wheel_qvel] *= 1.01
        return scene

    found = list(coasting_down(Bench(write_lossy(tmp_path, (1e-3, 0.01)), stickier)))
    assert not any(finding.ok for finding in found if "straight" in finding.check)


@pytest.mark.slow
def test_the_suite_integrates_the_closed_form(tmp_path: Path) -> None:
    drive = Bench(write_lossy(tmp_path, (1e-3, 0.01))).drive
    time = np.linspace(0, 1, 11)
    speeds, stop = coast(drive, np.array([0.3, 0.0]), time)
    rate, slowed = 2e-3 / (drive.wheel_radius**2 * drive.m_eff), 0.02 / (drive.wheel_radius * drive.m_eff)
    assert stop == pytest.approx(np.log1p(0.3 * rate / slowed) / rate, rel=1e-8)
    v = (0.3 + slowed / rate) * np.exp(-rate * time) - slowed / rate
    expected = np.repeat(v[time < stop, None], 2, axis=1) / drive.wheel_radius
    np.testing.assert_allclose(speeds[: len(expected)], expected, rtol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_every_other_budget_is_kept(tmp_path: Path, case: str) -> None:
    robot = write_lossy(tmp_path, *CASES[case])
    checks = set(suite.CHECKS) - {"closed_loop", "creep", "turning_slip"}
    findings = [finding for check in sorted(checks) for finding in suite.measure(suite.Task(robot, check))]
    assert len(findings) >= 20
    assert not [finding for finding in findings if not finding.ok and not finding.explained]
