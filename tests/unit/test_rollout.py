"""The loop: who sees what when, what a row holds, and what is left of a run that ends early."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest

import tolerances as tol
from drives import DRIVE
from nhtrack import se2
from nhtrack.arrays import Array
from nhtrack.control import Leader, Robots
from nhtrack.errors import SimulationDiverged
from nhtrack.network import Network
from nhtrack.recording import VARIABLES
from nhtrack.rollout import Rollout, rollout
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State

DT = 0.1
CHAIN = {"leader": (), "a": ("leader",), "b": ("a",)}
# A follower listed before the one it tracks, and two robots on one level: indices and levels differ in order.
TREE = {"leader": (), "c": ("a",), "b": ("leader",), "a": ("leader",), "d": ("c",)}


class Echo:
    """Commands what the leader was commanded in this period, plus one; counts its calls in its memory."""

    def init(self, follower: Robots, leader: Leader) -> Array:
        return np.zeros(follower.g.shape[:-1])

    def __call__(self, follower: Robots, leader: Leader, memory: Array) -> tuple[Array, Array]:
        return leader.u[..., ::2] + 1, memory + 1

    def warnings(self) -> tuple[str, ...]:
        return ()


class Breaking(Echo):
    """Stops making sense after some calls, for its last robot."""

    def __init__(self, after: int) -> None:
        self.after = after

    def __call__(self, follower: Robots, leader: Leader, memory: Array) -> tuple[Array, Array]:
        u = 0 * leader.u[..., ::2]
        u[..., -1, 0] = np.where(memory[..., -1] >= self.after, np.nan, 0.0)
        return u, memory + 1


class Watching(Echo):
    """Keeps what it saw."""

    def __init__(self) -> None:
        self.seen: list[tuple[Robots, Leader]] = []

    def __call__(self, follower: Robots, leader: Leader, memory: Array) -> tuple[Array, Array]:
        self.seen.append((follower, leader))
        return 0.1 * np.ones_like(leader.u[..., ::2]), memory


def start(n: int, batch: tuple[int, ...] = ()) -> State:
    rng = np.random.default_rng(n)
    xi = rng.uniform(-1, 1, (*batch, n, 3)) * [1, 0, 1]
    return State(0.5, rng.uniform(-2, 2, (*batch, n, 3)), xi)


def inputs(periods: int = 6) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (periods, 2))


def run(parents: Mapping[str, tuple[str, ...]], law: Echo | None = None, **arguments: object) -> Rollout:
    network = Network.from_parents(parents)
    simulation, begin = IdealSimulation(network.names, DRIVE, DT), start(len(network))
    return rollout(simulation, law or Echo(), network, inputs(), begin, **arguments)  # type: ignore[arg-type]


def test_every_level_sees_its_parent_s_command_of_the_same_period() -> None:
    u = run(CHAIN).variables["input"][:-1]
    np.testing.assert_array_equal(u[:, 0], inputs())
    np.testing.assert_array_equal(u[:, 1], inputs() + 1)
    np.testing.assert_array_equal(u[:, 2], inputs() + 2)


def test_levels_do_not_depend_on_the_order_of_names() -> None:
    done = run(TREE)
    depths = np.array([0, 2, 1, 1, 3])  # leader, c, b, a, d
    np.testing.assert_array_equal(done.variables["input"][:-1], inputs()[:, None] + depths[:, None] + 0.0)


@pytest.mark.parametrize("parents", [CHAIN, TREE])
def test_each_follower_tracks_its_own_parent(parents: dict[str, tuple[str, ...]]) -> None:
    done, names = run(parents).variables, list(Network.from_parents(parents).names)
    for name, others in parents.items():
        robot = names.index(name)
        if not others:
            assert all(
                np.isnan(done[what][:, robot]).all() for what in ("leader_pose", "leader_twist", "error")
            )
            continue
        parent = names.index(others[0])
        np.testing.assert_array_equal(done["leader_pose"][:, robot], done["pose"][:, parent])
        np.testing.assert_array_equal(done["leader_twist"][:, robot], done["twist"][:, parent])
        error = se2.between(done["pose"][:, parent], done["pose"][:, robot])
        np.testing.assert_array_equal(done["error"][:, robot, :2], error[:, :2])
        np.testing.assert_array_equal(done["error"][:, robot, 2], se2.wrap(error[:, 2]))


def test_the_law_sees_the_state_at_the_start_of_the_period() -> None:
    law = Watching()
    done = run({"leader": (), "a": ("leader",)}, law).variables
    for k, (follower, leader) in enumerate(law.seen[:-1]):
        np.testing.assert_array_equal(follower.g[0], done["pose"][k, 1])
        np.testing.assert_array_equal(follower.xi[0], done["twist"][k, 1])
        np.testing.assert_array_equal(leader.g[0], done["pose"][k, 0])
        np.testing.assert_array_equal(leader.xi[0], done["twist"][k, 0])
        np.testing.assert_array_equal(leader.u[0, ::2], inputs()[k])
        assert leader.u[0, 1] == 0


def test_memory_comes_back_to_the_law_that_made_it() -> None:
    """One memory per level, counted on by one each period."""
    counts: dict[int, list[Array]] = {}

    class Counting(Echo):
        def __call__(self, follower: Robots, leader: Leader, memory: Array) -> tuple[Array, Array]:
            counts.setdefault(len(memory), []).append(memory)
            return leader.u[..., ::2], memory + 1

    run({"leader": (), "a": ("leader",), "b": ("leader",), "c": ("a",)}, Counting())
    for robots in (1, 2):  # c alone; a and b
        np.testing.assert_array_equal(counts[robots], np.arange(7)[:, None] * np.ones(robots))


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
    done = rollout(simulation, Echo(), network, np.zeros((1, 2)), State(0.0, g, np.zeros((2, 3)))).variables
    assert done["error"][0, 1, 2] == pytest.approx(0.25, abs=tol.HAND)
    assert done["pose"][0, 1, 2] == g[1, 2]


def test_batch_is_exactly_its_members() -> None:
    network = Network.from_parents(CHAIN)
    begin = start(3, (4,))
    root = np.random.default_rng(1).uniform(-1, 1, (6, 4, 2))
    batch = rollout(IdealSimulation(network.names, DRIVE, DT), Echo(), network, root, begin)
    for member in range(4):
        single = State(begin.t, begin.g[member], begin.xi[member])
        alone = rollout(IdealSimulation(network.names, DRIVE, DT), Echo(), network, root[:, member], single)
        for name, values in alone.variables.items():
            np.testing.assert_array_equal(batch.variables[name][:, member], values, err_msg=name)


def test_progress_counts_the_periods_done() -> None:
    told: list[tuple[int, int]] = []
    run(CHAIN, progress=lambda done, total: told.append((done, total)))
    assert told == [(k, 6) for k in range(1, 7)]


# -- runs that end early ----------------------------------------------------------------------------


def test_an_interrupted_run_keeps_whole_rows() -> None:
    def stop(done: int, _: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    cut, whole = run(CHAIN, progress=stop), run(CHAIN)
    assert (cut.interrupted, cut.failure) == (True, None)
    assert_beginning(cut, whole, rows=3)


def test_an_interrupt_in_the_middle_of_a_row_leaves_the_row_out() -> None:
    """Ctrl-C can come anywhere: here while telemetry is read, after part of the row is known."""
    network = Network.from_parents(CHAIN)

    class Interrupted(IdealSimulation):
        calls = 0

        def telemetry(self) -> Mapping[str, Array]:
            self.calls += 1
            if self.calls == 5:
                raise KeyboardInterrupt
            return super().telemetry()

    cut = rollout(Interrupted(network.names, DRIVE, DT), Echo(), network, inputs(), start(3))
    assert cut.interrupted
    assert_beginning(cut, run(CHAIN), rows=4)


def test_a_diverging_run_keeps_its_rows_and_says_why() -> None:
    done = run(CHAIN, Breaking(after=4))
    assert isinstance(done.failure, SimulationDiverged)
    assert not done.interrupted
    # Both followers break; `a` is the first robot. The fifth command is the first that is not finite.
    assert (done.failure.robot, done.failure.time) == ("a", 0.5 + 4 * DT)
    np.testing.assert_array_equal(done.time, [0.5 + k * DT for k in range(5)])
    assert np.isfinite(done.variables["pose"]).all()
    assert np.isnan(done.variables["input"][-1, 1, 0])
    assert {len(values) for values in done.variables.values()} == {5}


def test_other_errors_are_not_swallowed() -> None:
    class Wrong(Echo):
        def __call__(self, follower: Robots, leader: Leader, memory: Array) -> tuple[Array, Array]:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run(CHAIN, Wrong())


def assert_beginning(cut: Rollout, whole: Rollout, rows: int) -> None:
    """Fails unless the cut run is the first rows of the whole one, in every variable."""
    np.testing.assert_array_equal(cut.time, whole.time[:rows])
    assert set(cut.variables) == set(whole.variables)
    for name, values in cut.variables.items():
        np.testing.assert_array_equal(values, whole.variables[name][:rows], err_msg=name)
