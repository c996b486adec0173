"""Between robots and their laws: commands that arrive late, noise, and laws that are asked ahead."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp

import tolerances as tol
from drives import DRIVE
from nhtrack.compiled import compiled_loop
from nhtrack.config.law_sections import law_names, law_section
from nhtrack.experiment.build import make_law
from nhtrack.experiment.link import Link, drive_on
from nhtrack.experiment.load import load, load_campaign
from nhtrack.experiment.loop import FullRecorder, rollout, run_loop
from nhtrack.laws import Law, law_in
from nhtrack.network import Network
from nhtrack.similarity import Similarity
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, stepped_scene
from nhtrack.simulation.state import State
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.parts import run_starts
from nhtrack.studies.run.run import simulate
from watching import ECHO, LAWS, watch

DT = 0.1
PAIR = Network.from_parents({"leader": (), "a": ("leader",)})
TREE = Network.from_parents({"leader": (), "c": ("a",), "b": ("leader",), "a": ("leader",), "d": ("c", "b")})
OWN = ("own_x", "own_y", "own_theta", "own_v_x", "own_omega")
GAINS = {"published": {"kp": 4.0, "kd": 6.0, "ke": 1.0, "k": 5.0}, "stabiliser": {"kp": 4.0, "kd": 6.0, "k": 5.0}}


def start(n: int, batch: tuple[int, ...] = ()) -> State:
    rng = np.random.default_rng(n)
    xi = rng.uniform(-1, 1, (*batch, n, 3)) * [1, 0, 1]
    return State(0.0, rng.uniform(-2, 2, (*batch, n, 3)), xi)


def ideal(
    network: Network, law: Law, root: np.ndarray, begin: State, link: Link | None = None
) -> Mapping[str, np.ndarray]:
    return rollout(IdealSimulation(network.names, DRIVE, DT), law, network, root, begin, link=link).variables


def law_of(name: str, delay_periods: int) -> Law:
    section = law_section(name)(name=name, delay_periods=delay_periods, **GAINS.get(name, {}))
    return make_law(section, Similarity())


def inputs(periods: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (periods, 2))


# -- commands that arrive late ----------------------------------------------------------------------


def test_double_integrator_with_delay_by_hand() -> None:
    """x'' = u held for 1/2 s, u = -2 x - v of two periods before; from x = 1 at v = 1/2."""
    law, begin = law_in(LAWS / "spring.py")(), State(0.0, np.zeros((2, 3)), np.zeros((2, 3)))
    begin.g[1, 0], begin.xi[1, 0] = 1.0, 0.5
    simulation = IdealSimulation(PAIR.names, DRIVE, 0.5)
    done = rollout(simulation, law, PAIR, np.zeros((4, 2)), begin, link=Link(delay=2)).variables
    # asked for: -2.5, -3, -2.875, ...; what acts: 0, 0, -2.5, -3
    np.testing.assert_allclose(done["input"][:-1, 1, 0], [0, 0, -2.5, -3], rtol=tol.HAND)
    np.testing.assert_allclose(done["pose"][:, 1, 0], [1, 1.25, 1.5, 1.4375, 0.6875], rtol=tol.HAND)
    np.testing.assert_allclose(done["twist"][:, 1, 0], [0.5, 0.5, 0.5, -0.75, -2.25], rtol=tol.HAND)


@pytest.mark.parametrize("delay", [1, 3])
def test_child_sees_what_its_parent_does_now(delay: int) -> None:
    """Each commands one more than its parent: late by the delay of every robot on the way, the root's own on time."""
    root = inputs(12)
    acts = ideal(TREE, ECHO(), root, start(5), Link(delay))["input"][:-1]
    np.testing.assert_array_equal(acts[:, 0], root)
    late = [np.vstack([np.zeros((k, 2)), root])[: len(root)] for k in (delay, 2 * delay)]
    first, second = np.arange(12)[:, None] >= delay, np.arange(12)[:, None] >= 2 * delay
    np.testing.assert_allclose(acts[:, 3], late[0] + first, rtol=tol.HAND)
    np.testing.assert_allclose(acts[:, 2], late[0] + first, rtol=tol.HAND)
    np.testing.assert_allclose(acts[:, 1], late[1] + first + second, rtol=tol.HAND)


def test_inputs_recorded_are_those_that_move_the_robots() -> None:
    done = ideal(TREE, ECHO(), inputs(9), start(5), Link(2))
    rate = np.diff(done["twist"], axis=0)[..., [0, 2]] / DT
    np.testing.assert_allclose(rate, done["input"][:-1], rtol=tol.HAND, atol=tol.HAND)


@pytest.mark.parametrize("threads", [1, 2])
def test_delay_on_wheels_is_that_of_the_ideal_model(threads: int) -> None:
    """One robot after the other and as a fleet over threads: `ECHO` looks at accelerations only."""
    spec = SceneSpec(TREE.names, timestep=0.01)
    g = np.column_stack([np.arange(5.0), np.zeros((5, 2))])
    begin, root, link = State(0.0, g, np.zeros((5, 3))), 0.1 * inputs(6), Link(2, (0.1, 0.1, 0.0, 0.0))
    wheels = MujocoSimulation(stepped_scene(spec), DT, threads=threads, spec=spec)
    assert wheels.is_fleet == (threads == 2)
    models = (wheels, IdealSimulation(TREE.names, DRIVE, DT))
    found, ideal = (rollout(each, ECHO(more=0.01), TREE, root, begin, link=link) for each in models)
    assert found.failure is None
    np.testing.assert_array_equal(found.variables["input"], ideal.variables["input"])


# -- noise ------------------------------------------------------------------------------------------

LARGE = (0.3, 0.2, 0.5, 0.7)


def noise_of(periods: int, seed: int) -> np.ndarray:
    """Noise that the followers a, b, c of a tree see, shape (periods + 1, 3, 5), as shares of its deviations."""
    link, begin, root = Link(0, LARGE, np.array([seed], dtype=np.uint64)), start(5), np.zeros((periods, 2))
    law = ECHO(more=0.0)
    true = ideal(TREE, law, root, begin)
    seen = watch(TREE, root, begin, DT, link=link, law=law)
    state = np.concatenate([true["pose"], true["twist"][..., [0, 2]]], axis=-1)
    return (np.stack([seen[name] for name in OWN], axis=-1) - state)[:, 1:4] / np.array(LARGE)[[0, 0, 1, 2, 3]]


def test_noise_is_normal_and_independent() -> None:
    """In every component, of every robot, from period to period, from seed to seed: by tests of 1 in 10 000."""
    periods = 20_000
    # ECHO with `more` 0 commands nothing behind a root that commands nothing, so the motion is not disturbed
    drawn = np.stack([noise_of(periods, seed) for seed in (0, 1)])
    columns = np.moveaxis(drawn, 2, 1).reshape(2 * 3, -1, 5)
    for part in columns:
        for column in part.T:
            assert stats.kstest(column, "norm").pvalue > 1e-4
    together = columns.transpose(1, 0, 2).reshape(len(drawn[0]), -1)
    count = len(together)
    np.testing.assert_allclose(together.mean(axis=0), 0, atol=4 / count**0.5)
    np.testing.assert_allclose(together.var(axis=0), 1, atol=4 * (2 / count) ** 0.5)
    limit = 5 / count**0.5  # 30 columns are 435 pairs, and three lags 900 each
    of_squares = [np.corrcoef(each, rowvar=False) - np.eye(together.shape[1]) for each in (together, together**2)]
    assert np.abs(of_squares).max() < limit
    for lag in (1, 2, 3):
        cross = together[:-lag].T @ together[lag:] / count
        assert np.abs(cross).max() < limit


def test_nobody_else_sees_a_robot_s_noise() -> None:
    root, begin, link = inputs(30), start(5), Link(0, LARGE)
    with_noise, without = (watch(TREE, root, begin, DT, link=each) for each in (link, None))
    for name in without:
        same = np.array_equal(with_noise[name][:, 1:], without[name][:, 1:])
        assert same == (name not in OWN), name


def test_without_noise_and_delay_a_link_changes_no_bit() -> None:
    begin, root = start(5), inputs(50)
    links = (None, Link(seeds=np.array([7], dtype=np.uint64)))
    done = [ideal(TREE, law_of("agile", 0), root, begin, link) for link in links]
    for name, values in done[0].items():
        np.testing.assert_array_equal(done[1][name], values, err_msg=name)


@pytest.mark.parametrize("threads", [1, 3])
def test_batch_with_delay_and_noise_is_its_members_among_however_many_threads(threads: int) -> None:
    seeds = np.array([3, 3, 8, 2**64 - 1], dtype=np.uint64)
    begin, root = start(2, (4,)), np.broadcast_to(inputs(40)[:, None], (40, 4, 2))
    recorder, law = FullRecorder(), law_of("universal", 2)
    simulation = IdealSimulation(PAIR.names, DRIVE, DT)
    whole = Link(3, (0.01, 0.02, 0.0, 0.01), seeds)
    assert run_loop(simulation, law, PAIR, root, begin, recorder, threads=threads, link=whole) is None
    for member in range(4):
        single, own = State(0.0, begin.g[member], begin.xi[member]), Link(3, whole.deviations, seeds[member, None])
        for name, values in ideal(PAIR, law, root[:, member], single, own).items():
            np.testing.assert_array_equal(recorder.kept(batch=True)[0][name][:, member], values, err_msg=name)


def test_wheels_and_their_ideal_twin_see_the_same_noise() -> None:
    changes = ["duration=6", "delay=3", "noise={position: 0.002, heading: 0.01}", "law.delay_periods=3"]
    outcome = simulate(load("tour/hello", changes))
    gap = outcome.summary["robots"]["follower"]["gap_position_max"]
    other = simulate(load("tour/hello", [*changes, "seed=1"])).recording
    assert gap < tol.OPEN_LOOP_POSITION
    moved = other["pose"].values - outcome.recording["pose"].values
    apart = np.hypot(*moved[:, 1, :2].T).max()
    assert apart > 100 * gap
    assert not [said for said in outcome.summary["warnings"] if "delay" in said]


# -- laws that are asked ahead ----------------------------------------------------------------------


@pytest.mark.property
@pytest.mark.parametrize(("turning", "inputs_"), [(0.0, (0.0, 0.0)), (-1.3, (0.0, 0.0)), (-1.3, (0.2, -0.1))])
@pytest.mark.parametrize("delay", [1, 4])
@pytest.mark.parametrize("name", law_names())
def test_law_asked_ahead_by_the_delay_is_the_law_without_delay_a_delay_later(
    name: str, delay: int, turning: float, inputs_: tuple[float, float]
) -> None:
    """To the last bit, behind a leader of constant accelerations; the run without begins where all are by then.

    `agile` begins with what it sees of the leader's velocity, which before the first period is that of the start.
    """
    if name == "agile" and any(inputs_):
        return
    root, begin = np.tile(inputs_, (60, 1)), start(2)
    begin.xi[0] = (0.7, 0.0, turning)
    late = ideal(PAIR, law_of(name, delay), root, begin, Link(delay))
    then = State(delay * DT, late["pose"][delay], late["twist"][delay])
    prompt = ideal(PAIR, law_of(name, 0), root[delay:], then)
    for each in ("pose", "twist", "input"):
        np.testing.assert_array_equal(late[each][delay:], prompt[each], err_msg=each)


def test_what_is_tracked_is_moved_to_where_it_will_be() -> None:
    """Behind accelerations that are linear in time, from the second period on: they have to be seen to change."""
    ahead, periods = 3, np.arange(20.0)
    root = np.column_stack([0.2 + 0.1 * periods, -0.3 + 0.05 * periods])
    law = ECHO(more=0.0, delay_periods=ahead)
    begin = start(2)
    seen, done = watch(PAIR, root, begin, DT, law=law), ideal(PAIR, law, root, begin)
    true = np.concatenate([done["leader_pose"], done["leader_twist"]], axis=-1)[1 + ahead:, 1]
    found = np.stack([seen[name][1:-ahead, 1] for name in ("x", "y", "theta", "v_x", "v_y", "omega")], axis=-1)
    np.testing.assert_allclose(found, true, rtol=tol.HAND, atol=tol.HAND)
    np.testing.assert_allclose(done["input"][1:-1 - ahead, 1], root[1 + ahead:], atol=tol.HAND)


@compiled_loop
def driven_on(leader: np.ndarray, dt: float) -> None:
    drive_on(leader, dt)


@pytest.mark.parametrize("turning", [0.3, -4.0])
def test_virtual_leader_drives_on_sideways_too(turning: float) -> None:
    """Against scipy's DOP853 of x' = R(theta) v, v' = u; all of u held."""

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        c, s = np.cos(y[2]), np.sin(y[2])
        return np.array([c * y[3] - s * y[4], s * y[3] + c * y[4], y[5], *y[6:], 0, 0, 0])

    leader = np.array([1.0, -2.0, 0.7, 0.9, -0.4, turning, 0.6, 1.1, -0.8])
    expected = solve_ivp(rate, (0, 0.5), leader, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    driven_on(leader, 0.5)
    np.testing.assert_allclose(leader, expected, rtol=tol.LOGM)


@pytest.mark.parametrize("family", ["reverse-1s", "chirp"])
def test_asking_ahead_makes_up_for_a_delay(family: str) -> None:
    """`agile` with commands 50 ms late: what it is off in the end, by as many periods ahead as the delay has."""
    late = {}
    for ahead in (0, 5):
        laws = f"laws={{agile: {{name: agile, delay_periods: {ahead}}}}}"
        campaign = load_campaign("campaign/fast_leaders", ["starts.count=8", "starts.special=0", "delay=5", laws])
        late[ahead] = run_starts(Cell(campaign, "agile", family), slice(0, 8))["late_position"]
    assert np.median(late[5]) < np.median(late[0]) / 3, late


def test_law_that_raises_is_told_with_what_it_saw(tmp_path: Path) -> None:
    """Noisy and ahead: it raises at what it saw, and would not at where its robot is."""
    (tmp_path / "picky.py").write_text(PICKY)
    law, begin = law_in(tmp_path / "picky.py")(delay_periods=2), State(0.0, np.zeros((2, 3)), np.zeros((2, 3)))
    link = Link(2, (1e-6, 0.0, 0.0, 0.0))
    done = rollout(IdealSimulation(PAIR.names, DRIVE, DT), law, PAIR, np.zeros((9, 2)), begin, link=link)
    assert done.failure is not None
    assert "picky" in done.failure.reason
    assert "raised ValueError: far ahead" in done.failure.reason
    assert np.abs(done.variables["pose"][:, 1, 0]).max() < 0.1


PICKY = """
from typing import NamedTuple
class Gains(NamedTuple):
    pass
def command(gains, period, limits, follower, leader, memory):
    if follower.x > 0.1:
        raise ValueError("far ahead")
    return 4.0, 0.0, memory
"""
