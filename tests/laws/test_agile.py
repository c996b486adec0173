"""The law `agile`: its derivatives, its storage function near the leader, its limits, and which leaders it follows."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pandas as pd
import pytest

from chases import reversal_distances
from nhtrack.config.families import FAMILIES
from nhtrack.experiment.load import load_campaign
from nhtrack.laws import Follower, Leader, Limits, agile, law_named
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.laws.leader_motion import first_seen, schedule, seen_after
from nhtrack.simulation.ideal import propagate
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.parts import run_starts

pytestmark = pytest.mark.property

GAINS = agile.Gains()
FREE = Limits()
# Central differences over 1e-4 s of velocities with third derivatives of up to some hundreds.
DIFFERENCE, ROUNDING = 1e-5, 1e-9

Pair = tuple[Follower, Leader]


# -- pairs ------------------------------------------------------------------------------------------


def pairs(count: int, reach: float, seed: int = 0) -> list[Pair]:
    """Random followers and leaders on wheels."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(-1, 1, (count, 12)) * [reach, reach, 3, 2, 2, 0, 0, 3, 2, 2, 2, 2]
    return [
        (Follower(x, y, h, v, 0.0, w), Leader(x_0, y_0, h_0, v_0, 0.0, w_0, u, 0.0, a))
        for x, y, h, v, w, x_0, y_0, h_0, v_0, w_0, u, a in drawn.tolist()
    ]


def later(pair: Pair, dt: float) -> Pair:
    """The same robots after dt, the leader under its acceleration, the follower coasting."""
    follower, leader = pair
    u_0 = np.array([leader.u_x, leader.u_theta])
    g, xi = propagate(
        np.array([follower.x, follower.y, follower.theta]),
        np.array([follower.v_x, 0.0, follower.omega]),
        np.zeros(2),
        dt,
    )
    g_0, xi_0 = propagate(
        np.array([leader.x, leader.y, leader.theta]), np.array([leader.v_x, 0.0, leader.omega]), u_0, dt
    )
    return Follower(*g.tolist(), *xi.tolist()), Leader(*g_0.tolist(), *xi_0.tolist(), leader.u_x, 0.0, leader.u_theta)


def seen_of(leader: Leader) -> tuple[float, ...]:
    """A memory of motion in which the leader's swaying, not the inner loop, bounds b."""
    row = list(first_seen(leader, GAINS.k_theta, GAINS.window, GAINS.smoothing))
    row[4] = 4.0  # held_2
    return tuple(row)


def commanded(mode: int, pair: Pair, seen: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(v_c, omega_c) and their derivatives, read off accelerations, which are affine in k_inner."""
    follower, leader = pair
    memory = agile.Memory(mode, 1, 1, 0, 0.0, seen)
    part = agile._near if mode == agile.NEAR else agile._far
    without, with_gain = (
        np.array(part(GAINS._replace(k_inner=k), FREE, follower, leader, memory)[:2]) for k in (1e3, 1e3 + 1)
    )
    velocities = with_gain - without + np.array([follower.v_x, follower.omega])
    return velocities, without - 1e3 * (with_gain - without)


# -- formulas ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [0, 1], ids=["v", "omega"])
def test_derivatives_near_the_leader_are_those_along_the_motion(part: int) -> None:
    """v_c' and omega_c' with held gains, against central differences of v_c and omega_c."""
    step = 1e-4
    for pair in pairs(200, 1.0):
        seen = seen_of(pair[1])
        ahead, behind = (commanded(agile.NEAR, later(pair, dt), seen)[0][part] for dt in (step, -step))
        expected = (ahead - behind) / (2 * step)
        assert commanded(agile.NEAR, pair, seen)[1][part] == pytest.approx(expected, abs=100 * DIFFERENCE)


def bent(rate: float, largest: float) -> float:
    return rate / math.sqrt(1 + (rate / largest) ** 2)


def test_storage_near_the_leader_does_not_grow() -> None:
    """V = int s/q(s) ds + theta^2/(2 b): with velocities as commanded, V' = -x f(x)/q - theta g(theta)/b."""
    for follower, leader in pairs(200, 1.0, seed=1):
        seen = seen_of(leader)
        (v, omega), _ = commanded(agile.NEAR, (follower, leader), seen)
        held = schedule(agile.Seen(*seen), GAINS.rate, GAINS.k_theta, 1e3, GAINS.zeta, GAINS.least_speed)
        e = agile.view(follower._replace(v_x=v, omega=omega), leader)
        theta = e.theta - 2 * math.pi * round(e.theta / (2 * math.pi))
        if abs(e.theta) > math.pi:
            continue  # `turns` counts from zero here
        q = math.sqrt(1 + (held.b / GAINS.turn_rate) ** 2 * seen[0] * (e.x**2 + e.y**2))
        rate = (e.x * e.x_rate + e.y * e.y_rate) / q + theta * e.theta_rate / held.b
        f = bent(held.k_x * e.x, 0.5 * GAINS.field_speed)
        g = bent(GAINS.k_theta * theta, 2 * GAINS.turn_rate)
        expected = -e.x * f / q - theta * g / held.b
        assert rate == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_motion_that_has_always_been_is_remembered_as_it_is() -> None:
    """A leader on a circle: what is seen of it at once is what has been seen of it after a long time."""
    period, v, omega = 1e-3, 0.7, 1.3
    leader = Leader(0.0, 0.0, 0.4, v, 0.0, omega, 0.0, 0.0, 0.0)
    row = first_seen(leader, GAINS.k_theta, GAINS.window, GAINS.smoothing)
    for k in range(1, 30_001):
        at = leader._replace(theta=0.4 + omega * k * period)
        row = seen_after(row, at, period, GAINS.k_theta, GAINS.window, GAINS.smoothing)
    expected = first_seen(at, GAINS.k_theta, GAINS.window, GAINS.smoothing)
    np.testing.assert_allclose(row, expected, atol=2 * omega * period, rtol=1e-9)


def test_follower_in_step_with_its_leader_is_told_what_its_leader_does() -> None:
    for _, leader in pairs(50, 1.0):
        follower = Follower(*leader[:6])
        memory = agile.init(GAINS, 0.01, follower, leader)
        u_x, u_theta, _ = agile.command(GAINS, 0.01, FREE, follower, leader, memory)
        assert (u_x, u_theta) == pytest.approx((leader.u_x, leader.u_theta), abs=ROUNDING)


def test_gains_that_break_a_bound_are_told() -> None:
    assert agile.warnings(GAINS, FREE) == ()
    assert "k_inner = 6" in agile.warnings(GAINS._replace(k_theta=7.0), FREE)[0]
    assert "2 c = 1.4" in agile.warnings(GAINS._replace(k_turn=1.0), FREE)[0]
    assert "2 dock_radius" in agile.warnings(GAINS._replace(dock_radius=0.5), FREE)[0]
    assert "field_speed" in agile.warnings(GAINS, Limits(1.5, 4.0, 2.0, 10.0))[0]
    assert "c field_speed" in agile.warnings(GAINS, Limits(3.0, 4.0, 0.5, 10.0))[0]


# -- limits -----------------------------------------------------------------------------------------


def test_robot_that_keeps_its_limits_never_leaves_them() -> None:
    """Random pairs under wild leaders for 2 s, in all modes: accelerations and velocities never above the limits."""
    most = np.array([1.0, 2.0, 1.5, 8.0])
    law, dt = law_named("agile")(limits=Limits(*most)), 0.01
    rows = pairs(300, 3.0)
    rows = [
        (follower, leader._replace(v_x=0.0, omega=0.0, u_x=0.0, u_theta=0.0)) for follower, leader in rows[:50]
    ] + rows[50:]
    f, leader = np.array([pair[0] for pair in rows]), np.array([pair[1] for pair in rows])
    g, xi = f[:, :3], np.clip(f[:, 3:], -most[[0, 0, 1]], most[[0, 0, 1]])
    memory = first_memories(law, np.concatenate([g, xi], axis=1), leader, dt)
    reached = np.zeros(4)
    modes: set[float] = set()
    for _ in range(200):
        u, memory = commands(law, np.concatenate([g, xi], axis=1), leader, memory, dt)
        g, xi = propagate(g, xi, u, dt)
        g_0, xi_0 = propagate(leader[:, :3], leader[:, 3:6], leader[:, [6, 8]], dt)
        leader = np.concatenate([g_0, xi_0, leader[:, 6:]], axis=1)
        reached = np.maximum(reached, np.abs(np.concatenate([xi[:, ::2], u], axis=1)).max(axis=0))
        modes |= set(memory[:, 0].tolist())
    assert modes == {agile.CALM, agile.FAR, agile.NEAR}
    assert (reached <= most * (1 + 1e-12)).all()
    assert (reached > 0.95 * most).all()


def test_steering_to_and_fro_keeps_to_what_limits_on_turning_allow() -> None:
    """Behind a leader that reverses every half second with nine tenths of what its followers may, all arrive."""
    law, dt, rng = law_named("agile")(limits=Limits(2.36, 2.94, 3.46, 4.33)), 0.01, np.random.default_rng(1)
    g, xi = rng.uniform(-1, 1, (30, 3)) * [6.0, 6.0, math.pi], np.zeros((30, 3))
    leader = np.zeros((30, 9))
    for step in range(3000):
        leader[:, [6, 8]] = math.pi * math.cos(2 * math.pi * step * dt), 0.1 * math.cos(0.4 * step * dt)
        if step == 0:
            memory = first_memories(law, np.concatenate([g, xi], axis=1), leader, dt)
        u, memory = commands(law, np.concatenate([g, xi], axis=1), leader, memory, dt)
        g, xi = propagate(g, xi, u, dt)
        leader[:, :3], leader[:, 3:6] = propagate(leader[:, :3], leader[:, 3:6], leader[:, [6, 8]], dt)
    assert np.hypot(*(g - leader[:, :3])[:, :2].T).max() < 0.01


# -- leaders that reverse ---------------------------------------------------------------------------


@pytest.mark.parametrize(("period", "factor"), [(4.0, 3.43), (8.0, 0.94)])
def test_universal_drifts_off_a_leader_that_reverses_often_and_agile_does_not(period: float, factor: float) -> None:
    """The distance grows by a factor from reversal to reversal, however small it is: a linear instability."""
    far = reversal_distances(law_named("universal")(), period, 4, 1e-5)
    assert np.median(far[-1] / far[-2]) == pytest.approx(factor, rel=0.02)
    assert np.median(far[-2] / far[-3]) == pytest.approx(factor, rel=0.02)
    near = reversal_distances(law_named("agile")(), period, 4, 1e-5)
    assert (near[-1] < 0.1 * near[0]).all()


# -- in the long run --------------------------------------------------------------------------------

FAST = load_campaign("campaign/fast_leaders", ["starts.count=10"])
SLOW = FAST.model_copy(update={"families": tuple(FAMILIES)})


@cache
def chase(family: str, label: str = "agile") -> pd.DataFrame:
    campaign = SLOW if family in FAMILIES else FAST
    return run_starts(Cell(campaign, label, family), slice(0, 10))


@pytest.mark.slow
@pytest.mark.parametrize("family", [*(name for name in FAST.family_names if name != "bursts"), *FAMILIES])
def test_every_start_converges(family: str) -> None:
    found = chase(family)
    assert found["converged"].all()


@pytest.mark.slow
def test_pushes_out_of_rest_turn_followers_a_little_and_never_lose_them() -> None:
    found = chase("bursts")
    assert (found["late_position"] < 0.005).all()
    assert (found["late_heading"] < 0.06).all()


@pytest.mark.slow
@pytest.mark.parametrize("family", ["reverse-1s", "chirp", "cusps-fast", "circle-6"])
def test_universal_does_not_follow_these(family: str) -> None:
    assert chase(family, "universal")["converged"].mean() <= 0.2
