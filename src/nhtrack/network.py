"""The communication graph: who tracks whom.

An edge goes from a parent to the robot that tracks it. The root is the leader; everybody else has at least
one parent and is reached from the root, and nobody tracks itself through others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

import numpy as np

from nhtrack.errors import NhtrackError, did_you_mean

_MOST_HINTS = 20  # unknown parents of which the names that there are are told


@dataclass(frozen=True)
class NetworkFault:
    """One thing wrong with the graph.

    Attributes:
        robot: the robot whose parents are at fault.
        parent: which of its parents, by index, or None where the whole list is meant.
        message: what is wrong and what would be right.
        unknown: whether it is that the parent does not exist.
    """

    robot: str
    parent: int | None
    message: str
    unknown: bool = False


class NetworkError(NhtrackError):
    """A communication graph on which no tracking can be defined.

    Attributes:
        faults: everything wrong with it.
    """

    def __init__(self, faults: Sequence[NetworkFault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(f"{fault.robot}: {fault.message}" for fault in self.faults))


@dataclass(frozen=True, eq=False)
class Network:
    """A rooted acyclic graph of robots, indices in the order of `names`.

    Attributes:
        names: the robots, root first, the others in the order given.
        parents: indices of each robot's parents, in the order given; () for the root.
        weights: lambda of each fold over a robot's parents (paper eq. 30), one fewer than the parents, in [0, 1].
        levels: indices of the robots by the length of the longest way from the root, shape (robots of the
            level,); level 0 is the root. A robot's parents all lie in earlier levels.
    """

    names: tuple[str, ...]
    parents: tuple[tuple[int, ...], ...]
    weights: tuple[tuple[float, ...], ...]
    levels: tuple[np.ndarray, ...]

    def __len__(self) -> int:
        """Returns the number of robots, the root included."""
        return len(self.names)

    @classmethod
    def from_parents(
        cls, parents: Mapping[str, Sequence[str]], weights: Mapping[str, Sequence[float]] | None = None
    ) -> Network:
        """Returns the network of every robot's list of parents; the root is the robot with an empty list.

        Args:
            parents: names of every robot's parents, in the order in which they are folded.
            weights: lambda of each fold for the robots that do not take equal shares of their parents.

        Raises:
            NetworkError: no root or several, an unknown or repeated parent, a robot tracking itself, a cycle,
            or a robot the
                root does not reach; weights that are not one fewer than the parents or not in [0, 1].
        """
        given = {name: tuple(values) for name, values in (weights or {}).items()}
        faults = [*network_faults(parents), *weight_faults(parents, given)]
        if faults:
            raise NetworkError(faults)
        root = next(name for name, others in parents.items() if not others)
        names = (root, *(name for name in parents if name != root))
        index = {name: i for i, name in enumerate(names)}
        levels = tuple(
            np.array(sorted(index[name] for name in level), dtype=np.intp) for level in generations(parents)
        )
        folds = tuple(given.get(name, equal_weights(len(parents[name]))) for name in names)
        return cls(names, tuple(tuple(index[parent] for parent in parents[name]) for name in names), folds, levels)


def generations(parents: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Returns the robots of every level, by the length of the longest way from the root, in the order given.

    Args:
        parents: names of every robot's parents, of whom nobody is unknown.

    Raises:
        CycleError: somebody tracks himself through others.
    """
    order = {name: place for place, name in enumerate(parents)}
    sorter = TopologicalSorter(parents)
    sorter.prepare()
    levels = []
    while sorter.is_active():
        level = sorted(sorter.get_ready(), key=order.__getitem__)
        sorter.done(*level)
        levels.append(level)
    return levels


def equal_weights(parents: int) -> tuple[float, ...]:
    """Returns the weights that give every one of so many parents the same share: 1/2, 1/3, ..."""
    return tuple(1 / (fold + 1) for fold in range(1, parents))


def weight_faults(
    parents: Mapping[str, Sequence[str]], weights: Mapping[str, Sequence[float]]
) -> list[NetworkFault]:
    """Returns what keeps weights from being those of a mapping from robot to parents; empty if nothing does."""
    faults = []
    for name, values in weights.items():
        expected = max(len(parents.get(name, ())) - 1, 0)
        if len(values) != expected:
            message = f"expected one weight fewer than parents, {expected} here, got {len(values)}"
            faults.append(NetworkFault(name, None, message))
        faults += [
            NetworkFault(name, None, f"expected weights from 0 to 1, got {value:g}")
            for value in values
            if not 0 <= value <= 1
        ]
    return faults


def network_faults(parents: Mapping[str, Sequence[str]]) -> list[NetworkFault]:
    """Returns everything that keeps a mapping from robot to parents from being a network."""
    faults = [*_root_faults(parents), *_parent_faults(parents)]
    blamed = {fault.robot for fault in faults}
    known = {name: [other for other in others if other in parents] for name, others in parents.items()}
    cycles = [*_cycle_faults(known, parents)]
    faults += cycles
    blamed |= {fault.robot for fault in cycles}
    roots = [name for name, others in parents.items() if not others]
    if len(roots) == 1:
        reached = _downstream(known, roots)
        # A robot downstream of one already blamed is a consequence, not another mistake.
        blamed = _downstream(known, blamed)
        faults += [
            NetworkFault(name, None, f"not reached from the leader {roots[0]!r}")
            for name in parents
            if name not in reached and name not in blamed
        ]
    return faults


def _downstream(parents: Mapping[str, Sequence[str]], starts: Iterable[str]) -> set[str]:
    """Returns robots and everybody who tracks them, through others or not."""
    children: dict[str, list[str]] = {name: [] for name in parents}
    for name, others in parents.items():
        for parent in others:
            children[parent].append(name)
    found, waiting = set[str](), list(starts)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += children.get(name, [])
    return found


def _root_faults(parents: Mapping[str, Sequence[str]]) -> Iterator[NetworkFault]:
    """Yields a fault for every robot without parents but the first."""
    if not parents:
        yield NetworkFault("", None, "no robots at all")
        return
    roots = [name for name, others in parents.items() if not others]
    if not roots:
        yield NetworkFault(next(iter(parents)), None, "every robot has parents, so nobody leads")
    for name in roots[1:]:
        yield NetworkFault(name, None, f"no parents: a follower tracks someone, such as {roots[0]!r}")


def _parent_faults(parents: Mapping[str, Sequence[str]]) -> Iterator[NetworkFault]:
    """Yields a fault for every parent that does not exist, is repeated, or is the robot itself."""
    unknown = 0
    for name, others in parents.items():
        for i, parent in enumerate(others):
            if parent == name:
                yield NetworkFault(name, i, f"{name!r} cannot track itself")
            elif parent not in parents:
                unknown += 1
                names = (each for each in parents if each != name)
                hint = f"; {did_you_mean(parent, names)}" if unknown <= _MOST_HINTS else ""
                yield NetworkFault(name, i, f"no robot {parent!r}{hint}", unknown=True)
            elif parent in others[:i]:
                yield NetworkFault(name, i, f"parent {parent!r} is listed twice")


def _cycle_faults(known: Mapping[str, Sequence[str]], parents: Mapping[str, Sequence[str]]) -> Iterator[NetworkFault]:
    """Yields one fault for every group of robots that track each other, at its first member."""
    try:
        TopologicalSorter(known).prepare()
    except CycleError:
        import networkx as nx  # takes long to import, and only a graph at fault needs it
    else:
        return
    graph = nx.DiGraph((parent, name) for name, others in known.items() for parent in others)
    order = {name: i for i, name in enumerate(parents)}
    for group in nx.strongly_connected_components(graph):
        if len(group) == 1:
            continue
        first = min(group, key=order.__getitem__)
        edges = nx.find_cycle(graph.subgraph(group), first)
        cycle = [first]
        following = dict(reversed(edge) for edge in edges)
        if first not in following:
            first = min(following, key=order.__getitem__)
            cycle = [first]
        while following[cycle[-1]] != first:
            cycle.append(following[cycle[-1]])
        at = list(parents[first]).index(following[first])
        chain = " tracks ".join(repr(name) for name in (*cycle, first))
        yield NetworkFault(first, at, f"a circle: {chain}; somebody must track the leader")
