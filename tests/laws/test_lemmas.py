"""The paper's lemmas on relative motion, and the steps of its proofs that hold or do not (docs/theory.md)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tolerances as tol
from array_laws import Leader, Robots
from nhtrack import se2
from nhtrack.laws.contract import Follower
from nhtrack.laws.contract import Leader as OneLeader
from nhtrack.laws.relative_motion import Relative, adjoint_attitude, relative_motion
from nhtrack.simulation.ideal import propagate

pytestmark = pytest.mark.property

PI = math.pi
STEP = 1e-4  # [s] of the central differences


class Pair(NamedTuple):
    """A leader and a follower on wheels under held accelerations, arrays (2, ...)."""

    g: np.ndarray
    xi: np.ndarray
    u: np.ndarray

    def at(self, t: float) -> tuple[Robots, Leader]:
        """Follower and leader t later, by the flow of the ideal model."""
        g, xi = propagate(self.g, self.xi, self.u, t)
        force = np.insert(self.u, 1, 0.0, axis=-1)
        return Robots(g[1], xi[1]), Leader(g[0], xi[0], force[0])

    @property
    def force(self) -> np.ndarray:
        return np.insert(self.u, 1, 0.0, axis=-1)


few = settings(max_examples=30)
bounded = st.floats(-2.0, 2.0)


@st.composite
def pairs(draw_: st.DrawFn) -> Pair:
    numbers = np.array(draw_(st.tuples(*[bounded] * 14))).reshape(2, 7)
    xi = np.stack([numbers[:, 3], np.zeros(2), numbers[:, 4]], axis=-1)
    return Pair(numbers[:, :3] * [1.0, 1.0, 0.7], xi, numbers[:, 5:])


def relative(follower: Robots, leader: Leader) -> Relative:
    return relative_motion(Follower(*follower.g, *follower.xi), OneLeader(*leader.g, *leader.xi, *leader.u), 0, 0.25)


def relative_twist(pair: Pair, t: float) -> np.ndarray:
    seen = relative(*pair.at(t))
    return np.array([seen.v_x, seen.v_y, seen.omega])


@few
@given(pairs())
def test_lemma_2_and_the_dynamics_of_the_relative_motion(pair: Pair) -> None:
    """d/dt Ad_{g_01^-1} xi_0 = [xi_1, xi_01] for xi_0 held; so xi_01' = u_1 - Ad u_0 - [xi_1, xi_01] (eq. 12)."""
    (follower, leader), held = pair.at(0.0), pair.xi[0]

    def carried(t: float) -> np.ndarray:
        robot, ahead = pair.at(t)
        return np.asarray(se2.Ad_inverse(se2.between(ahead.g, robot.g), held))

    bracket = se2.ad(follower.xi, relative_twist(pair, 0.0))
    found = (carried(STEP) - carried(-STEP)) / (2 * STEP)
    np.testing.assert_allclose(found, bracket, atol=tol.VIRTUAL_TWIST)
    expected = pair.force[1] - se2.Ad_inverse(se2.between(leader.g, follower.g), leader.u) - bracket
    found = (relative_twist(pair, STEP) - relative_twist(pair, -STEP)) / (2 * STEP)
    np.testing.assert_allclose(found, expected, atol=tol.VIRTUAL_TWIST)


@few
@given(pairs())
def test_lemma_3_relative_twist_is_the_rate_of_the_relative_pose(pair: Pair) -> None:
    """g_01' = g_01 xi_01: the relative pose rests only where xi_01 vanishes."""

    def pose(t: float) -> np.ndarray:
        robot, ahead = pair.at(t)
        return np.asarray(se2.between(ahead.g, robot.g))

    found = np.asarray(se2.log(se2.between(pose(-STEP), pose(STEP)))) / (2 * STEP)
    np.testing.assert_allclose(found, relative_twist(pair, 0.0), atol=tol.VIRTUAL_TWIST)


@few
@given(pairs())
def test_lemma_4_at_the_adjoint_attitude_the_relative_motion_has_no_lateral_part(pair: Pair) -> None:
    """v_y01 = 0 for a follower without lateral velocity whose heading is theta~01."""
    follower, leader = pair.at(0.0)
    attitude = adjoint_attitude(relative(follower, leader), 0.0)
    turned = follower._replace(g=np.array([*follower.g[:2], leader.g[2] + attitude]))
    lateral = relative(turned, leader).v_y
    assert abs(lateral) <= 100 * tol.ALGEBRA


@few
@given(pairs(), st.floats(-3.0, 3.0), st.tuples(bounded, bounded, bounded).map(np.array))
def test_lemma_5_relative_motion_splits_at_any_frame(pair: Pair, heading: float, twist: np.ndarray) -> None:
    """g_01 = g~_01 g_e and xi_01 = xi_e + Ad_{g_e^-1} xi~_01, whatever twist the frame in between is given."""
    (g_0, g_1), (xi_0, xi_1) = pair.g, pair.xi
    between = np.array([*g_1[:2], heading])
    g_e, g_a = se2.between(between, g_1), se2.between(g_0, between)
    xi_e, xi_a = xi_1 - se2.Ad_inverse(g_e, twist), twist - se2.Ad_inverse(g_a, xi_0)
    g_01 = se2.between(g_0, g_1)
    np.testing.assert_allclose(se2.compose(g_a, g_e), g_01, atol=100 * tol.ALGEBRA)
    whole = xi_1 - se2.Ad_inverse(g_01, xi_0)
    np.testing.assert_allclose(xi_e + se2.Ad_inverse(g_e, xi_a), whole, atol=1e3 * tol.ALGEBRA)


def test_theorem_1_s_frame_does_not_have_the_twist_its_proof_gives_it() -> None:
    """The frame at the follower's place with the adjoint attitude turns at theta_0' + theta~01', not at omega_1.

    The proof sets its twist to Ad_{g_e} xi_1, which would make xi_e vanish and g_e stand still; and its lateral
    velocity v_1 sin(theta_e) is not zero either, which Lemma 4 asks for.
    """
    poses, twists = np.array([[0.0, 0.0, 0.3], [1.2, -0.8, 1.0]]), np.array([[1.0, 0.0, 0.5], [0.7, 0.0, -0.4]])
    pair = Pair(poses, twists, np.zeros((2, 2)))

    def frame(t: float) -> np.ndarray:
        robot, ahead = pair.at(t)
        attitude = adjoint_attitude(relative(robot, ahead), 0.0)
        return np.array([*robot.g[:2], ahead.g[2] + attitude])

    twist = np.asarray(se2.log(se2.between(frame(-STEP), frame(STEP)))) / (2 * STEP)
    theta_e = pair.g[1, 2] - frame(0.0)[2]
    assigned = se2.Ad(np.array([0.0, 0.0, theta_e]), pair.xi[1])
    np.testing.assert_allclose(twist[:2], assigned[:2], atol=tol.VIRTUAL_TWIST)
    assert twist[1] == pytest.approx(0.7 * math.sin(theta_e), abs=tol.VIRTUAL_TWIST)
    assert abs(twist[1]) > 0.1
    assert abs(twist[2] - assigned[2]) > 0.5


def test_adjoint_attitude_jumps_by_pi_where_the_carried_velocity_turns_back() -> None:
    """Slip 3: v_0 - omega_0 r_y changes sign at r_y = v_0/omega_0, level with the leader's centre of turning."""
    leader, angles = Leader(np.zeros(3), np.array([1.0, 0.0, 0.5]), np.zeros(3)), []
    for y in (2.0 - 1e-9, 2.0 + 1e-9):
        follower = Robots(np.array([1.0, y, 0.0]), np.zeros(3))
        angles.append(adjoint_attitude(relative(follower, leader), 0.0))
    assert angles[0] - angles[1] == pytest.approx(PI, abs=1e-8)


@given(st.floats(0.3, 3.0), st.floats(-0.9, 0.9), st.floats(2.1, 20.0))
def test_slip_2_a_heading_of_m_phi_solves_the_steering_law(rho: float, phi: float, k: float) -> None:
    """theta + k beta = 0 at theta = m phi, m = 2k/(2 + k), where q points along phi - theta/2."""
    theta = 2 * k / (2 + k) * phi
    q = se2.log(np.array([rho * math.cos(phi), rho * math.sin(phi), theta]))
    assert math.atan2(q[1], q[0]) == pytest.approx(phi - theta / 2, abs=tol.HAND)
    assert theta - k * math.atan(q[1] / q[0]) == pytest.approx(0.0, abs=100 * tol.HAND)
