"""The communication graph: order, levels, and everything that is not a graph to track on."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nhtrack.network import Network, NetworkError, network_faults

DIAMOND = {"leader": [], "one": ["leader"], "two": ["leader"], "three": ["one", "two"], "four": ["leader", "three"]}


@st.composite
def networks(draw: st.DrawFn) -> dict[str, list[str]]:
    """Rooted acyclic graphs of up to eight robots in any order of the file."""
    count = draw(st.integers(1, 8))
    names = [f"r{i}" for i in range(count)]
    parents = {
        name: draw(st.lists(st.sampled_from(names[:i]), min_size=1, unique=True)) if i else []
        for i, name in enumerate(names)
    }
    return {name: parents[name] for name in draw(st.permutations(names))}


def test_a_diamond_by_hand() -> None:
    network = Network.from_parents(DIAMOND)
    assert network.names == ("leader", "one", "two", "three", "four")
    assert network.parents == ((), (0,), (0,), (1, 2), (0, 3))
    assert [level.tolist() for level in network.levels] == [[0], [1, 2], [3], [4]]
    assert len(network) == 5


def test_the_root_comes_first_wherever_it_stands() -> None:
    network = Network.from_parents({"b": ["a"], "a": ["root"], "root": []})
    assert network.names == ("root", "b", "a")
    assert network.parents == ((), (2,), (0,))


@pytest.mark.slow
@settings(max_examples=50)
@given(networks())
def test_levels_are_longest_ways_from_the_root(parents: dict[str, list[str]]) -> None:
    network = Network.from_parents(parents)
    graph = nx.DiGraph([(p, name) for name, others in parents.items() for p in others])
    graph.add_nodes_from(parents)
    level_of = {network.names[i]: n for n, level in enumerate(network.levels) for i in level}
    assert sorted(level_of) == sorted(parents)
    for name in parents:
        ways = nx.all_simple_paths(graph, network.names[0], name) if name != network.names[0] else []
        assert level_of[name] == max((len(way) - 1 for way in ways), default=0)


@settings(max_examples=50)
@given(networks(), st.randoms(use_true_random=False))
def test_the_order_of_the_file_changes_names_not_relations(parents: dict[str, list[str]], random: object) -> None:
    shuffled = list(parents)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    one, other = Network.from_parents(parents), Network.from_parents({name: parents[name] for name in shuffled})

    def relations(network: Network) -> dict[str, tuple[str, ...]]:
        return {
            name: tuple(network.names[p] for p in parents)
            for name, parents in zip(network.names, network.parents, strict=True)
        }

    def levels(network: Network) -> list[set[str]]:
        return [{network.names[i] for i in level} for level in network.levels]

    assert relations(one) == relations(other)
    assert levels(one) == levels(other)


@pytest.mark.parametrize(
    ("parents", "robot", "parent", "message"),
    [
        ({}, "", None, "no robots at all"),
        ({"a": ["a"]}, "a", 0, "'a' cannot track itself"),
        ({"l": [], "m": []}, "m", None, "no parents: a follower tracks someone, such as 'l'"),
        ({"leader": [], "b": ["leeder"]}, "b", 0, "no robot 'leeder'; did you mean 'leader'?"),
        ({"l": [], "b": ["l", "l"]}, "b", 1, "parent 'l' is listed twice"),
        ({"l": [], "b": ["l", "c"], "c": ["b"]}, "b", 1, "a circle: 'b' tracks 'c' tracks 'b'"),
        ({"l": [], "a": ["c"], "b": ["a"], "c": ["b"]}, "a", 0, "'a' tracks 'c' tracks 'b' tracks 'a'"),
    ],
)
def test_each_fault_names_robot_and_parent(
    parents: dict[str, list[str]], robot: str, parent: int | None, message: str
) -> None:
    with pytest.raises(NetworkError) as caught:
        Network.from_parents(parents)
    assert any(f.robot == robot and f.parent == parent and message in f.message for f in caught.value.faults)


def test_all_faults_come_at_once_and_followers_of_the_guilty_are_spared() -> None:
    faults = network_faults({"l": [], "a": ["b"], "b": ["a"], "c": ["a"], "d": ["nobody"], "e": ["d"]})
    assert [(fault.robot, fault.unknown) for fault in faults] == [("d", True), ("a", False)]


def test_of_many_unknown_parents_the_first_are_told_which_there_are() -> None:
    faults = network_faults({"l": []} | {f"f{k}": ["nobody"] for k in range(25)})
    assert ["available: l, f" in fault.message for fault in faults] == 20 * [True] + 5 * [False]


def test_level_arrays_can_index() -> None:
    network = Network.from_parents(DIAMOND)
    np.testing.assert_array_equal(np.arange(5.0)[network.levels[1]], [1.0, 2.0])
