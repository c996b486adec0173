"""Where robots stand in a drawing of who tracks whom, and which way arrows go, whoever draws it.

Levels, robots by the length of the longest way from the root, are columns from left to right; where one has very many
robots they are rings around the root. An arrow that passes a level has a place there as a robot has, so that none runs
over a robot (as in layered drawings of Sugiyama, Tagawa and Toda, 1981).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from nhtrack.arrays import Array
from nhtrack.network import generations
from nhtrack.presentation.spread import spread

Edge: TypeAlias = tuple[str, str]  # parent and child
_Stop: TypeAlias = tuple[str, int]  # a robot on its level, or the arrows from it on a level that they pass

_SPACING = (0.8, 0.42)  # [in] between levels, and between the robots of a level, at most
_LEAST_ROW = 0.19  # [in] between the robots of a level, at least
_WIDEST = 20  # a level of more robots is a ring around the root
_FILLS, _RING_FILLS = 0.38, 0.44  # a circle's radius, at most, over the distance to the next, in columns and rings
_LINE = 10  # levels in a line; a longer chain goes on in the next, back and forth
_TURN = 0.25  # [in] beside the ends of a line, for arrows that go on in the next
_NAME_ROW = 0.3  # [in] between the robots of a level where a name fits below each


class GraphLayout(NamedTuple):
    """A drawing of who tracks whom.

    Attributes:
        places: of the robots (x, y) [in], y upwards.
        radius: of their circles [in].
        ways: of the arrows [in], the corners of cubic Bezier curves one after the other, shape (3 m + 1, 2): from the
            rim of the parent's circle to that of the child's.
        name_width: width that there is for a name below a circle [in]; 0 where names do not fit.
    """

    places: dict[str, Array]
    radius: float
    ways: dict[Edge, Array]
    name_width: float


def graph_layout(parents: Mapping[str, Sequence[str]], width: float, largest: float) -> GraphLayout:
    """Returns how robots and arrows are drawn.

    Args:
        parents: of every robot by name, the root first.
        width: between the outermost places [in].
        largest: radius of a circle where there is room [in].
    """
    level_of = {name: k for k, level in enumerate(generations(parents)) for name in level}
    edges = [(parent, child) for child, others in parents.items() for parent in others]
    levels = _levels(parents, level_of)
    robots = [[name for name, own in level if level_of[name] == own] for level in levels]
    if max(map(len, robots)) > _WIDEST:
        places = _rings(robots, parents, width)
        radius = _radius(list(places.values()), largest, _RING_FILLS)
        return GraphLayout(places, radius, {edge: _straight(places, edge, radius) for edge in edges}, 0.0)
    stops, across, down = _columns(levels, width)
    radius = _radius(list(stops.values()), largest, _FILLS)
    ways = {
        (parent, child): _winding([stops[parent, k] for k in range(level_of[parent], level_of[child])]
                                  + [stops[child, level_of[child]]], level_of[parent], radius)
        for parent, child in edges
    }  # fmt: skip
    places = {name: stops[name, level_of[name]] for name in parents}
    return GraphLayout(places, radius, ways, 0.9 * across if down >= _NAME_ROW else 0.0)


def _radius(spots: Sequence[Array], largest: float, fills: float) -> float:
    """Returns the largest radius of circles that is no more than a share of the distance to the next [in]."""
    everything = np.array(spots)
    apart = np.linalg.norm(everything[:, None] - everything[None], axis=-1)
    return min(largest, fills * float(apart[apart > 0].min(initial=np.inf)))


def _levels(parents: Mapping[str, Sequence[str]], level_of: Mapping[str, int]) -> list[list[_Stop]]:
    """Returns the stops on every level, each as near as may be to those before it on its ways."""
    before: dict[_Stop, list[_Stop]] = {(name, level): [] for name, level in level_of.items()}
    for name, others in parents.items():
        for parent in others:
            passed = range(level_of[parent] + 1, level_of[name])
            before |= {(parent, level): [(parent, level - 1)] for level in passed}
            before[name, level_of[name]].append((parent, level_of[name] - 1))
    share: dict[_Stop, float] = {}  # how far down its level a stop is
    levels = []
    for k in range(max(level_of.values()) + 1):
        level = [stop for stop in before if stop[1] == k]
        level.sort(key=lambda stop: float(np.mean([share[other] for other in before[stop]] or [0.0])))
        share |= {stop: (row + 0.5) / len(level) for row, stop in enumerate(level)}
        levels.append(level)
    return levels


def _columns(levels: Sequence[Sequence[_Stop]], width: float) -> tuple[dict[_Stop, Array], float, float]:
    """Returns the places of all stops, the distance between levels and that between the rows of a level [in]."""
    most = max(map(len, levels))
    room = width if len(levels) <= _LINE else width - 2 * _TURN
    across = min(_SPACING[0], room / max(min(len(levels), _LINE) - 1, 1))
    down = float(np.clip(2.4 / max(most - 1, 1), _LEAST_ROW, _SPACING[1]))
    spots = {}
    for k, level in enumerate(levels):
        line, column = divmod(k, _LINE)
        x = across * (column if line % 2 == 0 else _LINE - 1 - column)
        for row, stop in enumerate(level):
            y = down * ((len(level) - 1) / 2 - row) - line * (down * (most - 1) + _SPACING[1])
            spots[stop] = np.array([x, y])
    return spots, across, down


def _winding(stops: Sequence[Array], first: int, radius: float) -> Array:
    """Returns a way through stops on consecutive levels, along its line in each; see `GraphLayout.ways`.

    It crosses the columns of robots at right angles, and so keeps clear of those above and below.

    Args:
        stops: places on their levels [in].
        first: level of the first one.
        radius: of circles [in].
    """
    along = [np.array([1.0 if (first + k) // _LINE % 2 == 0 else -1.0, 0.0]) for k in range(len(stops))]
    corners = [stops[0] + radius * along[0]]
    for k in range(len(stops) - 1):
        leaves, reaches = stops[k] + radius * along[k], stops[k + 1] - radius * along[k + 1]
        turns = float(along[k] @ along[k + 1]) < 0
        reach = _TURN if turns else abs(float(reaches[0] - leaves[0])) / 2
        corners += [leaves + reach * along[k], reaches - reach * along[k + 1], reaches]
        if k + 2 < len(stops):
            corners += list(np.linspace(reaches, stops[k + 1] + radius * along[k + 1], 4)[1:])
    return np.array(corners)


def _straight(places: Mapping[str, Array], edge: Edge, radius: float) -> Array:
    """Returns a straight way from rim to rim; see `GraphLayout.ways`."""
    start, end = (places[name] for name in edge)
    ahead = (end - start) / np.linalg.norm(end - start)
    return np.linspace(start + radius * ahead, end - radius * ahead, 4)


def _rings(levels: Sequence[Sequence[str]], parents: Mapping[str, Sequence[str]], width: float) -> dict[str, Array]:
    """Returns places on rings around the root, each robot about as far round as its parents."""
    step = width / 2 / (len(levels) - 1)
    share: dict[str, float] = {}  # how far round its ring a robot is, from 0 to 1
    spots = {levels[0][0]: np.zeros(2)}
    for k, level in enumerate(levels[1:], start=1):
        if k == 1:
            shares = (np.arange(len(level)) + 0.5) / len(level)
        else:
            least = min(_LEAST_ROW / (2 * np.pi * k * step), 1 / len(level))
            wanted = [np.mean([share.get(parent, 0.5) for parent in parents[name]]) for name in level]
            shares = spread(np.array(wanted), least)
        share |= dict(zip(level, shares.tolist(), strict=True))
        angle = np.pi / 2 - 2 * np.pi * shares
        places = k * step * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        spots |= dict(zip(level, places, strict=True))
    return spots
