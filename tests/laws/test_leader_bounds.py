"""What laws say of a leader before a run: each bound by a leader that is beyond it and by one that is not."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nhtrack.laws import LeaderMotion, Limits, agile, law_named
from nhtrack.laws.contract import dimension
from nhtrack.laws.leader_bounds import close_to_limits, errors_left, over_limits

PERIOD = 0.01
MOST = agile.Gains().field_speed / agile.Gains().smoothing
Rate = Callable[[np.ndarray], np.ndarray]


def motion(v: Rate | float, omega: Rate | float = 0.0, duration: float = 80.0) -> LeaderMotion:
    """A leader from the origin, its speed [m/s] and yaw rate [rad/s] over time."""
    t = np.arange(round(duration / PERIOD) + 1) * PERIOD
    speed, rate = (np.broadcast_to(each(t) if callable(each) else each, t.shape).astype(float) for each in (v, omega))
    theta = np.concatenate([[0.0], np.cumsum(PERIOD * (rate[1:] + rate[:-1]) / 2)])
    along = np.concatenate([[0.0], np.cumsum(PERIOD * (speed * np.exp(1j * theta))[:-1])])
    still = np.zeros(len(t) - 1)
    return LeaderMotion(
        along.real[:-1], along.imag[:-1], theta[:-1], speed[:-1], still, rate[:-1],
        np.diff(speed) / PERIOD, still, np.diff(rate) / PERIOD,
    )  # fmt: skip


def swinging(period: float) -> Rate:
    return lambda t: 0.5 * np.sin(2 * pi * t / period)


def until(end: float, rate: float) -> Rate:
    return lambda t: np.where(t < end, rate, 0.0)


def driving_off(t: np.ndarray) -> np.ndarray:
    return np.minimum(0.5 * t, 1.0)


def pulses(peak: float, rise: float, apart: float) -> Rate:
    """Speeds that rise to a peak and fall again, each in so many seconds, time and again."""
    return lambda t: peak * np.maximum(0.0, 1 - np.abs((t % apart) / rise - 1))


def slowing(t: np.ndarray) -> np.ndarray:
    return 1 / (1 + t)


BEYOND = {
    "universal reverses": ("universal", motion(swinging(6)), "v_0 changes its sign every 3 s from 3.04 s on, sooner"),
    "universal chirp": ("universal", motion(lambda t: np.sin(0.02 * t * t)), "v_0 changes its sign"),
    "universal spin": ("universal", motion(0.0, 3.0), "3 rad/s at most, is from 0 s to 80 s above 2 rad/s = k1/k2"),
    "agile for ever": ("agile", motion(lambda t: 1.1 * MOST * t), "= field_speed/smoothing"),
    "agile starts": ("agile", motion(pulses(1.0, 0.8, 12.0)), "m/s within 0.6 s, 6 times, at 12.1"),
    "agile bursts": ("agile", motion(pulses(1.0, 0.2, 6.0)), "m/s within 0.2 s, 13 times, at 6.0"),
    "samson rest": ("samson", motion(0.0), "multiply small errors by 1, "),
    "samson slow decay": ("samson", motion(slowing, slowing), "multiply small errors by 0.02"),
    "kanayama spin": ("kanayama", motion(0.0, 1.0), "multiply small errors by 1, "),
    "kanayama reverse": ("kanayama", motion(-0.2), "multiply small errors by"),
    "jiang_nijmeijer rest": ("jiang_nijmeijer", motion(0.0), "multiply small errors by 1, "),
    "look_ahead to and fro": ("look_ahead", motion(swinging(20)), "multiply small errors by 1, "),
    "feedback_linearisation stops": ("feedback_linearisation", motion(until(30, 1.0)), "at 30 s is not above 0.1"),
    "feedback_linearisation rest": ("feedback_linearisation", motion(0.0), "at 0 s is not above 0.1 m/s = v_min"),
    "panteley line": ("panteley", motion(driving_off), "multiply small errors by 1, "),
    "vfo reverses": ("vfo", motion(swinging(10)), "v_0 changes its sign every 5 s from 5."),
    "polar_backstepping line": ("polar_backstepping", motion(driving_off), "the leader moves at 0.01 s"),
    "guiding_field rest": ("guiding_field", motion(0.0), "multiply small errors by 1, "),
    "guiding_field reverses": ("guiding_field", motion(swinging(3)), "v_0 changes its sign every 1.5 s"),
    "any, half turns": ("samson", motion(0.0, 320.0), "omega_0 = 320 rad/s at 0 s is half a turn or more"),
}  # fmt: skip
WITHIN = {
    "universal reverses": ("universal", motion(swinging(12))),
    "universal noise at rest": ("universal", motion(lambda t: 0.01 * np.sin(20 * t))),
    "universal spin": ("universal", motion(0.0, 2.0)),
    "universal short spin": ("universal", motion(0.0, until(1.5, 6.0))),
    "agile for ever": ("agile", motion(lambda t: 0.98 * MOST * t)),
    "agile fast circle": ("agile", motion(6.0, 12.0)),
    "agile gentle starts": ("agile", motion(pulses(1.0, 2.0, 20.0))),
    "agile bursts often": ("agile", motion(pulses(1.0, 0.2, 5.0))),
    "agile one start": ("agile", motion(pulses(1.0, 0.5, 100.0))),
    "agile rest": ("agile", motion(0.0)),
    "agile short run": ("agile", motion(lambda t: 9 * t, duration=2.0)),
    "samson spin": ("samson", motion(0.0, 1.0)),
    "kanayama line": ("kanayama", motion(driving_off)),
    "jiang_nijmeijer spin": ("jiang_nijmeijer", motion(0.0, 1.0)),
    "look_ahead line": ("look_ahead", motion(driving_off)),
    "feedback_linearisation line": ("feedback_linearisation", motion(driving_off)),
    "panteley circle": ("panteley", motion(0.5, 0.5)),
    "vfo reverses": ("vfo", motion(swinging(12))),
    "polar_backstepping rest": ("polar_backstepping", motion(0.0)),
    "guiding_field reverses": ("guiding_field", motion(swinging(4))),
    "guiding_field circle": ("guiding_field", motion(0.5, 0.5)),
    "any, less than half turns": ("samson", motion(0.0, 310.0)),
}  # fmt: skip


@pytest.mark.parametrize(("law", "leader", "told"), BEYOND.values(), ids=BEYOND)
def test_a_leader_beyond_a_bound_is_told_of(law: str, leader: LeaderMotion, told: str) -> None:
    found = law_named(law)().beyond(PERIOD, leader)
    assert [sentence for sentence in found if told in sentence], found


@pytest.mark.parametrize(("law", "leader"), WITHIN.values(), ids=WITHIN)
def test_of_a_leader_within_all_bounds_nothing_is_said(law: str, leader: LeaderMotion) -> None:
    assert law_named(law)().beyond(PERIOD, leader) == ()


@pytest.mark.parametrize(("period", "told"), [(0.18, False), (0.19, True)])
def test_agile_says_where_control_periods_are_too_long(period: float, told: bool) -> None:
    """(k_inner + k_theta) period = 2 is the bound."""
    found = law_named("agile")().beyond(period, motion(0.0))
    assert told == any("headings do not settle" in sentence for sentence in found)


def test_the_stabiliser_is_for_a_leader_at_rest() -> None:
    law = law_named("stabiliser")(kp=4.0, kd=6.0, k=3.0)
    assert law.beyond(PERIOD, motion(0.0)) == ()
    assert law.beyond(PERIOD, motion(0.0, lambda t: 1.0 * (t > 3))) == (
        "the leader moves at 3.01 s: the law is for one at rest",
    )


def test_published_ends_on_a_cycle_about_a_leader_that_drives_at_the_end() -> None:
    law = law_named("published")(kp=4.0, kd=6.0, ke=2.0, k=7.0)
    (said,) = law.beyond(PERIOD, motion(driving_off))
    assert said.startswith("|v_0| is still 1 m/s late in the run: followers end on a cycle about it, some ")
    assert "= 0.25 m wide" in said
    assert law.beyond(PERIOD, motion(0.0, 1.0)) == law.beyond(PERIOD, motion(until(60.0, 1.0))) == ()


@pytest.mark.parametrize(("law", "leader", "told"), BEYOND.values(), ids=BEYOND)
def test_bounds_are_the_same_in_other_units(law: str, leader: LeaderMotion, told: str) -> None:
    kind, length, time = law_named(law), 0.1, 3.0
    powers = {name: dimension(gain.unit) for name, gain in kind.described.items()}
    gains = {
        name: type(gain)(gain * length ** powers[name][0] * time ** powers[name][1])
        for name, gain in kind().gains._asdict().items()
    }  # fmt: skip
    scaled = LeaderMotion(
        length * leader.x, length * leader.y, leader.theta,
        length / time * leader.v_x, leader.v_y, leader.omega / time,
        length / time**2 * leader.u_x, leader.u_y, leader.u_theta / time**2,
    )  # fmt: skip
    assert len(kind(**gains).beyond(PERIOD * time, scaled)) == len(kind().beyond(PERIOD, leader))


def test_what_is_over_a_limit_is_told() -> None:
    """Each number that is over its limit is told with its time, and by how much the motion would have to be slower."""
    leader = motion(lambda t: 1.0 + np.sin(t), lambda t: 2 * np.cos(t), 20.0)
    limits = Limits(1.5, 1.0, 0.5, 1.6)
    found = over_limits(limits, PERIOD, leader)
    assert [each.says.partition(" is above")[0] for each in found] == [
        "|v_0| = 2 m/s at 1.57 s", "|omega_0| = 2 rad/s at 0 s", "|u_x0| = 1 m/s^2 at 9.42 s",
        "|u_theta0| = 2 rad/s^2 at 11 s",
    ]  # fmt: skip
    np.testing.assert_allclose([each.slower for each in found], [4 / 3, 2, 2**0.5, 1.25**0.5], rtol=1e-4)
    assert over_limits(Limits(2.1, 2.1, 1.1, 2.1), PERIOD, leader) == over_limits(Limits(), PERIOD, leader) == ()


@pytest.mark.property
@pytest.mark.parametrize("duration", [0.5, 7.0])
def test_what_is_left_of_errors_is_that_of_the_linear_equations(duration: float) -> None:
    """The same equations in the leader's frame, in which e_x' = omega e_y - a e_x, by scipy."""
    leader = motion(lambda t: 0.3 + np.sin(t), lambda t: 2 * np.cos(1.3 * t), duration)
    a, f, d, across, aside = 1.2, 0.8, 1.5, 0.4, 0.3

    def errors(t: float, e: np.ndarray) -> np.ndarray:
        v, omega = 0.3 + np.sin(t), 2 * np.cos(1.3 * t)
        x, y, theta = e.reshape(3, 3)
        return np.concatenate([omega * y - a * x, (aside - omega) * x - across * y + v * theta, -d * theta - f * y])

    whole = solve_ivp(errors, (0, duration), np.eye(3).ravel(), rtol=1e-9, atol=1e-12).y[:, -1].reshape(3, 3)
    expected = max(np.linalg.norm(whole[:2, :2], 2), abs(whole[2, 2]))
    every = np.ones_like(leader.v_x)
    # Velocities at the beginning of each period instead of its middle: a relative error of about one period.
    left = errors_left(PERIOD, leader, a * every, f * every, d * every, across * every, aside * every)
    assert left == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("usual", "peak", "told"), [(1.9, 1.9, 0), (1.92, 1.92, 1), (2.0, 2.0, 1), (2.0, 2.1, 0), (0.5, 2.0, 0)]
)
def test_a_leader_that_is_mostly_close_to_a_rate_limit_is_told(usual: float, peak: float, told: int) -> None:
    omega = np.full(101, usual)
    omega[7] = peak
    still = np.zeros_like(omega)
    leader = LeaderMotion(*[still] * 5, omega, *[still] * 3)
    found = close_to_limits(Limits(yaw_rate=2.0), leader, 1.05)
    assert len(found) == told
    if told:
        assert f"followers have {2.0 - usual:.2g} rad/s to catch up with" in found[0].says
        assert found[0].slower == pytest.approx(usual / 2)
