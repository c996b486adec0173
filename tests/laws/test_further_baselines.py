"""What the laws by cascade, by vector fields and by polar coordinates claim, and where they fail."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from array_laws import GuidingField, Leader, Panteley, PolarBackstepping, Robots, Vfo
from chases import (
    CIRCLE,
    LINE,
    REST,
    REVERSE,
    STEP,
    Scene,
    behind,
    errors,
    late_errors,
    later,
    on_command,
    random_scene,
    require_exact_derivatives,
    require_falling,
    reversal_distances,
    velocities,
)
from nhtrack import se2

pytestmark = pytest.mark.property

PI = math.pi
POSITION, HEADING = 0.01, 0.02  # [m], [rad]: what counts as converged at the scale of 1 m/s and starts 10 m away
SPIN = (0.0, 0.0, 0.5)

PANTELEY, VFO, GUIDING = Panteley(), Vfo(), GuidingField()
PARKING = PolarBackstepping()

# Poses that are hard: on the leader, within the docking radius, on its axis, turned round, and turned to either side.
HARD = np.array(
    [
        (x, y, theta)
        for x, y in ((0.0, 0.0), (0.003, 0.0), (0.0, -0.003), (2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0))
        for theta in (0.0, PI, -PI, PI / 2, -PI / 2, PI - 1e-9, 3 * PI)
    ]
)


def with_leaders(scene: Scene, speed: float, turning: float) -> Scene:
    """The same places, with leaders of so many times their speeds and accelerations."""
    shares = np.array([speed, 0.0, turning])
    g, xi, u = scene.leader
    return scene._replace(leader=Leader(g, xi * shares, u * shares))


def fast_enough(scene: Scene) -> Scene:
    """Those with leaders of at least 0.5 m/s, on circles of at least 0.5 m."""
    v, omega = np.abs(scene.leader.xi[:, 0]), np.abs(scene.leader.xi[:, 2])
    chosen = (v > 0.5) & (omega < 2 * v)
    return Scene(Robots(*(part[chosen] for part in scene.follower)), Leader(*(part[chosen] for part in scene.leader)))


def along(scene: Scene, field: Callable[[Scene], tuple[np.ndarray, np.ndarray]]) -> Scene:
    """The same places, followers heading along a field."""
    g = scene.follower.g.copy()
    g[:, 2] = field(scene)[1]
    return scene._replace(follower=scene.follower._replace(g=g))


def converged(late: np.ndarray) -> np.ndarray:
    return (late[2] < POSITION) & (late[3] < HEADING)


# -- formulas ---------------------------------------------------------------------------------------


def test_panteley_s_velocities_have_their_exact_derivatives() -> None:
    require_exact_derivatives(PANTELEY, random_scene((300,)))


@pytest.mark.parametrize("law", [VFO, GUIDING], ids=["vfo", "guiding_field"])
def test_velocities_along_a_field_have_their_exact_derivatives(law: Vfo | GuidingField) -> None:
    require_exact_derivatives(law, fast_enough(random_scene((300,))), driven=True)


def test_vfo_s_velocities_at_rest_have_their_exact_derivatives() -> None:
    """Of leaders that creep and turn, all but at rest by `least_speed`."""
    require_exact_derivatives(VFO, with_leaders(random_scene((300,)), 0.04, 1.0), driven=True)


def test_parking_s_velocities_have_their_exact_derivatives() -> None:
    require_exact_derivatives(PARKING, with_leaders(random_scene((300,)), 0.0, 0.0))


def test_gains_outside_vfo_s_conditions_are_told() -> None:
    assert [law.warnings() for law in (PANTELEY, VFO, GUIDING, PARKING)] == [()] * 4
    assert replace(VFO, eta=1.0).warnings() == (
        "eta = 1 is not below k_p = 1: on the axis of a leader at rest none comes nearer",
    )


# -- fields -----------------------------------------------------------------------------------------


def convergence_field(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """h and the direction of sigma h, of leaders that drive and of leaders at rest."""
    g_r, xi_r = scene.leader.g, scene.leader.xi
    e, axis = g_r[:, :2] - scene.follower.g[:, :2], np.stack([np.cos(g_r[:, 2]), np.sin(g_r[:, 2])], axis=-1)
    rest = np.abs(xi_r[:, :1]) <= VFO.least_speed
    gear = np.sign(np.where(rest, (e * axis).sum(axis=-1, keepdims=True), xi_r[:, :1]))
    h = VFO.k_p * e + xi_r[:, :1] * axis - rest * VFO.eta * gear * np.hypot(*e.T)[:, None] * axis
    return h, np.arctan2(*(gear * h).T[::-1])


def guiding_field(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """w and the direction of sigma w, by the gradient of the circle's equation, for leaders on circles."""
    g_r, (v, _, omega) = scene.leader.g, scene.leader.xi.T
    place = se2.between(g_r, scene.follower.g)[:, :2]
    centre = np.stack([np.zeros_like(v), v / omega], axis=-1)
    away, radius = place - centre, centre[:, 1]
    phi = (radius**2 - (away**2).sum(axis=-1)) / (2 * radius)
    normal = -away / radius[:, None]
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=-1)
    sign = np.sign(v)[:, None]
    w = se2.rotate(g_r[:, 2], sign * along - GUIDING.k_n * phi[:, None] * normal)
    return w, np.arctan2(*(sign * w).T[::-1])


DRIVING = fast_enough(random_scene((200,), seed=3))
RESTING = with_leaders(random_scene((200,), seed=3), 0.0, 0.0)
on_fields = pytest.mark.parametrize(
    ("law", "field", "scene"),
    [(VFO, convergence_field, DRIVING), (VFO, convergence_field, RESTING), (GUIDING, guiding_field, DRIVING)],
    ids=["vfo", "vfo at rest", "guiding_field"],
)


@on_fields
def test_follower_on_the_field_stays_on_it(law, field, scene: Scene) -> None:
    """Heading as the field and velocities as commanded: the heading's error grows with the square of time only."""
    scene = on_command(law, on_command(law, along(scene, field)))  # omega_c has v, v_c has no velocity
    off = [
        np.abs(se2.wrap(field(there)[1] - there.follower.g[:, 2]))
        for there in (later(scene, dt) for dt in (STEP, 2 * STEP))
    ]
    np.testing.assert_allclose(off[1], 4 * off[0], rtol=0.1, atol=1e-9)
    assert off[0].max() < 0.1 * STEP


@pytest.mark.parametrize("scene", [DRIVING, RESTING], ids=["driving", "at rest"])
def test_vfo_on_its_field_moves_as_the_field(scene: Scene) -> None:
    """p' = h, so that e' = -k_p e behind a leader that drives."""
    scene = along(scene, convergence_field)
    v, direction = velocities(VFO, scene)[:, 0], scene.follower.g[:, 2]
    moved = se2.rotate(direction, np.stack([v, 0 * v], axis=-1))
    np.testing.assert_allclose(moved, convergence_field(scene)[0], atol=1e-9)


def test_guiding_field_s_speed_keeps_the_leader_s_sign() -> None:
    """It is the leader's abreast of it, less ahead of it, more behind."""
    scene = fast_enough(random_scene((200,), seed=5))
    v, v_r = velocities(GUIDING, scene)[:, 0], scene.leader.xi[:, 0]
    ahead = se2.between(scene.leader.g, scene.follower.g)[:, 0]
    assert (np.sign(v) == np.sign(v_r)).all()
    assert (np.sign(v_r - v) == np.sign(ahead)).all()
    np.testing.assert_allclose(v * (v + 2 * GUIDING.k_x * ahead), v_r**2, rtol=1e-6)


def test_parking_s_storage_falls_once_velocities_are_as_commanded() -> None:
    """(delta^2 + z^2)/2 at a leader at rest, with so little k_gamma that no term of omega_c may be missing."""
    law = replace(PARKING, k_rho=2.0, k_delta=1.0, k_gamma=0.2)

    def storage(scene: Scene) -> np.ndarray:
        e = se2.between(scene.leader.g, scene.follower.g)
        delta = np.arctan2(-e[:, 1], -e[:, 0])
        gamma = se2.wrap(delta - e[:, 2])
        return (delta**2 + (gamma + np.arctan(2 * law.k_delta * delta) / 2) ** 2) / 2

    require_falling(storage, law, on_command(law, behind(REST)))


def test_parking_closes_in_as_its_leader_bears() -> None:
    """rho' = -k_rho rho cos^2 gamma, at a leader that drives, too: only its place is looked at."""
    scene = on_command(PARKING, behind(CIRCLE))
    e_x, _, _ = errors(scene)
    np.testing.assert_allclose(scene.follower.xi[:, 0], PARKING.k_rho * e_x, atol=1e-9)
    still = on_command(PARKING, behind(REST))
    np.testing.assert_array_equal(scene.follower.xi, still.follower.xi)


# -- sampled at 50 Hz: whether they arrive ----------------------------------------------------------


def weave(t: np.ndarray) -> np.ndarray:
    """Angular acceleration of a leader whose yaw rate swings by 0.5 rad/s about none."""
    return np.asarray(0.5 * 0.4 * np.cos(0.4 * t))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("twist", "turning", "k_x"),
    [(CIRCLE, None, 1.0), ((-1.0, 0.0, -0.5), None, 1.0), (SPIN, None, 1.0), (LINE, weave, 0.5)],
    ids=["circle", "reverse", "spin", "weave"],
)
def test_panteley_arrives_from_every_start_while_its_leader_keeps_turning(twist, turning, k_x: float) -> None:
    """k_x = 2 |omega_r|, critically damped; about that where omega_r swings through zero."""
    for begin in (None, HARD):
        late = late_errors(replace(PANTELEY, k_x=k_x), twist, begin=begin, turning=turning)
        assert converged(late).all()


@pytest.mark.slow
@pytest.mark.parametrize("twist", [LINE, REST], ids=["line", "rest"])
def test_panteley_leaves_the_lateral_error_where_its_leader_does_not_turn(twist: tuple[float, ...]) -> None:
    """omega_r = 0: e_x and e_theta vanish, and nothing moves e_y."""
    e_x, e_y, _, heading = late_errors(PANTELEY, twist)
    assert max(e_x.max(), heading.max()) < 1e-6
    assert np.median(e_y) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "twist", [LINE, CIRCLE, REVERSE, REST], ids=["line", "circle", "reverse", "rest"]
)
def test_vfo_arrives_from_every_start(twist: tuple[float, ...]) -> None:
    for begin in (None, HARD):
        assert converged(late_errors(VFO, twist, begin=begin)).all()


@pytest.mark.parametrize(("period", "factor"), [(2.0, 2.78), (4.0, 1.44), (6.0, 0.57), (8.0, 0.22)])
def test_vfo_drifts_off_a_leader_that_reverses_often(period: float, factor: float) -> None:
    """Outside its claim: from reversal to reversal the distance is multiplied by a number, however small it is."""
    far = reversal_distances(VFO.bound(), period, 4, 1e-5)
    assert np.median(far[-1] / far[-2]) == pytest.approx(factor, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("twist", [LINE, CIRCLE, REVERSE], ids=["line", "circle", "reverse"])
def test_guiding_field_arrives_behind_a_leader_that_drives(twist: tuple[float, ...]) -> None:
    for begin in (None, HARD):
        assert converged(late_errors(GUIDING, twist, begin=begin)).all()


@pytest.mark.slow
def test_guiding_field_arrives_from_the_centre_of_the_circle_too() -> None:
    """Where the field has no direction: it drives on."""
    centre = np.array([(0.0, CIRCLE[0] / CIRCLE[2], theta) for theta in (0.0, 1.0, PI, -2.0)])
    assert converged(late_errors(GUIDING, CIRCLE, begin=centre)).all()


@pytest.mark.slow
def test_guiding_field_stops_beside_a_leader_at_rest() -> None:
    """A path that nobody drives along: there is nothing to follow."""
    late = late_errors(GUIDING, REST)
    assert converged(late).mean() <= 0.05
    assert np.median(late[2]) > 1.0


@pytest.mark.slow
def test_parking_arrives_from_every_start() -> None:
    for begin in (None, HARD):
        assert converged(late_errors(PARKING, REST, begin=begin)).all()
    assert converged(late_errors(PARKING, REST, count=400)).all()


@pytest.mark.slow
def test_parking_lags_behind_a_leader_that_drives() -> None:
    """Outside its claim: on a line by v_r/k_rho + v_r/k_inner, the heading right; on a circle both are left."""
    e_x, e_y, _, heading = late_errors(PARKING, LINE)
    np.testing.assert_allclose(e_x, LINE[0] / PARKING.k_rho + LINE[0] / PARKING.k_inner, rtol=1e-3)
    assert max(e_y.max(), heading.max()) < 1e-3
    assert not converged(late_errors(PARKING, CIRCLE)).any()
