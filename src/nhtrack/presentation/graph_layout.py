"""Where robots stand in a drawing of who tracks whom, whoever draws it.

Levels, robots by the length of the longest way from the root, are columns from left to right; where one has very many
robots they are rings around the root.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from nhtrack.arrays import Array
from nhtrack.network import generations
from nhtrack.presentation.spread import spread

_SPACING = (0.8, 0.42)  # [in] between levels, and between the robots of a level, at most
_LEAST_ROW = 0.19  # [in] between the robots of a level, at least
_WIDEST = 20  # a level of more robots is a ring around the root
_FILLS = 0.44  # a circle's radius, at most, over the distance to the next
_LINE = 10  # levels in a line; a longer chain goes on in the next, back and forth


def graph_places(parents: Mapping[str, Sequence[str]], width: float) -> dict[str, Array]:
    """Returns the places (x, y) of robots [in], y upwards, no further apart than a width.

    Args:
        parents: of every robot by name, the root first.
        width: between the outermost places [in].
    """
    levels = _levels(parents)
    return _rings(levels, parents, width) if max(map(len, levels)) > _WIDEST else _columns(levels, width)


def graph_radius(places: Mapping[str, Array], largest: float) -> float:
    """Returns the radius [in] of robots' circles: the largest that leaves room for arrows between them."""
    spots = np.array(list(places.values()))
    apart = np.linalg.norm(spots[:, None] - spots[None], axis=-1)
    return min(largest, _FILLS * float(apart[apart > 0].min(initial=np.inf)))


def _levels(parents: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Returns the robots of every level, each as near as may be to its parents' places in theirs."""
    share: dict[str, float] = {}  # how far down its level a robot is
    levels = []
    for level in generations(parents):
        level.sort(key=lambda name: float(np.mean([share[parent] for parent in parents[name]] or [0.0])))
        share |= {name: (row + 0.5) / len(level) for row, name in enumerate(level)}
        levels.append(level)
    return levels


def _columns(levels: Sequence[Sequence[str]], width: float) -> dict[str, Array]:
    most = max(map(len, levels))
    across = min(_SPACING[0], width / max(min(len(levels), _LINE) - 1, 1))
    down = float(np.clip(2.4 / max(most - 1, 1), _LEAST_ROW, _SPACING[1]))
    spots = {}
    for k, level in enumerate(levels):
        line, column = divmod(k, _LINE)
        x = across * (column if line % 2 == 0 else _LINE - 1 - column)
        for row, name in enumerate(level):
            y = down * ((len(level) - 1) / 2 - row) - line * (down * (most - 1) + _SPACING[1])
            spots[name] = np.array([x, y])
    return spots


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
