"""The loop: who sees what when, what a row holds, and what is left of a run that ends early."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest

import tolerances as tol
from drives import DRIVE
from nhtrack import se2
from nhtrack.errors import SimulationDiverged
from nhtrack.experiment import loop
from nhtrack.experiment.loop import Rollout, rollout
from nhtrack.laws import Law
from nhtrack.network import Network
from nhtrack.recording import VARIABLES
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State
from watching import ECHO, watch

DT = 0.1
CHAIN = {"leader": (), "a": ("leader",), "b": ("a",)}
# A follower listed before the one it tracks, and two robots on one level: indices and levels differ in order.
TREE = {"leader": (), "c": ("a",), "b": ("leader",), "a": ("leader",), "d": ("c",)}
both = pytest.mark.parametrize("parents", [CHAIN, TREE])


def start(n: int, batch: tuple[int, ...] = ()) -> State:
    rng = np.random.default_rng(n)
    xi = rng.uniform(-1, 1, (*batch, n, 3)) * [1, 0, 1]
    return State(0.5, rng.uniform(-2, 2, (*batch, n, 3)), xi)


def inputs(periods: int = 6) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (periods, 2))


def run(
    parents: Mapping[str, tuple[str, ...]], law: Law | None = None, periods: int = 6, **arguments: object
) -> Rollout:
    network = Network.from_parents(parents)
    simulation = IdealSimulation(network.names, DRIVE, DT)
    return rollout(simulation, law or ECHO(), network, inputs(periods), start(len(network)), **arguments)  # type: ignore[arg-type]


# -- who sees what ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("parents", "depths"), [(CHAIN, [0, 1, 2]), (TREE, [0, 2, 1, 1, 3])])
def test_every_level_sees_its_parent_s_command_of_the_same_period(
    parents: dict[str, tuple[str, ...]], depths: list[int]
) -> None:
    """Each commands one more than its parent, in whatever order robots are named."""
    expected = inputs()[:, None] + np.array(depths)[:, None]
    np.testing.assert_allclose(run(parents).variables["input"][:-1], expected, rtol=tol.HAND)


@both
def test_each_follower_tracks_its_own_parent(parents: dict[str, tuple[str, ...]]) -> None:
    done, names = run(parents).variables, list(Network.from_parents(parents).names)
    for name, others in parents.items():
        robot = names.index(name)
        if not others:
            assert all(np.isnan(done[what][:, robot]).all() for what in ("leader_pose", "leader_twist", "error"))
            continue
        parent = names.index(others[0])
        np.testing.assert_array_equal(done["leader_pose"][:, robot], done["pose"][:, parent])
        np.testing.assert_array_equal(done["leader_twist"][:, robot], done["twist"][:, parent])
        error = se2.between(done["pose"][:, parent], done["pose"][:, robot])
        np.testing.assert_allclose(done["error"][:, robot, :2], error[:, :2], atol=tol.HAND)
        np.testing.assert_array_equal(done["error"][:, robot, 2], se2.wrap(error[:, 2]))


def test_the_law_sees_the_state_at_the_start_of_the_period_and_gets_its_own_memory_back() -> None:
    network, done = Network.from_parents(CHAIN), run(CHAIN).variables
    seen = watch(network, inputs(), start(3), DT)
    followers = np.array([1, 2])
    for prefix, robots in (("own_", followers), ("", followers - 1)):
        names = ("x", "y", "theta", "v_x", "v_y", "omega")
        found = np.stack([seen[prefix + name][:, followers] for name in names], axis=-1)
        np.testing.assert_array_equal(found[..., :3], done["pose"][:, robots])
        np.testing.assert_array_equal(found[..., 3:], done["twist"][:, robots])
    commanded = np.stack([seen["u_x"], seen["u_theta"]], axis=-1)[:-1, followers]
    np.testing.assert_array_equal(commanded, done["input"][:-1, followers - 1])
    assert (seen["u_y"][:, followers] == 0).all()
    assert (seen["calls"][:, followers] == np.arange(1, 8)[:, None]).all()


# -- rows -------------------------------------------------------------------------------------------


def test_rows_are_period_starts_and_the_end() -> None:
    done = run(CHAIN)
    np.testing.assert_array_equal(done.time, [0.5 + k * DT for k in range(7)])
    assert (done.failure, done.interrupted, done.qpos) == (None, False, None)
    assert list(done.variables) == [name for name in VARIABLES if name in done.variables]
    assert {len(values) for values in done.variables.values()} == {7}
    assert np.isnan(done.variables["input"][-1]).all()
    np.testing.assert_array_equal(done.variables["pose"][0], start(3).g)
    np.testing.assert_array_equal(done.variables["twist"][0], start(3).xi)


def test_input_of_a_row_is_what_moves_the_robots_to_the_next() -> None:
    done = run(CHAIN).variables
    rate = np.diff(done["twist"], axis=0)[..., [0, 2]] / DT
    np.testing.assert_allclose(rate, done["input"][:-1], rtol=tol.HAND, atol=tol.HAND)


def test_heading_error_is_taken_to_half_a_turn() -> None:
    network = Network.from_parents({"leader": (), "a": ("leader",)})
    g = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0 + 0.25 + 6 * math.pi]])
    simulation = IdealSimulation(network.names, DRIVE, DT)
    done = rollout(simulation, ECHO(), network, np.zeros((1, 2)), State(0.0, g, np.zeros((2, 3)))).variables
    assert done["error"][0, 1, 2] == pytest.approx(0.25, abs=tol.HAND)
    assert done["pose"][0, 1, 2] == g[1, 2]


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_batch_is_exactly_its_members_among_however_many_threads(threads: int) -> None:
    network, begin = Network.from_parents(CHAIN), start(3, (4,))
    root = np.random.default_rng(1).uniform(-1, 1, (6, 4, 2))
    recorder = loop.FullRecorder()
    simulation = IdealSimulation(network.names, DRIVE, DT)
    assert loop.run_loop(simulation, ECHO(), network, root, begin, recorder, threads=threads) is None
    for member in range(4):
        single = State(begin.t, begin.g[member], begin.xi[member])
        alone = rollout(IdealSimulation(network.names, DRIVE, DT), ECHO(), network, root[:, member], single)
        for name, values in alone.variables.items():
            np.testing.assert_array_equal(recorder.kept(batch=True)[0][name][:, member], values, err_msg=name)


def test_progress_comes_block_by_block_and_ends_at_the_end() -> None:
    told: list[tuple[int, int]] = []
    run(CHAIN, periods=5000, progress=lambda done, total: told.append((done, total)))
    done = [each for each, _ in told]
    assert done == sorted(set(done))
    assert told[-1] == (5000, 5000)
    assert len(told) > 2


# -- runs that end early ----------------------------------------------------------------------------


def assert_beginning(cut: Rollout, whole: Rollout, rows: int) -> None:
    """Fails unless the cut run is the first rows of the whole one, in every variable."""
    np.testing.assert_array_equal(cut.time, whole.time[:rows])
    assert set(cut.variables) == set(whole.variables)
    for name, values in cut.variables.items():
        np.testing.assert_array_equal(values, whole.variables[name][:rows], err_msg=name)


def test_an_interrupted_run_keeps_whole_rows() -> None:
    """Ctrl-C is heard between blocks of periods."""
    kept = []

    def stop(done: int, _: int) -> None:
        kept.append(done)
        if len(kept) == 2:
            raise KeyboardInterrupt

    cut, whole = run(CHAIN, periods=500, progress=stop), run(CHAIN, periods=500)
    assert (cut.interrupted, cut.failure) == (True, None)
    assert 0 < kept[-1] < 500
    assert_beginning(cut, whole, rows=kept[-1])


def test_a_run_interrupted_before_its_first_row_keeps_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "make_followers", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run(CHAIN, periods=5)


@pytest.mark.parametrize("calls", [0, 4, 20])
def test_a_diverging_run_keeps_its_rows_and_says_why(calls: int) -> None:
    done, whole = run(CHAIN, ECHO(breaks=calls), periods=30), run(CHAIN, periods=30)
    assert isinstance(done.failure, SimulationDiverged)
    assert not done.interrupted
    # Both followers break; `a` is the first robot. The row holds what was commanded and could not be.
    assert (done.failure.robot, done.failure.time) == ("a", pytest.approx(0.5 + calls * DT, rel=tol.HAND))
    assert "not finite" in done.failure.reason
    assert "echo.py" in done.failure.reason
    assert np.isnan(done.variables["input"][-1, 1, 0])
    broken = done.variables.pop("input")
    np.testing.assert_array_equal(broken[:-1], whole.variables.pop("input")[:calls])
    assert_beginning(done, whole, rows=calls + 1)


def test_other_errors_are_not_swallowed() -> None:
    def wrong(done: int, total: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run(CHAIN, progress=wrong)
