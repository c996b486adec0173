"""Where robots stand in drawings of who tracks whom, and which way arrows go."""

from __future__ import annotations

import numpy as np
import pytest

from nhtrack.presentation.graph_layout import graph_layout

WIDTH, LARGEST = 3.1, 0.13  # [in] of a journal's column


def network(robots: int, seed: int) -> dict[str, list[str]]:
    """Returns a network in which robots have up to three parents, most of them near in number."""
    draw = np.random.default_rng(seed)
    parents: dict[str, list[str]] = {"r0": []}
    for k in range(1, robots):
        near = np.arange(max(0, k - int(draw.choice([1, 3, 100]))), k)
        chosen = draw.choice(near, min(len(near), int(draw.integers(1, 4))), replace=False)
        parents[f"r{k}"] = [f"r{parent}" for parent in chosen]
    return parents


NETWORKS = [{"L": [], "A": ["L"], "B": ["L"], "D": ["L", "B"]}]
NETWORKS += [network(robots, seed) for robots in (4, 7, 12, 20, 40) for seed in range(4)]


@pytest.mark.parametrize("parents", NETWORKS, ids=len)
def test_no_arrow_runs_over_a_robot(parents: dict[str, list[str]]) -> None:
    layout, t = graph_layout(parents, WIDTH, LARGEST), np.linspace(0.0, 1.0, 33)[:, None]
    assert set(layout.ways) == {(parent, child) for child, others in parents.items() for parent in others}
    for (parent, child), way in layout.ways.items():
        pieces = [way[k : k + 4] for k in range(0, len(way) - 1, 3)]
        weights = (1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3
        drawn = np.concatenate([sum(w * corner for w, corner in zip(weights, piece, strict=True)) for piece in pieces])
        for name, place in layout.places.items():
            nearest = np.linalg.norm(drawn - place, axis=-1).min()
            assert nearest > (0.99 if name in (parent, child) else 1.05) * layout.radius, (parent, child, name)
