"""The rival laws against a second implementation, their symmetries, what they claim, and where they fail."""

from __future__ import annotations

import decimal
import math
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import rivals
from array_laws import FeedbackLinearisation, JiangNijmeijer, Kanayama, Leader, LookAhead, Robots, Samson
from nhtrack import planar, se2
from nhtrack.config.law_sections import powers
from nhtrack.config.schema import Scenario
from nhtrack.experiment.build import build, make_law
from nhtrack.experiment.load import load_text
from nhtrack.experiment.loop import rollout
from nhtrack.network import Network
from nhtrack.similarity import Similarity
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State
from nhtrack.studies.run.run import simulate

PI = math.pi
EPS = 2.0**-52

# Two ways to compute one command, some hundred rounded operations, relative to terms up to 1e4 m/s^2 of which the
# command may be a small difference. Measured 1.5e-14.
SECOND_IMPLEMENTATION = 1e-13

# The same law in coordinates moved or stretched by numbers of order 10, which rounds them. Measured 2.4e-14.
SAME_COMMAND = 2e-13

# DOP853 at rtol 1e-10 over 20 s of an error that decays, against its closed form; errors of order 1 to 10.
ODE = 1e-7

# Two closed loops that are one in their own units, over hundreds of periods: rounding, amplified by the gains.
SAME_IN_OWN_UNITS = 1e-9

# Wheels against the ideal robot over 10 s of a law at its defaults: [m] and [rad]. Measured 4e-8 to 7e-8.
ON_WHEELS = 5e-7

# What counts as converged at the scale of 1 m/s and starts 10 m away.
POSITION, HEADING = 0.01, 0.02  # [m], [rad]

Rival = Kanayama | Samson | JiangNijmeijer | LookAhead | FeedbackLinearisation

KANAYAMA = Kanayama(k_x=1.0, k_y=1.0, k_theta=2.0, k_inner=5.0)
SAMSON = Samson(zeta=0.7, b=1.0, k_inner=5.0)
JIANG_NIJMEIJER = JiangNijmeijer(k_x=1.0, gamma=1.0, k_theta=1.0, k_inner=5.0, coupling=1.0)
FEEDBACK_LINEARISATION = FeedbackLinearisation(kp=1.0, kd=2.5, k_inner=5.0, v_min=0.1)
LOOK_AHEAD = LookAhead(distance=0.5, k=1.0, k_inner=5.0)
RIVALS: dict[str, Rival] = {
    "kanayama": KANAYAMA,
    "samson": SAMSON,
    "jiang_nijmeijer": JIANG_NIJMEIJER,
    "feedback_linearisation": FEEDBACK_LINEARISATION,
    "look_ahead": LOOK_AHEAD,
}
every_rival = pytest.mark.parametrize("name", RIVALS)
BY_HAND: dict[str, Callable[..., tuple[float, float]]] = {name: getattr(rivals, name) for name in RIVALS}


# -- what is drawn ----------------------------------------------------------------------------------


class Scene(NamedTuple):
    """Followers and their leaders, arrays (..., 3)."""

    follower: Robots
    leader: Leader


def random_scene(shape: tuple[int, ...], seed: int = 0) -> Scene:
    """Places in a square of 10 m, any heading within two turns, velocities and accelerations up to 2."""
    rng = np.random.default_rng(seed)
    g = rng.uniform(-5, 5, (2, *shape, 3)) * [1, 1, 2]
    xi = rng.uniform(-2, 2, (2, *shape, 3)) * [1, 0, 1]
    u = rng.uniform(-2, 2, (*shape, 3)) * [1, 0, 1]
    return Scene(Robots(g[0], xi[0]), Leader(g[1], xi[1], u))


def at(scene: Scene, index: object) -> Scene:
    return Scene(Robots(*(a[index] for a in scene.follower)), Leader(*(a[index] for a in scene.leader)))


def first_command(law: Rival, scene: Scene) -> np.ndarray:
    return np.asarray(law(*scene, law.init(*scene))[0])


def random_gains(law: Rival, rng: np.random.Generator) -> Rival:
    """The same law with gains half to twice as large."""
    return replace(law, **{name: value * 2 ** rng.uniform(-1, 1) for name, value in law.gains.items()})


def largest_difference(u: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of commands, relative to 1 and the commands of the same follower."""
    return float((np.abs(u - expected) / (1 + np.abs(expected).max(axis=-1, keepdims=True))).max())


# -- a second implementation ------------------------------------------------------------------------


@every_rival
def test_law_is_its_source_s(name: str) -> None:
    """Against complex scalars in the world frame, derivatives by complex steps; random states and gains."""
    rng, scene = np.random.default_rng(1), random_scene((400,))
    worst = 0.0
    for i in range(400):
        one, law = at(scene, i), random_gains(RIVALS[name], rng)
        parameters = {key: value for key, value in law.gains.items() if key not in ("hysteresis", "dead_zone_speed")}
        (g, xi), (g_r, xi_r, u_r) = one
        pair = rivals.Pair((*g, xi[0], xi[2]), (*g_r, xi_r[0], xi_r[2]), (u_r[0], u_r[2]))
        expected = BY_HAND[name](pair, *parameters.values())
        worst = max(worst, largest_difference(first_command(law, one), np.array(expected)))
    assert worst <= SECOND_IMPLEMENTATION


@pytest.mark.parametrize("theta", [1e-300, 1e-9, 1e-3, 0.0999999, 0.1, 0.1000001, 1.0, 3.0, -0.05, -2.0])
def test_sinc_and_its_derivative(theta: float) -> None:
    """Against their series in 60 decimal digits, around the places where the formulas change."""
    with decimal.localcontext(prec=60):
        square, factorials = Decimal(theta) ** 2, [Decimal(math.factorial(n)) for n in range(70)]
        exact = sum((-square) ** n / factorials[2 * n + 1] for n in range(30))
        # d/dtheta (-1)^n theta^(2n)/(2n+1)! = -theta (-1)^(n-1) 2n theta^(2n-2)/(2n+1)!
        slope = -Decimal(theta) * sum(2 * n * (-square) ** (n - 1) / factorials[2 * n + 1] for n in range(1, 30))
    assert planar.sinc_and_slope(0.0) == (1.0, 0.0)
    found = planar.sinc_and_slope(theta)
    assert abs(float(found[0]) - float(exact)) <= 4 * EPS
    assert abs(float(found[1]) - float(slope)) <= 16 * EPS


# -- symmetries -------------------------------------------------------------------------------------


@every_rival
def test_law_is_left_invariant(name: str) -> None:
    law, scene = RIVALS[name], random_scene((500,))
    h = np.random.default_rng(2).uniform(-10, 10, (500, 3))
    follower = scene.follower._replace(g=se2.compose(h, scene.follower.g))
    moved = Scene(follower, scene.leader._replace(g=se2.compose(h, scene.leader.g)))
    assert largest_difference(first_command(law, moved), first_command(law, scene)) <= SAME_COMMAND


@every_rival
@pytest.mark.parametrize("turns", [-2, 1])
def test_whole_turns_do_not_count(name: str, turns: int) -> None:
    law, scene = RIVALS[name], random_scene((500,))
    g = scene.follower.g + np.array([0.0, 0.0, 2 * PI * turns])
    turned = scene._replace(follower=scene.follower._replace(g=g))
    assert largest_difference(first_command(law, turned), first_command(law, scene)) <= SAME_COMMAND


@every_rival
def test_law_is_mirror_symmetric(name: str) -> None:
    """A world seen in a mirror along x obeys the mirrored law, to the last bit."""
    law, scene, flip = RIVALS[name], random_scene((500,)), np.array([1.0, -1.0, -1.0])
    mirrored = Scene(Robots(*(a * flip for a in scene.follower)), Leader(*(a * flip for a in scene.leader)))
    np.testing.assert_array_equal(first_command(law, mirrored), first_command(law, scene) * flip[::2])


@every_rival
def test_pi_and_minus_pi_turn_opposite_ways(name: str) -> None:
    """They are mirror images on the leader's axis; rivals that see sine and cosine only go straight on."""

    def command(theta: float) -> np.ndarray:
        follower = Robots(np.array([-2.0, 0.0, theta]), np.array([0.3, 0.0, 0.0]))
        return first_command(RIVALS[name], Scene(follower, Leader(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.zeros(3))))

    plus, minus = command(PI), command(-PI)
    assert plus[0] == minus[0]
    assert plus[1] == -minus[1]
    if name in ("samson", "jiang_nijmeijer"):
        assert plus[1] < -1  # pi comes back clockwise


def stretched(law: Rival, scene: Scene, similarity: Similarity) -> tuple[Rival, Scene]:
    """The same law and scene in the robot's units."""
    units = {name: powers(gain.unit) for name, gain in law.kind.described.items()}
    scaled = {name: similarity.scale(getattr(law, name), *unit) for name, unit in units.items()}
    follower = Robots(similarity.poses_to_robot(scene.follower.g), similarity.twists_to_robot(scene.follower.xi))
    g, xi, u = scene.leader
    u = np.insert(similarity.inputs_to_robot(u[..., ::2]), 1, 0.0, axis=-1)
    leader = Leader(similarity.poses_to_robot(g), similarity.twists_to_robot(xi), u)
    return replace(law, **scaled), Scene(follower, leader)


@every_rival
@pytest.mark.parametrize(("length", "time"), [(2.0**-7, 4.0), (8.0, 2.0**-3), (1.0, 0.5)])
def test_law_scales_exactly_by_powers_of_two(name: str, length: float, time: float) -> None:
    similarity, law, scene = Similarity(length, time), RIVALS[name], random_scene((300,))
    expected = similarity.inputs_to_robot(first_command(law, scene))
    np.testing.assert_array_equal(first_command(*stretched(law, scene, similarity)), expected)


@every_rival
def test_law_scales_by_any_factor(name: str) -> None:
    similarity, law, scene = Similarity(0.013, 3.7), RIVALS[name], random_scene((300,))
    u = similarity.inputs_to_scenario(first_command(*stretched(law, scene, similarity)))
    assert largest_difference(u, first_command(law, scene)) <= SAME_COMMAND


@every_rival
@pytest.mark.parametrize("shape", [(2, 3), (3, 0)])
def test_batch_is_exactly_its_members(name: str, shape: tuple[int, ...]) -> None:
    law, scene = RIVALS[name], random_scene(shape)
    memory = law.init(*scene)
    u, after = law(*scene, memory)
    assert u.shape == (*shape, 2)
    for index in np.ndindex(*shape):
        alone = at(scene, index)
        one, remembered = law(*alone, law.init(*alone))
        np.testing.assert_array_equal(u[index], one)
        if name in ("samson", "jiang_nijmeijer"):
            assert after.turns[index] == remembered.turns


@every_rival
def test_one_gain_per_member_is_one_law_per_member(name: str) -> None:
    """As `nhtrack tune` runs candidates side by side: gains (b, 1), robots (b, n)."""
    scene, rng = random_scene((5, 2)), np.random.default_rng(4)
    laws = [random_gains(RIVALS[name], rng) for _ in range(5)]
    law = replace(laws[0], **{key: np.array([[each.gains[key]] for each in laws]) for key in laws[0].gains})
    u = first_command(law, scene)
    for i, each in enumerate(laws):
        np.testing.assert_array_equal(u[i], first_command(each, at(scene, i)))


# -- special places --------------------------------------------------------------------------------


@every_rival
def test_command_is_finite_where_everything_rests(name: str) -> None:
    """Leader at rest, follower on target or not, any heading: no quotient 0/0."""
    headings = np.array([0.0, PI / 2, PI, -PI, 1e-300])
    for place in (0.0, 1e-300, 3.0):
        g = np.stack([np.full(5, place), np.zeros(5), headings], axis=-1)
        zero = np.zeros((5, 3))
        assert np.isfinite(first_command(RIVALS[name], Scene(Robots(g, zero), Leader(zero, zero, zero)))).all()
        starting = Leader(zero, zero, np.array([[0.5, 0.0, 0.3]]) + zero)
        assert np.isfinite(first_command(RIVALS[name], Scene(Robots(g, zero), starting))).all()


@every_rival
def test_on_target_the_command_is_the_feedforward(name: str) -> None:
    g, xi, u = np.array([0.4, -0.3, 2.0]), np.array([1.0, 0.0, 0.5]), np.array([0.7, 0.0, -0.2])
    command = first_command(RIVALS[name], Scene(Robots(g, xi), Leader(g.copy(), xi.copy(), u)))
    np.testing.assert_allclose(command, [0.7, -0.2], rtol=0, atol=SAME_COMMAND)


@pytest.mark.parametrize("law", [SAMSON, JIANG_NIJMEIJER], ids=["samson", "jiang_nijmeijer"])
def test_a_turn_is_dropped_once_and_late(law: Rival) -> None:
    """As with the other laws: given up at pi + hysteresis, taken again at pi - hysteresis."""
    there = np.linspace(0.0, 3 * PI, 1000)
    headings = np.concatenate([there, there[::-1]])
    leader = Leader(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.zeros(3))

    def follower(theta: float) -> Robots:
        return Robots(np.array([-2.0, 1.0, theta]), np.zeros(3))

    memory, turns = law.init(follower(0.0), leader), []
    for theta in headings:
        _, memory = law(follower(theta), leader, memory)
        turns.append(float(memory.turns))
    first, second = headings[np.flatnonzero(np.diff(turns)) + 1]
    assert 0 < first - (PI + 0.25) <= there[1]
    assert 0 < (PI - 0.25) - second <= there[1]


def test_gains_outside_the_source_s_conditions_are_told() -> None:
    assert replace(SAMSON, zeta=1.0).warnings() == (
        "zeta = 1 is not below 1: its source designs for complex poles, 0 < zeta < 1",
    )
    assert replace(FEEDBACK_LINEARISATION, kd=1.9).warnings() == (
        "kd = 1.9 is below 2 sqrt(kp) = 2: errors overshoot, and v passes the singularity",
    )
    assert [law.warnings() for law in RIVALS.values()] == [()] * 5
    assert replace(FEEDBACK_LINEARISATION, kd=2.0).warnings() == ()


# -- continuous time: what is claimed, against closed forms -------------------------------------------

LINE, CIRCLE, REST, REVERSE = (1.0, 0.0, 0.0), (1.0, 0.0, 0.5), (0.0, 0.0, 0.0), (-1.0, 0.0, 0.2)


class Flow(NamedTuple):
    """A closed loop in continuous time; arrays (t, b, 3)."""

    time: np.ndarray
    follower: Robots
    leader: Leader


def flow(law: Rival, g: np.ndarray, xi: np.ndarray, leader_twist: tuple[float, ...], duration: float) -> Flow:
    """Closed loops from poses and twists (b, 3) behind a leader of constant twist that starts at the origin."""
    count, times = len(g), np.linspace(0.0, duration, 201)
    xi_r = np.broadcast_to(np.array(leader_twist), g.shape)
    memory = None

    def leader_at(t: float) -> Leader:
        return Leader(se2.exp(t * xi_r), xi_r, np.zeros_like(g))

    def rate(t: float, flat: np.ndarray) -> np.ndarray:
        nonlocal memory
        pose, velocity = np.split(flat.reshape(count, 6), 2, axis=-1)
        scene = Scene(Robots(pose, velocity), leader_at(t))
        memory = law.init(*scene) if memory is None else memory
        u, memory = law(*scene, memory)
        place = np.concatenate([se2.rotate(pose[:, 2], velocity[:, :2]), velocity[:, 2:]], axis=-1)
        return np.concatenate([place, np.insert(u, 1, 0.0, axis=-1)], axis=-1).ravel()

    start = np.concatenate([g, xi], axis=-1).ravel()
    solution = solve_ivp(rate, (0.0, duration), start, method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times)
    path = solution.y.T.reshape(len(times), count, 6)
    leaders = [leader_at(t) for t in times]
    leader = Leader(*(np.array(parts) for parts in zip(*leaders, strict=True)))
    return Flow(times, Robots(path[..., :3], path[..., 3:]), leader)


def starts(count: int, seed: int = 2024) -> tuple[np.ndarray, np.ndarray]:
    """Poses in a disc of 10 m, any heading, and twists |v|, |omega| <= 1, shapes (count, 3)."""
    rng = np.random.default_rng(seed)
    radius, bearing = 10 * np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-PI, PI, count)
    g = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), rng.uniform(-PI, PI, count)], axis=-1)
    return g, rng.uniform(-1, 1, (count, 3)) * [1, 0, 1]


def errors(run: Flow) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(e_x, e_y, e_theta), the heading wrapped."""
    e = se2.between(run.follower.g, run.leader.g)
    return e[..., 0], e[..., 1], se2.wrap(e[..., 2])


@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_inner_loop_forgets_its_start_exponentially(twist: tuple[float, ...]) -> None:
    """v - v_c and omega - omega_c are e^(-K t) times their start, exactly, since v_c' is exact."""
    g, xi = starts(10)
    run = flow(KANAYAMA, g, xi, twist, 3.0)
    left = run.follower.xi[..., ::2] - velocities(KANAYAMA, Scene(run.follower, run.leader))
    np.testing.assert_allclose(left, np.exp(-5.0 * run.time)[:, None, None] * left[:1], atol=ODE)


def velocities(law: Rival, scene: Scene) -> np.ndarray:
    """(v_c, omega_c), read off the command: u = (v_c, omega_c)' - K ((v, omega) - (v_c, omega_c))."""
    without, with_gain = (first_command(replace(law, k_inner=k_inner), scene) for k_inner in (0.0, 1.0))
    return scene.follower.xi[..., ::2] + with_gain - without


@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_kanayama_s_storage_falls_once_velocities_are_as_commanded(twist: tuple[float, ...]) -> None:
    """(e_x^2 + e_y^2)/2 + (1 - cos e_theta)/k_y, with velocities on what is commanded from the start."""
    run = flow(KANAYAMA, *on_command(KANAYAMA, starts(20)[0], twist), twist, 20.0)
    e_x, e_y, e_theta = errors(run)
    storage = (e_x**2 + e_y**2) / 2 + (1 - np.cos(e_theta)) / KANAYAMA.k_y
    assert (np.diff(storage, axis=0) <= ODE).all()
    assert (storage[-1] < 1e-4 * storage[0]).all()


@pytest.mark.parametrize("twist", [LINE, CIRCLE, REVERSE], ids=["line", "circle", "reverse"])
def test_samson_s_storage_falls_once_velocities_are_as_commanded(twist: tuple[float, ...]) -> None:
    """b (e_x^2 + e_y^2)/2 + e_theta^2/2."""
    run = flow(SAMSON, *on_command(SAMSON, starts(20)[0], twist), twist, 20.0)
    e_x, e_y, e_theta = errors(run)
    storage = SAMSON.b * (e_x**2 + e_y**2) / 2 + e_theta**2 / 2
    assert (np.diff(storage, axis=0) <= ODE).all()
    assert (storage[-1] < 1e-4 * storage[0]).all()


def on_command(
    law: Kanayama | Samson | LookAhead, g: np.ndarray, twist: tuple[float, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The poses, and the velocities that the law commands at them; its derivatives and inner loop need no velocity."""
    still = np.zeros_like(g)
    scene = Scene(Robots(g, still), Leader(still, still + twist, still))
    return g, np.insert(velocities(law, scene), 1, 0.0, axis=-1)


@pytest.mark.parametrize("twist", [LINE, CIRCLE, (0.0, 0.0, 0.5)], ids=["line", "circle", "spin"])
def test_jiang_nijmeijer_s_storage_falls_from_every_start(twist: tuple[float, ...]) -> None:
    """V of the class' docstring, from any velocities; and all of it is gone on an exciting reference."""
    law = replace(JIANG_NIJMEIJER, gamma=0.5, coupling=2.0)
    run = flow(law, *starts(20), twist, 40.0)
    e_x, e_y, e_theta = errors(run)
    v, omega = run.follower.xi[..., 0], run.follower.xi[..., 2]
    aside = np.sinc(e_theta / PI) * e_y
    v_left = v - twist[0] * np.cos(e_theta) - law.k_x * e_x
    omega_left = omega - twist[2] - law.k_theta * e_theta - law.gamma * twist[0] * aside
    storage = (e_x**2 + e_y**2 + e_theta**2 / law.gamma) / 2
    storage += (v_left**2 + omega_left**2 / law.gamma) / (2 * law.coupling)
    assert (np.diff(storage, axis=0) <= ODE).all()
    assert (storage[-1] < 1e-3 * storage[0]).all()


@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_feedback_linearisation_is_linear_away_from_v_0(twist: tuple[float, ...]) -> None:
    """e'' + kd e' + kp e = 0 in the world frame, by the matrix exponential; omega starts on its command."""
    law = FEEDBACK_LINEARISATION
    g = np.array([[-0.6, 0.3, 0.1], [0.2, -0.4, -0.2], [-1.0, 0.0, 0.3]])
    xi = np.zeros((3, 3))
    xi[:, 0] = [1.2, 0.9, 1.0]
    leader = Leader(np.zeros((3, 3)), np.zeros((3, 3)) + twist, np.zeros((3, 3)))
    xi[:, 2] = velocities(law, Scene(Robots(g, xi), leader))[:, 1]
    run = flow(law, g, xi, twist, 20.0)
    assert run.follower.xi[..., 0].min() > law.v_min
    place = run.leader.g[..., :2] - run.follower.g[..., :2]
    velocity = [se2.rotate(g[..., 2], xi[..., :2]) for g, xi in (run.leader[:2], run.follower)]
    start = np.stack([place, velocity[0] - velocity[1]], axis=-1)[0]
    matrix = np.array([[0.0, 1.0], [-law.kp, -law.kd]])
    expected = np.array([start @ expm(matrix * t).T for t in run.time])[..., 0]
    np.testing.assert_allclose(place, expected, atol=ODE)


@pytest.mark.parametrize(
    "twist", [LINE, CIRCLE, REST, REVERSE], ids=["line", "circle", "rest", "reverse"]
)
def test_look_ahead_brings_the_point_in_exponentially(twist: tuple[float, ...]) -> None:
    """z - z_r = e^(-k t) times its start, whatever the leader does."""
    law = LOOK_AHEAD
    run = flow(law, *on_command(law, starts(20)[0], twist), twist, 20.0)
    ahead = np.array([law.distance, 0.0, 0.0])
    z, z_r = (se2.compose(g, ahead + np.zeros_like(g))[..., :2] for g in (run.follower.g, run.leader.g))
    np.testing.assert_allclose(z - z_r, np.exp(-law.k * run.time)[:, None, None] * (z - z_r)[0], atol=1e-6)


def test_look_ahead_leaves_the_heading_at_a_leader_at_rest() -> None:
    """The point arrives, the axle stays 2 d sin(|e_theta|/2) away."""
    run = flow(LOOK_AHEAD, *starts(20), REST, 20.0)
    e_x, e_y, e_theta = (values[-1] for values in errors(run))
    np.testing.assert_allclose(np.hypot(e_x, e_y), 2 * 0.5 * np.abs(np.sin(e_theta / 2)), atol=1e-6)
    assert np.median(np.abs(e_theta)) > 0.5


def test_kanayama_and_jiang_nijmeijer_stop_abreast_of_a_leader_at_rest() -> None:
    """e_x vanishes, e_y does not: no excitation."""
    for law in (KANAYAMA, JIANG_NIJMEIJER):
        e_x, e_y, _ = (values[-1] for values in errors(flow(law, *starts(20), REST, 30.0)))
        assert np.abs(e_x).max() < POSITION
        assert np.median(np.abs(e_y)) > 1.0


# -- scenarios ----------------------------------------------------------------------------------------

CASE = """
name: rival
duration: 20
control_rate: 50
leader:
  start: {{pose: [0, 0, 0]}}
  input: {{u_x: "where(t < 2, 0.5, 0)", u_theta: "0.2*cos(0.5*t)"}}
followers:
  - {{name: follower, parents: [leader], start: {{pose: [-2, 1, 0.5]}}}}
law: {{name: {name}}}
"""


def scenario(name: str, *overrides: str) -> Scenario:
    return load_text(CASE.format(name=name), overrides=overrides)


@every_rival
def test_a_scenario_s_defaults_are_the_law_tested_here(name: str) -> None:
    assert make_law(scenario(name).law, Similarity()) == RIVALS[name].bound()
    assert build(scenario(name)).law.warnings() == ()


@every_rival
def test_gains_of_a_scenario_are_brought_to_the_robot(name: str) -> None:
    """L = 1/2 and T = 4, by hand."""
    law = make_law(scenario(name).law, Similarity(0.5, 4.0))
    expected = {
        "kanayama": Kanayama(0.25, 4.0, 4.0, 1.25),
        "samson": Samson(0.7, 4.0, 1.25),
        "jiang_nijmeijer": JiangNijmeijer(0.25, 4.0, 0.25, 1.25, 0.0625),
        "feedback_linearisation": FeedbackLinearisation(0.0625, 0.625, 1.25, 0.0125),
        "look_ahead": LookAhead(0.25, 0.25, 1.25),
    }
    assert law == expected[name].bound()


@every_rival
def test_scaled_closed_loop_is_the_same_in_its_own_units(name: str) -> None:
    """The same scenario at a table's size and a quarter of the pace, with as many control periods."""
    poses = []
    for length, time in ((1.0, 1.0), (0.1, 4.0)):
        scaling = f"similarity={{length: {length}, time: {time}}}"
        experiment = build(scenario(name, scaling, f"control_rate={50 / time}"))
        run = experiment.rollout(IdealSimulation(experiment.network.names, None, experiment.dt))
        poses.append(experiment.similarity.poses_to_scenario(run.variables["pose"]))
    assert len(poses[0]) == 1001
    np.testing.assert_allclose(poses[1], poses[0], rtol=0, atol=SAME_IN_OWN_UNITS)


@pytest.mark.slow
@every_rival
def test_rival_drives_wheels_as_it_drives_its_ideal_twin(name: str) -> None:
    """nh_mini at a tenth of the size: leader and follower keep to the ideal model's path, throughout."""
    table = ("similarity={length: 0.1, time: 2}", "control_rate=100", "duration=5")
    poses = []
    for backend in ("ideal", "mujoco"):
        recording = simulate(scenario(name, *table, f"backend={backend}")).recording
        poses.append(recording["pose"].values)
    assert poses[1].shape == (1001, 2, 3)
    np.testing.assert_allclose(poses[1], poses[0], rtol=0, atol=ON_WHEELS)


# -- sampled at 50 Hz: whether they arrive --------------------------------------------------------------

RATE = 50.0  # [Hz]


def late_errors(law: Rival, twist: tuple[float, ...], count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Largest position and heading errors over the last 10 of 60 s of each start, shape (count,)."""
    g, xi = np.zeros((2, count, 2, 3))
    g[:, 1], xi[:, 1] = starts(count)
    xi[:, 0] = twist
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    simulation = IdealSimulation(network.names, None, 1 / RATE, keep_going=True)
    run = rollout(simulation, law.bound(), network, np.zeros((round(60 * RATE), 2)), State(0.0, g, xi))
    assert not simulation.lost.any()
    e = np.abs(run.variables["error"][run.time >= 50, :, 1])
    return np.hypot(e[..., 0], e[..., 1]).max(axis=0), e[..., 2].max(axis=0)


@pytest.mark.slow
@every_rival
@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_every_start_arrives_at_a_leader_that_drives_forward(name: str, twist: tuple[float, ...]) -> None:
    position, heading = late_errors(RIVALS[name], twist)
    assert position.max() < POSITION
    assert heading.max() < HEADING


@pytest.mark.slow
@every_rival
def test_a_leader_at_rest_is_aligned_with_by_none(name: str) -> None:
    """Position, heading or both are left over (docs/theory.md, rivals)."""
    position, heading = late_errors(RIVALS[name], REST)
    assert ((position < POSITION) & (heading < HEADING)).mean() <= 0.05  # one that began on the leader's axle line
    if name == "feedback_linearisation":
        assert position.max() < POSITION


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kanayama", "look_ahead"])
def test_a_leader_in_reverse_is_lost_by_laws_for_forward_motion(name: str) -> None:
    position, heading = late_errors(RIVALS[name], REVERSE)
    assert not ((position < POSITION) & (heading < HEADING)).any()
