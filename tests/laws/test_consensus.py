"""Networks of robots under the paper's law: consensus and formation, their symmetries, any acyclic graph."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import independent
import tolerances as tol
from array_laws import Published
from nhtrack import se2
from nhtrack.assets import find_scenario
from nhtrack.experiment.followers import Tracking
from nhtrack.experiment.load import load
from nhtrack.experiment.loop import Rollout, rollout
from nhtrack.network import Network
from nhtrack.similarity import Similarity
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State
from watching import watch

pytestmark = pytest.mark.property

PI = math.pi
DT = 0.02
LAW = Published(4.0, 6.0, 2.0, 7.0, dead_zone_length=1e-9, dead_zone_speed=1e-9)
DIAMOND = {"leader": (), "left": ("leader",), "right": ("leader",), "rear": ("left", "right")}
PLACES = np.array([[0.0, 0.0], [-1.5, 1.5], [-1.5, -1.5], [-1.5, 0.0]])
WAYS = [("convex", "printed"), ("exact", "exact"), ("exact", "printed"), ("convex", "exact")]
every_way = pytest.mark.parametrize(("combination", "transform"), WAYS)
ORDER = [2, 0, 1]  # (v_x, v_y, omega) to the paper's (omega, v_x, v_y)


# -- networks and runs ------------------------------------------------------------------------------


def start(network: Network, shape: tuple[int, ...] = (), seed: int = 0, reach: float = 6.0) -> State:
    """Robots anywhere in a square, headings within 1.2 rad, moving; the first at the origin."""
    rng = np.random.default_rng(seed)
    n = len(network)
    g = rng.uniform([-reach, -reach, -1.2], [reach, reach, 1.2], (*shape, n, 3))
    xi = rng.uniform(-0.5, 0.5, (*shape, n, 3)) * [1, 0, 1]
    g[..., 0, :], xi[..., 0, :] = 0.0, [1.0, 0.0, 0.2]
    return State(0.0, g, xi)


def near_places() -> tuple[Network, State]:
    """The diamond under way, every robot within half a metre of its place: no place turns back within a second."""
    network = Network.from_parents(DIAMOND)
    begin, rng = start(network), np.random.default_rng(0)
    begin.g[:] = rng.uniform(-0.3, 0.3, (4, 3)) + np.array([[0, 0, 0], [-1.5, 1.5, 0], [-1.5, -1.5, 0], [-3, 0, 0]])
    begin.xi[:] = [1.0, 0.0, 0.2]
    begin.xi[:, 0] += rng.uniform(-0.1, 0.1, 4)
    return network, begin


def weave(periods: int, shape: tuple[int, ...] = (), dt: float = DT) -> np.ndarray:
    """A leader's accelerations, (periods, *shape, 2)."""
    t = (dt * np.arange(periods)).reshape(-1, *[1] * len(shape))
    u = np.stack([0.4 * np.cos(0.7 * t), 0.3 * np.sin(1.1 * t + 0.3)], axis=-1)
    return np.broadcast_to(u, (periods, *shape, 2))


def run(
    network: Network, begin: State, inputs: np.ndarray, tracking: Tracking | None = None, law: Published = LAW,
    dt: float = DT,
) -> Rollout:  # fmt: skip
    # Behind `exact` virtual leaders robots go a thousand kilometres off and come back, as the theorems say.
    simulation = IdealSimulation(network.names, None, dt, keep_going=True, size=1e6)
    done = rollout(simulation, law.bound(), network, inputs, begin, tracking)
    assert done.failure is None
    assert np.isfinite(done.variables["pose"]).all()
    return done


def layered(sizes: Sequence[int], seed: int = 0) -> dict[str, tuple[str, ...]]:
    """An acyclic graph of levels of given sizes; each robot has one to eight parents, one of them a level above."""
    rng = np.random.default_rng(seed)
    parents: dict[str, tuple[str, ...]] = {"l0r0": ()}
    above, earlier = ["l0r0"], ["l0r0"]
    for level, size in enumerate(sizes[1:], start=1):
        names = [f"l{level}r{i}" for i in range(size)]
        for name in names:
            first = str(rng.choice(above))
            others = [other for other in earlier if other != first]
            more = rng.choice(others, min(len(others), int(rng.integers(0, 8))), replace=False) if others else []
            parents[name] = (first, *(str(other) for other in more))
        above, earlier = names, [*earlier, *names]
    return parents


# -- the paper, written a second time ---------------------------------------------------------------


@every_way
@pytest.mark.parametrize(("count", "place"), [(1, (0.0, 0.0)), (3, (-1.5, 1.0))], ids=["alone", "formation"])
def test_commands_are_the_paper_s(combination: str, transform: str, count: int, place: tuple[float, float]) -> None:
    """Theorems 2 and 3 in homogeneous matrices with scipy's expm and logm, whole network, two periods.

    The exact twist comes from matrices that carry Taylor coefficients of the motion, not from Jacobians.
    """
    names = [f"p{i}" for i in range(count)]
    weights = tuple(np.random.default_rng(1).uniform(0, 1, count - 1))
    parents = {"leader": (), **{name: ("leader",) for name in names}, "last": tuple(names)}
    network = Network.from_parents(parents, {"last": weights})
    offsets = np.zeros((len(network), 2))
    offsets[-1] = place
    tracking = Tracking(offsets, combination, transform)  # type: ignore[arg-type]
    law = replace(LAW, variant="full", dead_zone_length=0.0, dead_zone_speed=0.0)
    done = run(network, start(network, seed=1), weave(2), tracking, law).variables

    paper = independent.PaperLaw(law.kp, law.kd, law.ke, law.k, bracket=True)
    rates = []
    for k in range(2):
        g, xi, u = done["pose"][k], done["twist"][k], np.insert(done["input"][k], 1, 0.0, axis=-1)
        seen = [
            (independent.pose_matrix(np.array([*g[i], 0, 0])), xi[i][ORDER], u[i][ORDER]) for i in range(1, count + 1)
        ]
        leader = independent.folded(seen, list(weights), combination == "exact")
        if any(place):
            rates.append(independent.turning(leader[1], leader[2], np.array(place))[1])
            second = (rates[-1] - rates[max(len(rates) - 2, 0)]) / DT
            leader = independent.placed(leader, np.array(place), transform == "exact", second)
        follower = np.array([*g[-1], xi[-1, 0], xi[-1, 2]])
        relative = np.linalg.inv(leader[0]) @ independent.pose_matrix(follower)
        expected = paper.track(follower, leader, math.atan2(relative[1, 0], relative[0, 0]))
        np.testing.assert_allclose(done["leader_twist"][k, -1][ORDER], leader[1], atol=tol.JET * scale(leader))
        np.testing.assert_allclose(done["input"][k, -1], expected, rtol=tol.JET, atol=tol.JET * scale(leader))


def scale(leader: independent.Motion) -> float:
    """Where the place nearly stands still thetabar turns fast, and rounding with it."""
    return 100.0 * (1.0 + np.abs(leader[1]).max() + np.abs(leader[2]).max()) ** 2 / min(1.0, abs(leader[1][1])) ** 2


# -- consensus, tracking and formation as cases of each other ---------------------------------------


@every_way
@pytest.mark.parametrize("count", [2, 3, 8])
def test_consensus_with_identical_parents_is_tracking_one(combination: str, transform: str, count: int) -> None:
    """Parents that are and stay in one state: the follower runs as it does with one of them, to the last bit.

    Shares of 1/2 so that (1 - lambda) xi + lambda xi is xi in doubles.
    """
    twins = [f"twin{i}" for i in range(count)]
    crowd = {"leader": (), **{twin: ("leader",) for twin in twins}, "last": tuple(twins)}
    network = Network.from_parents(crowd, {"last": (0.5,) * (count - 1)})
    lone = Network.from_parents({"leader": (), "twin0": ("leader",), "last": ("twin0",)})
    begin = start(lone, seed=4)
    copies = [0, *[1] * count, 2]
    inputs = weave(200)
    together = run(
        network, State(0.0, begin.g[copies], begin.xi[copies]), inputs, Tracking(None, combination, transform)  # type: ignore[arg-type]
    )
    alone = run(lone, begin, inputs, Tracking(None, combination, transform))  # type: ignore[arg-type]
    for name in ("pose", "twist", "leader_twist"):
        np.testing.assert_array_equal(together.variables[name][:, -1], alone.variables[name][:, -1])


@every_way
def test_formation_of_no_offset_is_consensus(combination: str, transform: str) -> None:
    network = Network.from_parents(DIAMOND)
    begin, inputs = start(network), weave(300)
    formation = run(network, begin, inputs, Tracking(np.zeros((4, 2)), combination, transform))  # type: ignore[arg-type]
    consensus = run(network, begin, inputs, Tracking(None, combination))  # type: ignore[arg-type]
    np.testing.assert_array_equal(formation.variables["pose"], consensus.variables["pose"])


# -- symmetries of whole runs -----------------------------------------------------------------------


@every_way
@pytest.mark.parametrize("sizes", [(1, 2, 3), (1, 4, 6, 5)])
def test_order_of_robots_in_the_file_does_not_matter(combination: str, transform: str, sizes: Sequence[int]) -> None:
    """The followers listed in another order: the same graph, and the same run robot by robot, to the last bit."""
    parents: Mapping[str, tuple[str, ...]] = layered(sizes)
    network = Network.from_parents(parents)
    rng = np.random.default_rng(8)
    order = np.array([0, *(1 + rng.permutation(len(network) - 1))])
    shuffled = Network.from_parents({network.names[i]: parents[network.names[i]] for i in order})
    assert shuffled.names != network.names
    assert [{network.names[i] for i in level} for level in network.levels] == [
        {shuffled.names[i] for i in level} for level in shuffled.levels
    ]
    begin, offsets, inputs = start(network), rng.uniform(-2, 2, (len(network), 2)), weave(100)
    plain = run(network, begin, inputs, Tracking(offsets, combination, transform))  # type: ignore[arg-type]
    other = run(
        shuffled, State(0.0, begin.g[order], begin.xi[order]), inputs, Tracking(offsets[order], combination, transform)  # type: ignore[arg-type]
    )
    for name in ("pose", "twist", "leader_pose", "input"):
        np.testing.assert_array_equal(other.variables[name], plain.variables[name][:, order])


def sides(done: Rollout) -> np.ndarray:
    """Signs of q_x of every follower, (t, n - 1): beta switches where they change."""
    error = done.variables["error"][:, 1:]
    return np.sign(se2.log(error)[..., 0])


@every_way
def test_run_is_left_equivariant(combination: str, transform: str) -> None:
    """All robots moved by one h: so is the run, before beta first switches, where rounding would decide."""
    (network, begin), inputs, h = near_places(), weave(50), np.array([3.0, -7.0, 2.5])
    tracking = Tracking(PLACES, combination, transform)  # type: ignore[arg-type]
    plain = run(network, begin, inputs, tracking)
    moved = run(network, begin._replace(g=se2.compose(h, begin.g)), inputs, tracking)
    until = before_switch(plain)
    found = np.asarray(se2.compose(se2.inverse(h), moved.variables["pose"]))[:until]
    np.testing.assert_allclose(found, plain.variables["pose"][:until], atol=tol.SAME_LOOP)
    np.testing.assert_allclose(moved.variables["twist"][:until], plain.variables["twist"][:until], atol=tol.SAME_LOOP)


def before_switch(done: Rollout) -> int:
    """Rows before some follower's q_x changes sign; at least a few periods."""
    signs = sides(done)
    switched = np.flatnonzero((signs != signs[0]).any(axis=-1))
    until = int(switched[0]) if switched.size else len(signs)
    assert until >= 5
    return until


@every_way
@pytest.mark.parametrize(("length", "time"), [(0.04, 4.0), (3.0, 0.7)])
def test_run_scales(combination: str, transform: str, length: float, time: float) -> None:
    """Lengths, times, gains, places and dead zones scaled: the same run in its own units."""
    (network, begin), similarity, inputs = near_places(), Similarity(length, time), weave(50)
    plain = run(network, begin, inputs, Tracking(PLACES, combination, transform))  # type: ignore[arg-type]
    gains = {"kp": LAW.kp / time**2, "kd": LAW.kd / time, "ke": LAW.ke / time**2}
    law = replace(LAW, **gains, dead_zone_length=1e-9 * length, dead_zone_speed=1e-9 * length / time)
    scaled = run(
        network,
        State(0.0, similarity.poses_to_robot(begin.g), similarity.twists_to_robot(begin.xi)),
        similarity.inputs_to_robot(inputs),
        Tracking(PLACES * length, combination, transform),  # type: ignore[arg-type]
        law,
        DT * time,
    )
    until = before_switch(plain)
    poses, twists = (scaled.variables[name][:until] for name in ("pose", "twist"))
    np.testing.assert_allclose(
        similarity.poses_to_scenario(poses), plain.variables["pose"][:until], atol=tol.SAME_LOOP
    )
    np.testing.assert_allclose(
        similarity.twists_to_scenario(twists), plain.variables["twist"][:until], atol=tol.SAME_LOOP
    )


# -- large graphs -----------------------------------------------------------------------------------


@pytest.mark.parametrize("combination", ["convex", "exact"])
@pytest.mark.parametrize("reach", [0.0, 1.0], ids=["consensus", "formation"])
def test_64_robots_in_6_levels_run(combination: str, reach: float) -> None:
    """After 4 s of transients in every level the median error is well down."""
    network = Network.from_parents(layered((1, 5, 10, 14, 16, 18)))
    assert (len(network), len(network.levels)) == (64, 6)
    tracking = Tracking(np.random.default_rng(9).uniform(-reach, reach, (64, 2)), combination)  # type: ignore[arg-type]
    done = run(network, start(network, reach=5.0), weave(200), tracking)
    size = np.linalg.norm(done.variables["error"][:, 1:, :2], axis=-1)
    assert np.median(size[-1]) < 0.4 * np.median(size[0])


@pytest.mark.parametrize("sizes", [(1, 5, 20, 40, 60, 60, 70), (1, 255), (1, *[1] * 255)])
def test_256_robots_of_any_depth_run(sizes: Sequence[int]) -> None:
    """Each follower sees what its parents were commanded in this period, through as many levels as there are."""
    network = Network.from_parents(layered(sizes))
    seen = watch(network, weave(1), start(network), DT)
    assert (seen["calls"][:, 1:] == [[1], [2]]).all()
    commanded = np.full(256, 0.4)  # of the root; the law commands one more than it sees
    for robot in np.concatenate(network.levels[1:]):
        expected = np.mean([commanded[parent] for parent in network.parents[robot]])
        assert seen["u_x"][0, robot] == pytest.approx(expected, rel=tol.HAND)
        commanded[robot] = expected + 1


# -- what the theorems promise ----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(("combination", "transform"), WAYS[:2])
@pytest.mark.parametrize("offsets", [None, PLACES], ids=["consensus", "formation"])
def test_leader_at_rest_above_the_bound_every_robot_arrives(
    combination: str, transform: str, offsets: np.ndarray | None
) -> None:
    """Theorems 2 and 3, Lemma 8: with k_eff = 6 all robots of the diamond reach the leader or their places.

    The dead zone on speeds is the scenarios' default. Without one, as robots 1 and 2 come to rest, thetabar of the rear
    robot is a quotient of two vanishing velocities, and `exact` feeds its rates forward without bound (docs/theory.md).
    """
    law = Published(4.0, 4.2, 1.0, 7.5, dead_zone_length=1e-9, dead_zone_speed=1e-9)
    network, shape = Network.from_parents(DIAMOND), (30,)
    begin = start(network, shape, seed=11, reach=10.0)
    begin.xi[:] = 0.0
    begin.g[:, 1:, 2] *= PI / 1.2
    tracking = Tracking(offsets, combination, transform, 1e-3)  # type: ignore[arg-type]
    done = run(network, begin, np.zeros((1500, *shape, 2)), tracking, law)
    assert np.abs(done.variables["error"][-1, :, 1:]).max() < tol.CONVERGED
    places = np.zeros((4, 2)) if offsets is None else np.array([[0, 0], [-1.5, 1.5], [-1.5, -1.5], [-3, 0]], float)
    expected = np.broadcast_to(places, (*shape, 4, 2))
    np.testing.assert_allclose(done.variables["pose"][-1, ..., :2], expected, atol=3 * tol.CONVERGED)


@pytest.mark.slow
def test_moving_leader_no_diamond_reaches_consensus() -> None:
    """Theorem 2 as printed, leader on a line: what is left of Theorem 1's cycle is handed down, and stays."""
    network, shape, periods = Network.from_parents(DIAMOND), (30,), 2000
    begin = start(network, shape, seed=12, reach=10.0)
    begin.xi[:, 0] = [1.0, 0.0, 0.0]
    late = run(network, begin, np.zeros((periods, *shape, 2))).variables["error"][-periods // 5 :, :, 1:]
    assert np.hypot(late[..., 0], late[..., 1]).max(axis=0).min() > tol.CONVERGED
    assert np.abs(late[..., 2]).max(axis=0).min() > 0.1


@pytest.mark.parametrize(("name", "contact"), [("example4", False), ("example5", True)])
def test_robots_touch_in_formations_and_not_in_consensus(name: str, contact: bool) -> None:
    """Slip 8: consensus puts all robots in one place, so contact between them is off, and the file says so."""
    path = find_scenario(f"paper/{name}")
    assert load(path).physics.robot_contact is contact
    assert "touch" in path.read_text(encoding="utf-8")


@cache
def ends_of(weight: float) -> np.ndarray:
    network = Network.from_parents(DIAMOND, {"rear": (weight,)})
    return run(network, start(network, seed=2), weave(50)).variables["leader_pose"][:, 3]


def test_weights_0_and_1_choose_a_parent() -> None:
    """lambda = 0 tracks the first parent and lambda = 1 the second."""
    network = Network.from_parents(DIAMOND)
    poses = run(network, start(network, seed=2), weave(50)).variables["pose"]
    np.testing.assert_array_equal(ends_of(0.0), poses[:, 1])
    np.testing.assert_allclose(ends_of(1.0), poses[:, 2], atol=tol.SAME_LOOP)
