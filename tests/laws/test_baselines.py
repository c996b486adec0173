"""What the rival laws claim, and where they fail."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from array_laws import FeedbackLinearisation, JiangNijmeijer, Kanayama, LookAhead, Samson
from chases import (
    CIRCLE,
    LINE,
    REST,
    REVERSE,
    Scene,
    behind,
    errors,
    first_command,
    late_errors,
    on_command,
    random_scene,
    require_exact_derivatives,
    require_falling,
    velocities,
)
from nhtrack import se2

pytestmark = pytest.mark.property

PI = math.pi

# Some hundred rounded operations on terms up to 1e4 m/s^2, of which a sum may be a small difference.
ROUNDING = 1e-11

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


def test_gains_outside_the_source_s_conditions_are_told() -> None:
    assert replace(SAMSON, zeta=1.0).warnings() == (
        "zeta = 1 is not below 1: its source designs for complex poles, 0 < zeta < 1",
    )
    assert replace(FEEDBACK_LINEARISATION, kd=1.9).warnings() == (
        "kd = 1.9 is below 2 sqrt(kp) = 2: errors overshoot, and v passes the singularity",
    )
    assert [law.warnings() for law in RIVALS.values()] == [()] * 5
    assert replace(FEEDBACK_LINEARISATION, kd=2.0).warnings() == ()


# -- what is claimed, anywhere --------------------------------------------------------------------------

@pytest.mark.parametrize("law", [KANAYAMA, SAMSON, LOOK_AHEAD], ids=["kanayama", "samson", "look_ahead"])
def test_commanded_velocities_have_their_exact_derivatives(law: Rival) -> None:
    """(v_c, omega_c)' against central differences along the motion of both robots, of a leader that accelerates."""
    require_exact_derivatives(law, random_scene((300,)))


@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_kanayama_s_storage_falls_once_velocities_are_as_commanded(twist: tuple[float, ...]) -> None:
    """(e_x^2 + e_y^2)/2 + (1 - cos e_theta)/k_y."""

    def storage(scene: Scene) -> np.ndarray:
        e_x, e_y, e_theta = errors(scene)
        return (e_x**2 + e_y**2) / 2 + (1 - np.cos(e_theta)) / KANAYAMA.k_y

    require_falling(storage, KANAYAMA, on_command(KANAYAMA, behind(twist)))


@pytest.mark.parametrize("twist", [LINE, CIRCLE, REVERSE], ids=["line", "circle", "reverse"])
def test_samson_s_storage_falls_once_velocities_are_as_commanded(twist: tuple[float, ...]) -> None:
    """b (e_x^2 + e_y^2)/2 + e_theta^2/2."""

    def storage(scene: Scene) -> np.ndarray:
        e_x, e_y, e_theta = errors(scene)
        return SAMSON.b * (e_x**2 + e_y**2) / 2 + e_theta**2 / 2

    require_falling(storage, SAMSON, on_command(SAMSON, behind(twist)))


@pytest.mark.parametrize("twist", [LINE, CIRCLE, (0.0, 0.0, 0.5)], ids=["line", "circle", "spin"])
def test_jiang_nijmeijer_s_storage_falls_from_every_start(twist: tuple[float, ...]) -> None:
    """V of the class' docstring, at any velocities."""
    law = replace(JIANG_NIJMEIJER, gamma=0.5, coupling=2.0)

    def storage(scene: Scene) -> np.ndarray:
        e_x, e_y, e_theta = errors(scene)
        v, omega = scene.follower.xi[..., 0], scene.follower.xi[..., 2]
        v_left = v - twist[0] * np.cos(e_theta) - law.k_x * e_x
        omega_left = omega - twist[2] - law.k_theta * e_theta - law.gamma * twist[0] * np.sinc(e_theta / PI) * e_y
        whole = (e_x**2 + e_y**2 + e_theta**2 / law.gamma) / 2
        return np.asarray(whole + (v_left**2 + omega_left**2 / law.gamma) / (2 * law.coupling))

    require_falling(storage, law, behind(twist))


def test_feedback_linearisation_is_linear_away_from_v_0() -> None:
    """e'' + kd e' + kp e = 0 in the world frame, once omega is as commanded."""
    law, (follower, leader) = FEEDBACK_LINEARISATION, behind(CIRCLE)
    follower.xi[:, 0] = np.abs(follower.xi[:, 0]) + law.v_min
    follower.xi[:, 2] = velocities(law, Scene(follower, leader))[:, 1]
    u_x, v, omega = first_command(law, Scene(follower, leader))[:, 0], follower.xi[:, 0], follower.xi[:, 2]
    turned = np.stack([np.zeros(500), np.full(500, CIRCLE[0] * CIRCLE[2])], axis=-1)
    second = se2.rotate(leader.g[:, 2], turned) - se2.rotate(follower.g[:, 2], np.stack([u_x, v * omega], axis=-1))
    first = se2.rotate(leader.g[:, 2], leader.xi[:, :2]) - se2.rotate(follower.g[:, 2], follower.xi[:, :2])
    place = leader.g[:, :2] - follower.g[:, :2]
    np.testing.assert_allclose(second + law.kd * first + law.kp * place, 0, atol=ROUNDING)


@pytest.mark.parametrize(
    "twist", [LINE, CIRCLE, REST, REVERSE], ids=["line", "circle", "rest", "reverse"]
)
def test_look_ahead_brings_the_point_in_exponentially(twist: tuple[float, ...]) -> None:
    """z' - z_r' = -k (z - z_r), whatever the leader does."""
    law = LOOK_AHEAD
    follower, (leader_g, leader_xi, _) = on_command(law, behind(twist))
    arm = np.array([law.distance, 0.0])
    z, z_r = se2.act(follower.g, arm), se2.act(leader_g, arm)
    rates = [
        se2.rotate(g[:, 2], np.stack([xi[:, 0], xi[:, 2] * law.distance], axis=-1))
        for g, xi in (follower, (leader_g, leader_xi))
    ]
    np.testing.assert_allclose(rates[0] - rates[1], -law.k * (z - z_r), atol=ROUNDING)


# -- sampled at 50 Hz: whether they arrive --------------------------------------------------------------

@pytest.mark.slow
@every_rival
@pytest.mark.parametrize("twist", [LINE, CIRCLE], ids=["line", "circle"])
def test_every_start_arrives_at_a_leader_that_drives_forward(name: str, twist: tuple[float, ...]) -> None:
    _, _, position, heading = late_errors(RIVALS[name], twist)
    assert position.max() < POSITION
    assert heading.max() < HEADING


@pytest.mark.slow
@every_rival
def test_a_leader_at_rest_is_aligned_with_by_none(name: str) -> None:
    """Position, heading or both are left over (docs/theory.md, rivals)."""
    e_x, e_y, position, heading = late_errors(RIVALS[name], REST)
    assert ((position < POSITION) & (heading < HEADING)).mean() <= 0.05  # one that began on the leader's axle line
    if name == "feedback_linearisation":
        assert position.max() < POSITION
    if name == "look_ahead":  # the point arrives, the axle stays beside it
        np.testing.assert_allclose(position, 2 * LOOK_AHEAD.distance * np.sin(heading / 2), atol=1e-6)
        assert np.median(heading) > 0.5
    if name in ("kanayama", "jiang_nijmeijer"):  # no excitation: they stop abreast
        assert e_x.max() < POSITION
        assert np.median(e_y) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kanayama", "look_ahead"])
def test_a_leader_in_reverse_is_lost_by_laws_for_forward_motion(name: str) -> None:
    _, _, position, heading = late_errors(RIVALS[name], REVERSE)
    assert not ((position < POSITION) & (heading < HEADING)).any()
