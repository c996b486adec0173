"""Ground, payload, tyres, motors and base of a scenario: each one's effect on wheels against mechanics worked out here.

Of `nhtrack` only a robot's numbers are taken, mass, inertias and places; what they entail is derived in this file.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.optimize import brentq

import tolerances as tol
from motions import AT_REST, Run, drive, make_simulation, state, weaving_error
from nhtrack.effects.motors import Motors
from nhtrack.effects.patches import Patches
from nhtrack.effects.payload import Payload
from nhtrack.effects.planar_base import PlanarBase
from nhtrack.effects.slope import Slope
from nhtrack.effects.wheel_mismatch import WheelMismatch
from nhtrack.experiment.load import load
from nhtrack.ground import Patch
from nhtrack.recording import Recording
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.studies.run.run import simulate

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]

ONE = SceneSpec(("robot",))
DT = 0.01  # control period [s]
GRAVITY = 9.81


@dataclass(frozen=True)
class Demand:
    """What a motion asks of the left and the right wheel.

    Attributes:
        along: forward forces [N], shape (..., 2).
        across: side force of both wheels together [N], shape (...).
        load: normal forces [N], shape (..., 2).
    """

    along: np.ndarray
    across: np.ndarray
    load: np.ndarray

    def first_limit(self, friction: float) -> np.ndarray:
        """Returns the larger utilisation of the two wheels, the side force shared alike, shape (...)."""
        force = np.hypot(self.along, self.across[..., None] / 2)
        return np.asarray((force / (friction * self.load)).max(axis=-1))

    def reserve(self, friction: float) -> np.ndarray:
        """Returns the side force that both friction circles together leave [N]; below zero the axle slides, (...)."""
        circles = np.maximum((friction * self.load) ** 2 - self.along**2, 0)
        return np.asarray(np.sqrt(circles).sum(axis=-1) - np.abs(self.across))


def demand_of(
    robot: DiffDrive,
    v: np.ndarray,
    omega: np.ndarray,
    u_x: float = 0.0,
    u_theta: float = 0.0,
    *,
    downhill: float = 0.0,
    normal: float = GRAVITY,
) -> Demand:
    """Newton and Euler for a robot that rolls, about the point of the floor below its axle midpoint.

    Args:
        robot: whose numbers to take.
        v: forward velocity [m/s], shape (...).
        omega: yaw rate [rad/s], shape (...).
        u_x: forward acceleration [m/s^2].
        u_theta: yaw acceleration [rad/s^2].
        downhill: gravity along the floor, to the robot's left [m/s^2].
        normal: gravity into the floor [m/s^2].
    """
    m, b, (x, _, h), (caster, _) = robot.mass, robot.half_separation, robot.com, robot.casters[0]
    spin = robot.wheel_inertia / robot.wheel_radius
    forward = m * (u_x - x * omega**2)
    across = m * (omega * v + x * u_theta - downhill)
    yaw = robot.axle_inertia * u_theta + m * x * (omega * v - downhill)
    behind = (m * normal * x - h * forward - 2 * spin * u_x) / caster  # pitch: what the caster bears
    transfer = -(h * across + 2 * spin * omega * v) / b  # roll: left less right
    wheels = np.stack([m * normal - behind + transfer, m * normal - behind - transfer], axis=-1) / 2
    return Demand(np.stack([forward - yaw / b, forward + yaw / b], axis=-1) / 2, across, wheels)


def held(u_x: float, u_theta: float, duration: float) -> np.ndarray:
    """Returns one acceleration for all periods of a run, shape (periods, 1, 2)."""
    return np.tile([[[u_x, u_theta]]], (round(duration / DT), 1, 1))


def distance(run: Run, twin: Run) -> np.ndarray:
    """Returns how far a robot is from its twin [m], shape (t,)."""
    return np.asarray(np.hypot(*(run.g - twin.g)[:, 0, :2].T))


def mean_acceleration(run: Run) -> np.ndarray:
    """Returns the gain of (v, omega) from the second control instant to the last over the time between, shape (2,)."""
    return np.asarray((run.xi[-1, 0] - run.xi[1, 0]) / (run.time[-1] - run.time[1]))[[0, 2]]


@pytest.fixture(scope="module")
def robot() -> DiffDrive:
    return make_scene(ONE).drive


def assert_with_its_twin(spec: SceneSpec) -> None:
    error = weaving_error(make_simulation(spec))
    assert error.position <= tol.FIELD_POSITION
    assert error.heading <= tol.FIELD_HEADING


class TestIce:
    """At 0.3 m/s onto ice, steering ever harder: v omega passes what ice bears at 1 s."""

    FRICTION = 0.05
    ICE = (Patch(FRICTION, rectangle=(0.1, 9.0, -9.0, 9.0)),)
    U_THETA = 1.0
    START = state(((0, 0, 0), (0.3, 0.3)))

    @pytest.fixture
    def twin(self, robot: DiffDrive) -> Run:
        return drive(IdealSimulation(("robot",), robot, DT), held(0, self.U_THETA, 1.5), self.START)

    @pytest.fixture
    def limits(self, robot: DiffDrive, twin: Run) -> tuple[float, float]:
        """When the first wheel reaches its limit and when the axle does [s]."""
        asked = demand_of(robot, twin.xi[:, 0, 0], twin.xi[:, 0, 2], 0.0, self.U_THETA)
        first = np.interp(1.0, asked.first_limit(self.FRICTION), twin.time)
        axle = np.interp(0.0, -asked.reserve(self.FRICTION), twin.time)
        nearest = np.interp(first, twin.time, twin.g[:, 0, 0]) - robot.half_separation
        assert nearest > self.ICE[0].rectangle[0]  # both wheels are on the ice
        return float(first), float(axle)

    def run(self, patches: tuple[Patch, ...]) -> Run:
        simulation = make_simulation(replace(ONE, effects=(Patches(patches),)), DT)
        return drive(simulation, held(0, self.U_THETA, 1.5), self.START, ("friction_utilisation",))

    def test_it_stays_with_its_twin_until_the_ice_lets_go(self, twin: Run, limits: tuple[float, float]) -> None:
        _, axle = limits
        gap = distance(self.run(self.ICE), twin)
        assert gap[twin.time <= axle].max() < tol.HOLDING
        assert gap[-1] > tol.SLIDING
        assert twin.time[gap > tol.HOLDING][0] < axle + 2 * tol.PROMPTLY
        assert twin.time[gap > tol.SLIDING][0] < axle + 0.3

    def test_the_first_wheel_is_at_its_limit_when_predicted(self, limits: tuple[float, float]) -> None:
        first, axle = limits
        run = self.run(self.ICE)
        used = run.telemetry["friction_utilisation"][:, 0]
        at_limit = [run.time[1:][wheel > 1 - 1e-4][0] for wheel in used.T]
        assert at_limit == pytest.approx([first, axle], abs=tol.PROMPTLY)


class TestSlope:
    ANGLE = 0.1

    def let_go(self, compensation: str, theta: float) -> Run:
        """A second at rest on a slope that rises towards 0.7 rad."""
        spec = replace(ONE, effects=(Slope(self.ANGLE, 0.7),), compensation=compensation)
        return drive(make_simulation(spec, DT), held(0, 0, 1.0), state(((0, 0, theta), (0, 0))))

    def test_who_knows_nothing_of_it_rolls_back(self, robot: DiffDrive) -> None:
        """The wheels' spin is to be brought about too: g sin(a) m/(m + 2 I_w/r^2)."""
        run = self.let_go("nominal", 0.7)
        heavier = robot.mass + 2 * robot.wheel_inertia / robot.wheel_radius**2
        expected = -GRAVITY * np.sin(self.ANGLE) * robot.mass / heavier
        np.testing.assert_allclose(mean_acceleration(run), (expected, 0), rtol=0, atol=tol.FIELD_ACCELERATION)

    def test_across_it_the_heavier_end_goes_down(self, robot: DiffDrive) -> None:
        """Gravity at the CoM, behind the axle: yaw m g sin(a) x about the axle midpoint, which friction holds."""
        run = self.let_go("nominal", 0.7 + np.pi / 2)
        b, r = robot.half_separation, robot.wheel_radius
        inertia = robot.axle_inertia + 2 * robot.wheel_inertia * (b / r) ** 2
        expected = GRAVITY * np.sin(self.ANGLE) * robot.mass * robot.com[0] / inertia
        first = (run.xi[3, 0, 2] - run.xi[1, 0, 2]) / (run.time[3] - run.time[1])
        assert expected < 0  # to the right, its nose towards the top
        assert first == pytest.approx(expected, rel=1e-3)  # gravity is 3e-4 rad askew by then

    def test_who_knows_of_it_drives_as_on_the_level(self) -> None:
        assert_with_its_twin(replace(ONE, effects=(Slope(self.ANGLE, 0.7),), compensation="actual"))

    @pytest.mark.parametrize("friction", [0.1, 0.3])
    def test_across_it_friction_holds_up_to_the_predicted_angle(self, robot: DiffDrive, friction: float) -> None:
        """Less than atan(friction): the caster bears weight and holds nothing, and the CoM is behind the axle."""
        still = np.zeros(())

        def reserve(angle: float) -> float:
            along, normal = GRAVITY * np.sin(angle), GRAVITY * np.cos(angle)
            return float(demand_of(robot, still, still, downhill=along, normal=normal).reserve(friction))

        limit = brentq(reserve, 1e-3, np.arctan(friction))
        assert limit < 0.8 * np.arctan(friction)
        moved = []
        for angle in (limit * (1 - tol.BREAK_AWAY), limit * (1 + tol.BREAK_AWAY)):
            spec = replace(ONE, effects=(Slope(angle),), friction=friction, compensation="actual")
            run = drive(make_simulation(spec, DT), held(0, 0, 1.0), state(((0, 0, np.pi / 2), (0, 0))))
            moved.append(float(np.hypot(*run.g[-1, 0, :2])))
        assert moved[0] < tol.HOLDING
        assert moved[1] > tol.SLIDING


@dataclass(frozen=True)
class Laden:
    """A robot with a payload: the sums over both, and what torques for the robot alone make of it."""

    robot: DiffDrive
    load: Payload

    @property
    def matrix(self) -> np.ndarray:
        """Inertia in (v, omega), the wheels' spin included, shape (2, 2)."""
        robot, load = self.robot, self.load
        b, r = robot.half_separation, robot.wheel_radius
        x, y, _ = load.position
        mass = robot.mass + 2 * robot.wheel_inertia / r**2 + load.mass
        own = load.mass / 12 * (load.size[0] ** 2 + load.size[1] ** 2)
        yaw = robot.axle_inertia + 2 * robot.wheel_inertia * (b / r) ** 2 + own + load.mass * (x * x + y * y)
        return np.array([[mass, -load.mass * y], [-load.mass * y, yaw]])

    def accelerations(self, u_x: float, u_theta: float) -> np.ndarray:
        """Returns what (u_x, u_theta) become, from rest, shape (2,)."""
        alone = replace(self, load=replace(self.load, mass=0.0))
        return np.asarray(np.linalg.solve(self.matrix, alone.matrix @ (u_x, u_theta)))


class TestPayload:
    CENTRED = Payload(0.35, (0.0, 0.0, 0.07), (0.06, 0.04, 0.03))
    ASIDE = Payload(0.2, (-0.01, 0.02, 0.06), (0.03, 0.02, 0.03))

    def first_moments(self, load: Payload, u_x: float, u_theta: float) -> np.ndarray:
        simulation = make_simulation(replace(ONE, effects=(load,)), DT)
        return mean_acceleration(drive(simulation, held(u_x, u_theta, 0.05)))

    def test_who_knows_nothing_of_it_is_slower_by_the_ratio_of_masses(self, robot: DiffDrive) -> None:
        laden = Laden(robot, self.CENTRED)
        (mass, _), (_, yaw) = laden.matrix
        straight = self.first_moments(self.CENTRED, 0.5, 0.0)
        np.testing.assert_allclose(straight, (0.5 * (1 - 0.35 / mass), 0), rtol=0, atol=tol.FIELD_ACCELERATION)
        turned = self.first_moments(self.CENTRED, 0.0, 2.0)
        box = 0.35 / 12 * (0.06**2 + 0.04**2)
        assert turned[1] == pytest.approx(2.0 * (1 - box / yaw), abs=tol.FIELD_ACCELERATION)

    def test_one_aside_turns_the_robot(self, robot: DiffDrive) -> None:
        """It lags behind as the robot speeds up: carried on the left it turns the robot left."""
        laden = Laden(robot, self.ASIDE)
        expected = laden.accelerations(0.5, 0.0)
        assert expected[1] > 1
        np.testing.assert_allclose(self.first_moments(self.ASIDE, 0.5, 0.0), expected, rtol=tol.CENTRIPETAL, atol=0)

    @pytest.mark.parametrize("load", [CENTRED, ASIDE], ids=["centred", "aside"])
    def test_who_knows_of_it_stays_with_its_twin(self, load: Payload) -> None:
        assert_with_its_twin(replace(ONE, effects=(load,), compensation="actual"))

    def test_it_weighs_on_wheels_and_caster(self, robot: DiffDrive) -> None:
        """Three supports at rest; the payload ahead of the axle takes weight off the caster."""
        load = Payload(0.3, (0.015, 0.02, 0.06))
        seen = drive(make_simulation(replace(ONE, effects=(load,)), DT), held(0, 0, 0.5), AT_REST, ("wheel_load",))
        left, right = seen.telemetry["wheel_load"][-1, 0]
        weights = GRAVITY * np.array([robot.mass, load.mass])
        caster = weights @ (robot.com[0], load.position[0]) / robot.casters[0][0]
        transfer = weights[1] * load.position[1] / robot.half_separation
        expected = np.array([weights.sum() - caster + transfer, weights.sum() - caster - transfer]) / 2
        np.testing.assert_allclose((left, right), expected, rtol=1e-4, atol=0)


def mismatched(robot: DiffDrive, half_width: float, mismatch: float, u_x: float) -> tuple[np.ndarray, float]:
    """Returns (v', omega') of a robot from rest with unlike tyres, torques as for alike ones, and its lean [rad].

    The tyres are ellipsoids of radius r_i and half width k r_i. Leaning by phi, a tyre touches the floor

        s r_i below its centre, s = sqrt(cos^2 phi + k^2 sin^2 phi),
        e_i = (1 - k^2) r_i sin(phi) cos(phi)/s beside it, towards the larger wheel,

    so the centres, 2 b apart, differ in height by (r_left - r_right) s = 2 b sin(phi). A wheel whose centre is at the
    distance y_i = +-b cos(phi) from the middle rolls when its spin is psi_i = s (v - omega (y_i + e_i))/(r_i cos(phi)).
    Torques do the work tau_i psi_i; a wheel turns about its axle at psi_i + omega sin(phi).
    """
    r, b, k = robot.wheel_radius, robot.half_separation, half_width / robot.wheel_radius
    radii = r * np.array([1 + mismatch / 2, 1 - mismatch / 2])

    def squeeze(phi: float) -> float:
        return float(np.hypot(np.cos(phi), k * np.sin(phi)))

    phi = brentq(lambda phi: 2 * b * np.sin(phi) - (radii[0] - radii[1]) * squeeze(phi), -1.0, 1.0, xtol=1e-15)
    s = squeeze(phi)
    contact = b * np.cos(phi) * np.array([1, -1]) + (1 - k * k) * radii * np.sin(phi) * np.cos(phi) / s
    rolling = s / np.cos(phi) * np.stack([1 / radii, -contact / radii], axis=-1)
    turning = rolling + np.array([0, np.sin(phi)])
    beside = -(robot.com[2] - r) * np.sin(phi)  # the CoM, above or below the axle, goes aside
    planar = np.array([[robot.mass, -robot.mass * beside], [-robot.mass * beside, robot.axle_inertia]])
    inertia = planar + robot.wheel_inertia * turning.T @ turning
    torque = r / 2 * (robot.mass + 2 * robot.wheel_inertia / r**2) * u_x
    return np.linalg.solve(inertia, rolling.T @ (torque, torque)), phi


class TestWheelMismatch:
    @pytest.mark.parametrize("mismatch", [-0.02, 0.002])
    def test_speeding_up_straight_on_it_turns_towards_the_larger_wheel(self, mismatch: float) -> None:
        """Alike torques are a smaller force at a larger wheel, and the lean moves both contacts to its side."""
        scene = make_scene(ONE)
        half_width = float(scene.model.geom_size[scene.addresses.tyres[0, 0], 1])
        (v, omega), lean = mismatched(scene.drive, half_width, mismatch, 1.0)
        simulation = make_simulation(replace(ONE, effects=(WheelMismatch(mismatch),)), DT)
        run = drive(simulation, held(1.0, 0.0, 0.1), AT_REST, ("tilt",))
        assert np.sign(omega) == np.sign(mismatch)
        assert run.xi[-1, 0, 2] / run.xi[-1, 0, 0] == pytest.approx(omega / v, rel=tol.CURVATURE)
        np.testing.assert_allclose(run.telemetry["tilt"][:, 0], abs(lean), rtol=0, atol=tol.LEAN)


class TestWeakMotors:
    """Full speed ahead on weak motors: torque of the driver first, then along the motor's line."""

    TORQUE, NO_LOAD = 0.01, 10.0
    SPEC = replace(ONE, effects=(Motors(TORQUE, NO_LOAD),))

    def test_speed_over_time_and_the_share_of_saturation(self, robot: DiffDrive) -> None:
        """m_eff v' = 2 min(tau_max, tau_s (1 - v/(r w_0)))/r: first a ramp, then exponentially towards r w_0."""
        r, stall = robot.wheel_radius, robot.motor.stall_torque
        mass = robot.mass + 2 * robot.wheel_inertia / r**2
        top, ramp = r * self.NO_LOAD, 2 * self.TORQUE / (r * mass)
        corner = top * (1 - self.TORQUE / stall)
        decay = 2 * stall / (r * mass * top)
        run = drive(make_simulation(self.SPEC, DT), held(2.0, 0.0, 1.0), AT_REST, ("torque_saturation", "wheel_torque"))
        # Half of the command, which the first step is to bring about from rest, exceeds the motors as well: they give
        # all they have from half a physics step before the start.
        time = run.time[1:] + ONE.timestep / 2
        after = np.maximum(time - corner / ramp, 0)
        expected = top - (top - corner) * np.exp(-decay * after)
        np.testing.assert_allclose(run.xi[1:, 0, 0][after > 0], expected[after > 0], rtol=0, atol=tol.MOTOR_LINE)
        assert run.xi[-1, 0, 0] == pytest.approx(top, rel=1e-6)
        on_the_ramp = after == 0
        assert on_the_ramp.sum() > 20
        speed = run.xi[1:, 0, 0][on_the_ramp]
        np.testing.assert_allclose(speed, (ramp * time)[on_the_ramp], rtol=0, atol=tol.MOTOR_RAMP)
        np.testing.assert_allclose(run.telemetry["wheel_torque"][on_the_ramp], self.TORQUE, rtol=tol.HAND, atol=0)
        assert (run.telemetry["torque_saturation"] == 1).all()


class TestPlanarBase:
    COMMAND = (0.4, 1.0)
    START = state(((0, 0, 0.3), (0.3, 1.5)))

    def run(self, *base: PlanarBase) -> Run:
        """Two seconds of speeding up in a turn and of braking."""
        inputs = np.concatenate([held(*self.COMMAND, 1.0), -held(*self.COMMAND, 1.0)])
        return drive(make_simulation(replace(ONE, effects=base), DT), inputs, self.START, ("wheel_load",))

    def test_it_is_as_near_the_ideal_robot_as_the_free_one(self) -> None:
        assert_with_its_twin(replace(ONE, effects=(PlanarBase(),)))

    def test_the_free_base_moves_alike_and_bears_its_weight_otherwise(self, robot: DiffDrive) -> None:
        """The caster bears a fifth of the weight and turns shift more; as long as friction holds none of it shows."""
        free, planar = self.run(), self.run(PlanarBase())
        assert distance(free, planar).max() < tol.HOLDING
        weight = robot.mass * GRAVITY
        shift = (free.telemetry["wheel_load"] - planar.telemetry["wheel_load"])[:, 0]
        twist = (free.xi[1:, 0] + free.xi[:-1, 0]) / 2  # in the middles of the periods, as loads are means
        expected = np.concatenate(
            [
                demand_of(robot, *twist[rows][:, [0, 2]].T, *command).load
                for rows, command in ((slice(100), self.COMMAND), (slice(100, None), np.negative(self.COMMAND)))
            ]
        )
        np.testing.assert_allclose(shift, expected - weight / 2, rtol=0, atol=tol.FIELD_LOAD * weight)
        assert -0.17 * weight < shift.min() < -0.16 * weight  # the inner wheel at full speed
        assert -0.06 * weight < shift.max() < -0.05 * weight  # the outer one


def told(name: str, *overrides: str) -> Recording:
    """Returns the recording of a bundled stress scenario that ran to its end."""
    outcome = simulate(load(f"stress/{name}", overrides))
    assert outcome.failure is None
    return outcome.recording


def gap_to_twin(recording: Recording, robot: int) -> np.ndarray:
    """Returns how far a robot is from its ideal twin [m], shape (t,)."""
    gap = (recording["pose"] - recording["ideal_pose"]).values[:, robot, :2]
    return np.asarray(np.hypot(*gap.T))


class TestStressScenarios:
    """What the bundled scenarios say of themselves, to the digits in which they say it."""

    def test_ice_patch(self) -> None:
        recording = told("ice_patch")
        gap = gap_to_twin(recording, 1)
        icy = recording["friction_utilisation"].values[:, 1].max(axis=-1) > 0.99
        slides = int(np.flatnonzero(icy)[0])
        assert gap[:slides].max() < tol.HOLDING
        assert gap.max() > 0.1
        assert gap[-1] < 0.05  # back on its path

    def test_slope(self, robot: DiffDrive) -> None:
        effective = robot.mass + 2 * robot.wheel_inertia / robot.wheel_radius**2
        for kp, kd, sag in ((4, 5, 0.210), (9, 7, 0.0935)):
            error = told("slope", f"law.kp={kp}", f"law.kd={kd}")["error"].values[-1, 1]
            assert GRAVITY * np.sin(0.0872664626) / kp * robot.mass / effective == pytest.approx(sag, abs=5e-4)
            assert error[0] == pytest.approx(-sag, abs=5e-4)
        assert gap_to_twin(told("slope", "physics.compensation=actual", "duration=6"), 1).max() < tol.HOLDING

    def test_payload(self) -> None:
        speeding_up, braking = (told("payload")["error"].sel(time=t).values[1] for t in (4.0, 16.0))
        assert (speeding_up[0], braking[0]) == pytest.approx((-0.047, 0.047), abs=4e-3)  # not quite settled
        assert (speeding_up[2], braking[2]) == pytest.approx((0.041, -0.041), abs=1e-3)
        assert gap_to_twin(told("payload", "physics.compensation=actual", "duration=5"), 1).max() < tol.HOLDING

    def test_wheel_mismatch(self) -> None:
        recording = told("wheel_mismatch")
        assert recording["pose"].values[-1, 0, 1] == pytest.approx(1.25, abs=5e-3)
        assert recording["pose"].values[-1, 0, 2] / 3.3 == pytest.approx(0.243, abs=5e-4)
        assert np.hypot(*recording["error"].values[-1, 1, :2]) < 0.02
        assert recording["tilt"].values[-1, 0] == pytest.approx(0.006, abs=5e-5)

    def test_weak_motors(self) -> None:
        recording = told("weak_motors")
        speed, time = recording["twist"].values[:, 1, 0], recording.time
        assert speed[50] / time[50] == pytest.approx(0.56, abs=5e-3)
        assert speed.max() == pytest.approx(0.45, abs=5e-4)
        flat_out = (time > 1.1) & (time < 3.2)
        assert (recording["torque_saturation"].values[flat_out, 1] == 1).all()
        assert not recording["torque_saturation"].values[time > 5, 1].any()
        assert np.hypot(*recording["error"].values[-1, 1, :2]) < 0.05


@pytest.mark.parametrize(("side", "slippery"), [((0.0, 1.0), 0), ((-1.0, 0.0), 1)])
def test_each_tyre_has_the_friction_of_the_place_where_it_stands(side: tuple[float, float], slippery: int) -> None:
    """Turning on the spot both wheels push alike; the one on ice uses more of its friction."""
    ice = Patch(0.25 * ONE.friction, rectangle=(-1.0, 1.0, *side))
    simulation = make_simulation(replace(ONE, effects=(Patches((ice,)),)), DT)
    run = drive(simulation, held(0.0, 0.5, 0.1), AT_REST, ("friction_utilisation",))
    used = run.telemetry["friction_utilisation"][-1, 0]
    assert used[slippery] / used[1 - slippery] == pytest.approx(4.0, rel=0.02)
