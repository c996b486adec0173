"""MuJoCo's wheel contacts against a second engine, which knows Coulomb friction from mechanics alone (slip_model.py).

First the second engine against closed forms; then both engines under the same wheel torques, below the limit of
friction, at it and beyond it. A light robot and a heavy one drive the same manoeuvres, scaled by size and motors.

Where the two differ the second engine is right: a wheel that slides at s on MuJoCo's convex contacts is thrown up at
about mu s, and touches the floor in single steps with many times its load. Means over some of these bounces are
Coulomb's; a wheel beside it that ought to hold lets go now and then.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import brentq

import tolerances as tol
from motions import Run, drive, state
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from slip_model import GRAVITY, HELD, SlipRobot, SlipRun, implicit_step, simulate

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]

ROBOT = SlipRobot(
    wheel_radius=0.03,
    half_separation=0.05,
    mass=0.7,
    yaw_inertia=9e-4,
    com=(-0.01, 0.0),
    com_height=0.025,
    wheel_inertia=5e-6,
    casters=((-0.05, 0.0),),
    friction=0.15,
    rotor_inertia=3e-6,
    products_of_inertia=(-1e-5, 0.0),
)
# Stands alike on four supports, so that the wheels bear half of the weight whatever happens on the floor.
LEVEL = replace(
    ROBOT, com=(0.0, 0.0), com_height=0.0, casters=((-0.05, 0.0), (0.05, 0.0)), products_of_inertia=(0.0, 0.0)
)
NO_TORQUE = np.zeros(2)


class TestClosedForms:
    def test_a_launch_with_spinning_wheels(self) -> None:
        """m a = mu (m g - N_c); the caster's load N_c balances pitch, with the wheels' spin-up in it."""
        r, h, x_c, mu = ROBOT.wheel_radius, ROBOT.com_height, ROBOT.casters[0][0], ROBOT.friction
        spin, weight, torque = ROBOT.wheel_inertia + ROBOT.rotor_inertia, ROBOT.mass * GRAVITY, 0.02
        share = ROBOT.wheel_inertia / spin  # of the torque left over, what turns the wheel and so pitches the robot
        # N_c x_c = weight c_x - h F - 2 share (torque - r F/2) and F = mu (weight - N_c)
        pitch = weight * ROBOT.com[0] - 2 * share * torque
        force = mu * (weight - pitch / x_c) / (1 + mu * (share * r - h) / x_c)
        run = simulate(ROBOT, lambda t: np.full(2, torque), np.zeros(5), 0.3, 0.001)
        assert 2 * torque / r > force
        wheel = (torque - r * force / 2) / spin
        expected = 0.3 * np.array([force / ROBOT.mass, 0, 0, wheel, wheel])
        np.testing.assert_allclose(run.u[-1], expected, rtol=tol.EXACT, atol=tol.EXACT)
        np.testing.assert_allclose(run.pose[-1, 0], force / ROBOT.mass * 0.3**2 / 2, rtol=tol.EXACT)
        np.testing.assert_allclose(run.load[:, :2].sum(axis=1) * mu, force, rtol=tol.EXACT)

    def test_coasting_is_the_chaplygin_sleigh(self) -> None:
        """v = V tanh k t, omega = V sqrt(m_eff/J_eff) sech k t with k = m c_x V/J_eff: it turns its heavy end ahead."""
        robot = replace(ROBOT, friction=1.0, com=(0.01, 0.0), casters=((0.05, 0.0),))
        spin = 2 * (robot.wheel_inertia + robot.rotor_inertia) / robot.wheel_radius**2
        mass = robot.mass + spin
        inertia = robot.yaw_inertia + robot.mass * 0.01**2 + spin * robot.half_separation**2
        speed = 0.3
        rate = robot.mass * robot.com[0] * speed / inertia

        def velocity(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return speed * np.tanh(rate * t), speed * np.sqrt(mass / inertia) / np.cosh(rate * t)

        start = -0.7 / rate
        v, omega = velocity(np.array(start))
        run = simulate(robot, lambda t: NO_TORQUE, robot.rolling(float(v), float(omega)), 1.0 / rate, 0.001)
        v, omega = velocity(start + run.time)
        np.testing.assert_allclose(run.u[:, [0, 2]], np.stack([v, omega], axis=-1), rtol=0, atol=tol.SMOOTH)
        assert np.abs(run.slip(robot)).max() < HELD

    def test_a_spin_in_place(self) -> None:
        """J omega' = 2 mu N b, with a quarter of the weight on each wheel."""
        robot = LEVEL
        run = simulate(robot, lambda t: np.array([-0.03, 0.03]), np.zeros(5), 0.3, 0.001)
        load, b, r = robot.mass * GRAVITY / 4, robot.half_separation, robot.wheel_radius
        force = robot.friction * load
        wheel = (0.03 - r * force) / (robot.wheel_inertia + robot.rotor_inertia)
        expected = 0.3 * np.array([0, 0, 2 * force * b / robot.yaw_inertia, -wheel, wheel])
        np.testing.assert_allclose(run.u[-1], expected, rtol=tol.EXACT, atol=tol.EXACT)
        np.testing.assert_allclose(run.pose[-1], [0, 0, 0.3 * expected[2] / 2], rtol=tol.EXACT, atol=tol.EXACT)

    def test_a_sliding_block(self) -> None:
        """Wheels too heavy to turn: the robot slides askew, slows by mu g/2, stops and stays where it is."""
        robot, speed, angle = replace(LEVEL, rotor_inertia=1e9), 0.2, 0.7
        start = speed * np.array([np.cos(angle), np.sin(angle), 0, 0, 0])
        slowing = robot.friction * GRAVITY / 2
        run = simulate(robot, lambda t: NO_TORQUE, start, 1.5 * speed / slowing, 0.001)
        moving = run.time < speed / slowing
        speeds = np.where(moving, speed - slowing * run.time, 0)
        np.testing.assert_allclose(run.u[:, :2], speeds[:, None] * start[:2] / speed, rtol=0, atol=tol.EXACT)
        assert np.abs(run.slip(robot)[~moving]).max() < HELD
        # The step in which it stops is halved ten times, and its distance is that of a trapezium.
        np.testing.assert_allclose(run.pose[-1, :2], speed / slowing / 2 * start[:2], rtol=tol.SMOOTH)
        np.testing.assert_array_less(np.abs(run.force[-1]), tol.EXACT)


class TestSecondEngine:
    def test_friction_dissipates_the_most_it_can(self) -> None:
        """Coulomb's law at both wheels, from any state of motion, loads and all."""
        rng, held = np.random.default_rng(5), np.zeros(2, int)
        for _ in range(100):
            friction, height = rng.uniform(0.02, 0.5), rng.uniform(0.0, 0.02)
            com = (-0.01, rng.uniform(-0.01, 0.01))
            robot = replace(ROBOT, friction=friction, com_height=height, com=com)
            u = robot.rolling(*rng.normal(scale=(0.3, 2.0)))
            u[1] = rng.choice([0.0, 0.2]) * rng.normal()
            u[3:] += rng.choice([0.0, 5.0]) * rng.normal(size=2)
            h, torque = 10 ** rng.uniform(-5, -2.5), rng.normal(scale=0.01, size=2)
            found, force, load = implicit_step(robot, u, h, torque, np.zeros(4))
            slip, force = (robot.slip_matrix @ found).reshape(2, 2), force.reshape(2, 2)
            limit, size = friction * load[:2], np.linalg.norm(slip, axis=1)
            assert (np.linalg.norm(force, axis=1) <= limit + tol.EXACT).all()
            work = (force * slip).sum(axis=1)
            np.testing.assert_allclose(work, -limit * size * (size > HELD), rtol=0, atol=tol.EXACT)
            held += size < HELD
        assert (held > 10).all()  # wheels that hold and wheels that slide are both among them
        assert (held < 90).all()


# -- both engines side by side ---------------------------------------------------------------------

TIMESTEP = 0.001
SEEN = ("wheel_torque", "wheel_load", "friction_utilisation", "longitudinal_slip", "lateral_slip")


@dataclass(frozen=True)
class SideBySide:
    """One robot in both engines under the same wheel torques, n physics steps.

    Attributes:
        robot: its numbers.
        command: commanded accelerations of MuJoCo's robot, shape (n, 2).
        mujoco: MuJoCo's run; rows of its telemetry are steps.
        second: the second engine's; its velocities [1:], forces and loads are those after the same steps.
        pose: the second engine's poses at MuJoCo's times, shape (n, 3).
    """

    robot: SlipRobot
    command: np.ndarray
    mujoco: Run
    second: SlipRun
    pose: np.ndarray

    def gap(self) -> np.ndarray:
        """Returns MuJoCo's poses less the second engine's, shape (n, 3)."""
        return self.mujoco.g[:-1, 0] - self.pose

    def seen(self, name: str) -> np.ndarray:
        """Returns MuJoCo's telemetry of the robot, shape (n, ...)."""
        return self.mujoco.telemetry[name][:, 0]


def side_by_side(
    name: str, friction: float, command: np.ndarray, start: tuple[float, float], h: float = TIMESTEP
) -> SideBySide:
    """Runs MuJoCo on commanded accelerations (n, 2) from a twist (v, omega), and the second engine on its torques.

    MuJoCo's velocities live half a step before its positions, and the torques of a step act from half a step before it
    to half a step after: the second engine's clock starts at -h/2.
    """
    scene = make_scene(SceneSpec(("robot",), robot=name, friction=friction, timestep=h))
    run = drive(MujocoSimulation(scene, h), command[:, None], state(((0, 0, 0), start)), SEEN)
    robot, torque = slip_robot(scene), run.telemetry["wheel_torque"][:, 0]

    def torques(t: float) -> np.ndarray:
        return np.asarray(torque[int(np.ceil(t / h - 1e-6)) - 1])

    second = simulate(robot, torques, robot.rolling(*start), len(torque) * h, h)
    return SideBySide(robot, command, run, second, from_first((second.pose[1:] + second.pose[:-1]) / 2))


def from_first(pose: np.ndarray) -> np.ndarray:
    """Returns planar poses seen from the first of them, shape (n, 3)."""
    offset = pose - pose[0]
    place = (offset[:, 0] + 1j * offset[:, 1]) * np.exp(-1j * pose[0, 2])
    return np.stack([place.real, place.imag, offset[:, 2]], axis=-1)


def slip_robot(scene: Scene) -> SlipRobot:
    """Returns the numbers of a scene's one robot; masses and inertias summed over MuJoCo's bodies at rest."""
    model, data, at = scene.model, mujoco.MjData(scene.model), scene.addresses
    data.qpos = scene.qpos_of(np.zeros((1, 3)), np.zeros((1, 2)))
    mujoco.mj_forward(model, data)
    mass, axes = model.body_mass, data.ximat.reshape(-1, 3, 3)
    com = mass @ data.xipos / mass.sum()
    own = axes * model.body_inertia[:, None, :] @ axes.transpose(0, 2, 1)  # of each body about its own CoM
    arm = data.xipos - com
    inertia = own.sum(axis=0) + (mass * (arm**2).sum(axis=1)).sum() * np.eye(3) - (arm.T * mass) @ arm
    wheel = at.wheel_qvel[0, 0]
    return SlipRobot(
        wheel_radius=scene.drive.wheel_radius,
        half_separation=scene.drive.half_separation,
        mass=float(mass.sum()),
        yaw_inertia=float(inertia[2, 2]),
        com=(float(com[0]), float(com[1])),
        com_height=float(com[2]),
        wheel_inertia=float(own[model.dof_bodyid[wheel], 1, 1]),
        casters=scene.drive.casters,
        friction=scene.spec.friction,
        rotor_inertia=float(model.dof_armature[wheel]),
        products_of_inertia=(-float(inertia[0, 2]), -float(inertia[1, 2])),
    )


# -- manoeuvres, scaled by what a robot can ---------------------------------------------------------


@dataclass(frozen=True)
class Driver:
    """What decides how a robot is driven.

    Attributes:
        name: the robot's.
        robot: its numbers.
        speed: of a wheel's rim without load [m/s].
        thrust: of both motors at their limits [N].
    """

    name: str
    robot: SlipRobot
    speed: float
    thrust: float

    @property
    def straight(self) -> SlipRobot:
        """On a floor that the motors can ask twice too much of, and that half a second's slide does not use up."""
        friction = min(0.2, 0.35 * self.thrust / (self.robot.mass * GRAVITY), self.speed / GRAVITY)
        return replace(self.robot, friction=friction)

    @property
    def bend(self) -> SlipRobot:
        """On a floor that does not bear a circle of radius 3 b at half of the top speed."""
        friction = min(0.2, (self.speed / 2) ** 2 / (3 * self.robot.half_separation * GRAVITY))
        return replace(self.robot, friction=friction)


def driver(name: str) -> Driver:
    scene = make_scene(SceneSpec(("robot",), robot=name))
    motor, radius = scene.drive.motor, scene.drive.wheel_radius
    return Driver(name, slip_robot(scene), motor.no_load_speed * radius, 2 * motor.torque_limit / radius)


def reserve(robot: SlipRobot, v: float, omega: float, u_x: float, u_theta: float) -> tuple[float, float]:
    """Returns what rolling leaves of friction, in closed form by inverse dynamics; negative where too little is there.

    Returns:
        The least share of its limit that a wheel has left lengthways, and the side force left to both together [N].
    """
    u, rate = robot.rolling(v, omega), robot.rolling(u_x, u_theta)
    forward, sideways, moment = (robot.mass_matrix @ rate + robot.turning_force(u))[:3]
    along = (forward + np.array([-1, 1]) * moment / robot.half_separation) / 2
    limit = robot.friction * robot.loads(u, rate)[:2]
    room = np.sqrt(np.maximum(limit**2 - along**2, 0)).sum()
    return float((1 - np.abs(along) / limit).min()), float(room - abs(sideways))


def launch_limit(robot: SlipRobot) -> float:
    """Returns the forward acceleration from rest that uses up the wheels' friction [m/s^2]."""
    return float(brentq(lambda u_x: reserve(robot, 0, 0, u_x, 0)[0], 0, robot.friction * GRAVITY))


def growing_circle(driven: Driver, duration: float, h: float = TIMESTEP) -> SideBySide:
    """A circle of radius 3 b, from 0.95 of the speed at which the axle slides; it grows by 0.3 of that a second."""
    robot, growth = driven.bend, 0.3
    radius = 3 * robot.half_separation

    def side_force_left(v: float) -> float:
        return reserve(robot, v, v / radius, growth * v, growth * v / radius)[1]

    v = float(brentq(side_force_left, 1e-3 * driven.speed, driven.speed))
    command = np.tile([growth * v, growth * v / radius], (round(duration / h), 1))
    return side_by_side(driven.name, robot.friction, command, (0.95 * v, 0.95 * v / radius), h)


def first(condition: np.ndarray) -> int:
    """Returns the index of the first entry that is true; fails where none is."""
    assert condition.any()
    return int(np.argmax(condition))


@pytest.fixture(scope="module", params=["nh_mini", "warehouse"])
def driven(request: pytest.FixtureRequest) -> Driver:
    return driver(request.param)


@pytest.fixture(scope="module")
def launched(driven: Driver) -> SideBySide:
    """Half a second from rest, commanded twice the limit of friction."""
    command = np.tile([2 * launch_limit(driven.straight), 0], (500, 1))
    return side_by_side(driven.name, driven.straight.friction, command, (0, 0))


@pytest.fixture(scope="module")
def bent(driven: Driver) -> SideBySide:
    return growing_circle(driven, 0.7)


class TestLaunch:
    def test_break_away(self, driven: Driver) -> None:
        share = np.linspace(0.97, 1.03, 240)
        command = share[:, None] * [launch_limit(driven.straight), 0]
        run = side_by_side(driven.name, driven.straight.friction, command, (0, 0))
        mujoco = share[first(np.abs(run.seen("longitudinal_slip")).max(axis=1) > tol.SLIPPING)]
        second = share[first(np.abs(run.second.slip(run.robot)[1:]).max(axis=1) > tol.SLIPPING)]
        assert mujoco == pytest.approx(second, rel=tol.LIMIT_MET)
        assert second == pytest.approx(1, rel=tol.LIMIT_MET_ON_A_RAMP)

    def test_history_beyond_the_limit(self, launched: SideBySide) -> None:
        gap = launched.gap()
        np.testing.assert_allclose(gap[:, 0], 0, rtol=0, atol=tol.LAUNCH_POSITION * launched.pose[-1, 0])
        window = round(0.05 / TIMESTEP)
        speeds = (gap[window:, 0] - gap[:-window, 0]) / 0.05
        np.testing.assert_allclose(speeds, 0, rtol=0, atol=tol.LAUNCH_SPEED * launched.second.u[-1, 0])
        assert np.abs(launched.second.slip(launched.robot)[-1, ::2]).min() > 1000 * tol.SLIPPING

    def test_load_and_friction_of_sliding_wheels(self, launched: SideBySide) -> None:
        """MuJoCo's against statics with load transfer, and against mu times that."""
        load, used = (launched.seen(name)[50:] for name in ("wheel_load", "friction_utilisation"))
        statics = launched.second.load[50:, :2].mean(axis=0)
        np.testing.assert_allclose(load.mean(axis=0), statics, rtol=tol.SLIDING_LOAD)
        np.testing.assert_allclose((used * load).mean(axis=0), statics, rtol=tol.SLIDING_LOAD)


class TestBend:
    def test_below_the_limit_both_roll_alike(self, bent: SideBySide) -> None:
        used = bent.second.utilisation(bent.robot)
        rolling = slice(0, first(used.max(axis=1) > 0.99))
        gap = bent.gap()[rolling]
        np.testing.assert_allclose(gap[:, :2], 0, rtol=0, atol=tol.ROLLING_POSITION)
        np.testing.assert_allclose(gap[:, 2], 0, rtol=0, atol=tol.ROLLING_HEADING)
        weight = bent.robot.mass * GRAVITY
        load = bent.seen("wheel_load")[rolling] / weight
        np.testing.assert_allclose(load, bent.second.load[rolling, :2] / weight, rtol=0, atol=tol.ROLLING_LOAD)
        np.testing.assert_allclose(
            bent.seen("friction_utilisation")[rolling], used[rolling], rtol=0, atol=tol.ROLLING_UTILISATION
        )

    def test_the_inner_wheel_reaches_its_cone(self, bent: SideBySide) -> None:
        used = bent.seen("friction_utilisation"), bent.second.utilisation(bent.robot)
        mujoco, second = (np.argwhere(share > 0.999)[0] for share in used)
        assert mujoco[1] == second[1] == 0
        assert self.speed(bent, mujoco[0]) == pytest.approx(self.speed(bent, second[0]), rel=tol.LIMIT_MET)

    def test_the_axle_slides(self, bent: SideBySide) -> None:
        mujoco = first(np.abs(bent.seen("lateral_slip")) > tol.SLIPPING)
        second = first(np.abs(bent.second.u[1:, 1]) > tol.SLIPPING)
        assert self.speed(bent, mujoco) == pytest.approx(self.speed(bent, second), rel=tol.LIMIT_MET)
        closed_form = bent.second.u[0, 0] / 0.95
        assert self.speed(bent, self.break_away(bent)) == pytest.approx(closed_form, rel=tol.LIMIT_MET)

    def test_half_a_second_after(self, bent: SideBySide) -> None:
        after = slice(self.break_away(bent), self.break_away(bent) + round(0.5 / TIMESTEP))
        pose, gap = bent.pose[after], bent.gap()[after]
        path, turn = np.hypot(*np.diff(pose[:, :2], axis=0).T).sum(), pose[-1, 2] - pose[0, 2]
        assert np.hypot(gap[:, 0], gap[:, 1]).max() < tol.BEND_POSITION * path
        assert np.abs(gap[:, 2]).max() < tol.BEND_HEADING * turn

    @staticmethod
    def speed(bent: SideBySide, k: int) -> float:
        """Commanded speed at the end of step k."""
        return float(bent.second.u[0, 0] + bent.command[: k + 1, 0].sum() * TIMESTEP)

    @staticmethod
    def break_away(bent: SideBySide) -> int:
        """Step in which the second engine's axle begins to slide."""
        return first(np.abs(bent.second.u[1:, 1]) > HELD)


def test_stopping_distance_with_sliding_wheels(driven: Driver) -> None:
    robot = driven.straight
    limit = launch_limit(robot)
    start = min(0.4 * limit, 0.4 * driven.speed)
    run = side_by_side(driven.name, robot.friction, np.tile([-2 * limit, 0], (600, 1)), (start, 0))
    stopped = run.pose[:, 0].max()
    assert stopped > run.pose[-1, 0]
    assert run.mujoco.g[:, 0, 0].max() == pytest.approx(stopped, rel=tol.STOPPING)


def test_one_wheel_spins_and_the_other_holds(driven: Driver) -> None:
    """About the left wheel, commanded 20 % more than the right wheel can bear."""
    robot = driven.straight
    about_left = np.array([1, 1 / robot.half_separation]) / 2
    limit = brentq(lambda s: reserve(robot, 0, 0, *(s * about_left))[0], 0, 4 * robot.friction * GRAVITY)
    run = side_by_side(driven.name, robot.friction, np.tile(1.2 * limit * about_left, (250, 1)), (0, 0))
    slip, (x, y, theta), (_, _, turn) = run.second.slip(run.robot), run.gap()[-1], run.pose[-1]
    assert np.abs(slip[:, :2]).max() < HELD
    assert np.abs(slip[-1, 2]) > 1000 * tol.SLIPPING
    assert abs(x) < tol.ONE_WHEEL_POSITION * run.pose[-1, 0]
    assert abs(theta) < tol.ONE_WHEEL_HEADING * turn
    assert abs(y) / run.second.time[-1] < tol.ONE_WHEEL_DRIFT * np.abs(slip[:, 2]).mean()
