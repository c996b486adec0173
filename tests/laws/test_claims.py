"""The laws against the paper written a second time, and what they do in the long run."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, logm

import independent
import tolerances as tol
from array_laws import Leader, Published, Robots, Stabiliser
from drives import DRIVE
from nhtrack import se2
from nhtrack.experiment.loop import rollout
from nhtrack.network import Network
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State
from nhtrack.testing.scenes import plain_walk

pytestmark = pytest.mark.property

PI = math.pi
AnyLaw = Published | Stabiliser
EXAMPLES: list[AnyLaw] = [
    Published(4.0, 6.0, 2.0, 7.0),
    Published(4.0, 6.0, 2.0, 7.0, variant="full"),
    Stabiliser(4.0, 6.0, 7.0),
]
every_law = pytest.mark.parametrize("law", EXAMPLES, ids=["published", "full", "stabiliser"])


# -- what is drawn ----------------------------------------------------------------------------------


class Scene(NamedTuple):
    """Followers and their leaders, arrays (..., 3) and (..., 2)."""

    follower: Robots
    leader: Leader


def first_command(law: AnyLaw, scene: Scene) -> np.ndarray:
    return np.asarray(law(scene.follower, scene.leader, law.init(scene.follower, scene.leader))[0])


def paper(law: AnyLaw) -> independent.PaperLaw:
    """The same law in the independent implementation."""
    if isinstance(law, Stabiliser):
        return independent.PaperLaw(law.kp, law.kd, 0.0, law.k, stabiliser=True)
    return independent.PaperLaw(law.kp, law.kd, law.ke, law.k, bracket=law.variant == "full")


# -- the paper --------------------------------------------------------------------------------------


@every_law
def test_law_is_the_paper_s(law: AnyLaw) -> None:
    """Equal to the general form (eq. 25) in matrices, with and without its bracket, and to Lemma 1."""
    walk = plain_walk()
    for follower, leader in zip(walk.follower[0], walk.leader[0], strict=True):
        scene = Scene(Robots(*np.split(follower, 2)), Leader(*np.split(leader, 3)))
        moving = [0, 1, 2, 3, 5]  # all but the lateral velocity, which is zero
        expected = paper(law)(follower[moving], leader[moving], leader[[6, 8]], independent.Branch(0.25))
        np.testing.assert_allclose(first_command(law, scene), expected, rtol=tol.LOGM, atol=tol.LOGM)


def test_published_and_full_differ_by_the_bracket() -> None:
    """u_x differs by -omega_1 v_y01 (docs/theory.md, slip 1), worked by hand."""
    follower = Robots(np.array([1.0, 2.0, PI / 2]), np.array([0.5, 0.0, 3.0]))
    leader = Leader(np.zeros(3), np.array([0.7, 0.0, 0.2]), np.zeros(3))
    published, full = (first_command(law, Scene(follower, leader)) for law in EXAMPLES[:2])
    v_y01 = 0.7 - 0.2 * 2.0  # (v_0 - omega_0 r_y) sin(pi/2) - omega_0 r_x cos(pi/2)
    assert full[0] - published[0] == pytest.approx(-3.0 * v_y01, abs=tol.HAND)
    assert full[1] == published[1]


# -- dead zones -------------------------------------------------------------------------------------


def on_target(xi_0: tuple[float, float, float], u_0: tuple[float, float]) -> Scene:
    g, xi = np.array([0.4, -0.3, 2.0]), np.array(xi_0)
    return Scene(Robots(g, xi), Leader(g.copy(), xi.copy(), np.array([u_0[0], 0.0, u_0[1]])))


@pytest.mark.parametrize("variant", ["published", "full"])
@pytest.mark.parametrize("xi_0", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.5), (0.0, 0.0, 2.0)])
def test_on_target_the_command_is_the_feedforward(variant: str, xi_0: tuple[float, float, float]) -> None:
    """0/0 in beta, and in the adjoint attitude where the leader rests, count as 0."""
    law = replace(EXAMPLES[0], variant=variant)
    np.testing.assert_array_equal(first_command(law, on_target(xi_0, (0.7, -0.2))), [0.7, -0.2])


@every_law
def test_beta_is_noise_within_its_dead_zone(law: AnyLaw) -> None:
    """|q| just inside the dead zone: no steering; just outside: k beta of it."""
    law = replace(law, dead_zone_length=1e-3)
    steering = []
    for size in (0.999e-3, 1.001e-3):
        follower = Robots(np.array([0.6 * size, 0.8 * size, 0.0]), np.zeros(3))
        steering.append(first_command(law, Scene(follower, Leader(np.zeros(3), np.zeros(3), np.zeros(3))))[1])
    assert steering == [0.0, pytest.approx(law.kp * law.k * math.atan(0.8 / 0.6), rel=tol.HAND)]


@pytest.mark.parametrize("variant", ["published", "full"])
def test_adjoint_attitude_is_noise_within_its_dead_zone(variant: str) -> None:
    """A leader turning slower than the dead zone in place asks for no attitude, a faster one for +-pi/2."""
    law = Published(4.0, 6.0, 2.0, 7.0, variant=variant, dead_zone_speed=1e-3)
    steering = []
    for omega in (0.999e-3, 1.001e-3):
        leader = Leader(np.zeros(3), np.array([0.0, 0.0, omega]), np.zeros(3))
        steering.append(first_command(law, Scene(Robots(np.array([1.0, 0.0, 0.0]), leader.xi), leader))[1])
    assert steering == [0.0, pytest.approx(2.0 * PI / 2, rel=tol.HAND)]


# -- Bullo's lemma ----------------------------------------------------------------------------------


def log_feedback(g: np.ndarray, xi: np.ndarray, kp: float, kd: float) -> np.ndarray:
    """-kp log g - kd xi (Lemma 6), of a body with three inputs."""
    return -kp * np.asarray(se2.log(g)) - kd * xi


def log_paper(g: np.ndarray) -> np.ndarray:
    """(q_x, q_y, theta) by scipy's matrix logarithm."""
    theta, x, y = independent.vee(np.real(logm(independent.pose_matrix(g))))
    return np.array([x, y, theta])


def test_log_feedback_is_the_matrix_logarithm() -> None:
    for g, xi in np.random.default_rng(1).uniform(-1, 1, (10, 2, 3)) * [[10.0, 10.0, 3.1], [5.0, 5.0, 5.0]]:
        expected = -2.0 * log_paper(g) - 3.0 * xi
        np.testing.assert_allclose(log_feedback(g, xi, 2.0, 3.0), expected, rtol=tol.LOGM, atol=tol.LOGM * 20)


def test_log_feedback_stabilises_a_fully_actuated_body() -> None:
    """From random |theta| < pi; theta'' = -kp theta - kd theta', and the heading's energy only falls."""
    kp, kd, bodies = 1.0, 2.5, 40
    rng = np.random.default_rng(5)
    reach, push = np.array([10.0, 10.0, 0.999 * PI]), np.array([2.0, 2.0, 0.2])
    start = np.concatenate(
        [rng.uniform(-reach, reach, (bodies, 3)), rng.uniform(-push, push, (bodies, 3))], axis=-1
    )

    def rate(_: float, flat: np.ndarray) -> np.ndarray:
        g, xi = np.split(flat.reshape(bodies, 6), 2, axis=-1)
        velocity = np.concatenate([se2.rotate(g[:, 2], xi[:, :2]), xi[:, 2:]], axis=-1)
        return np.concatenate([velocity, log_feedback(g, xi, kp, kd)], axis=-1).ravel()

    times = np.linspace(0.0, 40.0, 81)
    solution = solve_ivp(
        rate, (0.0, 40.0), start.ravel(), method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times
    )
    path = solution.y.T.reshape(len(times), bodies, 6)
    linear = [expm(np.array([[0.0, 1.0], [-kp, -kd]]) * t) @ start[:, [2, 5]].T for t in times]
    np.testing.assert_allclose(path[..., [2, 5]], np.moveaxis(linear, 1, 2), atol=tol.ODE)
    energy = kp * path[..., 2] ** 2 + path[..., 5] ** 2
    assert (np.diff(energy, axis=0) <= tol.ODE).all()
    size = np.linalg.norm(path, axis=-1)
    assert (size[-1] <= tol.SETTLED * size[0]).all()
    assert (size[40] <= 1e-2 * size[0]).all()


# -- what the laws do in the long run: THEORY's findings, measured ------------------------------------

RATE = 50.0  # [Hz]


class Errors(NamedTuple):
    """Worst position [m] and heading [rad] errors over a share at the end of each run, shape (runs,)."""

    position: np.ndarray
    heading: np.ndarray


def starts(count: int, reach: float = 10.0) -> np.ndarray:
    """Follower poses (count, 3) anywhere in a square, any heading."""
    rng = np.random.default_rng(2024)
    return np.concatenate([rng.uniform(-reach, reach, (count, 2)), rng.uniform(-PI, PI, (count, 1))], axis=-1)


def chase(law: AnyLaw, poses: np.ndarray, leader_twist: tuple[float, float], duration: float) -> Errors:
    """Late errors of followers at rest that chase a leader of constant twist, all runs in one batch."""
    g = np.stack([np.zeros_like(poses), poses], axis=-2)
    xi = np.zeros_like(g)
    xi[:, 0, 0], xi[:, 0, 2] = leader_twist
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    periods = round(duration * RATE)
    inputs = np.zeros((periods, len(poses), 2))
    done = rollout(IdealSimulation(network.names, DRIVE, 1 / RATE), law.bound(), network, inputs, State(0.0, g, xi))
    assert done.failure is None
    late = done.variables["error"][-periods // 5 :, :, 1]
    return Errors(np.hypot(late[..., 0], late[..., 1]).max(axis=0), np.abs(late[..., 2]).max(axis=0))


def converged(errors: Errors) -> np.ndarray:
    return (errors.position < tol.CONVERGED) & (errors.heading < tol.CONVERGED)


@pytest.mark.slow
def test_lemma_1_above_the_bound_every_start_converges() -> None:
    """k = 6 > 2 and kd > 2 sqrt(kp): position and heading."""
    law = Stabiliser(4.0, 4.2, 6.0, dead_zone_length=1e-9)
    assert converged(chase(law, starts(100), (0.0, 0.0), 30.0)).all()


@pytest.mark.slow
def test_lemma_1_below_the_bound_no_start_converges() -> None:
    """k = 1.5 < 2, which the paper does not exclude: every follower stops abreast of its leader.

    There q_x = 0 holds it in place and beta = +-pi/2 holds its heading at +-k pi/2, at any distance.
    """
    errors = chase(Stabiliser(4.0, 4.2, 1.5, dead_zone_length=1e-9), starts(100), (0.0, 0.0), 40.0)
    np.testing.assert_allclose(errors.heading, 1.5 * PI / 2, atol=tol.CONVERGED)
    assert errors.position.max() > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["published", "full"])
def test_theorem_1_leader_at_rest_above_the_bound_every_start_converges(variant: str) -> None:
    """k_eff = k kp/(kp + ke) = 6 > 2."""
    law = Published(4.0, 4.2, 1.0, 7.5, variant=variant, dead_zone_length=1e-9, dead_zone_speed=1e-9)
    assert converged(chase(law, starts(100), (0.0, 0.0), 30.0)).all()


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["published", "full"])
@pytest.mark.parametrize("twist", [(1.0, 0.0), (1.0, 0.5)], ids=["line", "circle"])
def test_theorem_1_moving_leader_no_start_converges(variant: str, twist: tuple[float, float]) -> None:
    """The paper claims global asymptotic tracking; measured, every start ends on a cycle instead.

    Gains above both bounds. The cycle stays: bounded in position, and of a size in heading.
    """
    law = Published(4.0, 6.0, 2.0, 7.0, variant=variant, dead_zone_length=1e-9, dead_zone_speed=1e-9)
    errors = chase(law, starts(50), twist, 60.0)
    assert not converged(errors).any()
    assert errors.position.max() < 1.0
    assert errors.position.min() > 0.02
    assert errors.heading.min() > 0.1
    assert errors.heading.max() < PI / 2
