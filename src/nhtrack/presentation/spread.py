"""Places moved apart until names, or robots, fit beside each other."""

from __future__ import annotations

import numpy as np


def spread(places: np.ndarray, step: float) -> np.ndarray:
    """Returns places from 0 to 1 moved apart to at least `step`, in the same order, each as little as may be.

    Places that come too near are moved as one block, which stands around their mean (pool adjacent violators).
    """
    order = np.argsort(places, kind="stable")
    blocks: list[tuple[float, int]] = []  # where the lowest of so many would stand, if it were for their mean
    for place in places[order]:
        block = (float(place), 1)
        while blocks and _lowest(blocks[-1], step) + step * blocks[-1][1] > _lowest(block, step):
            (below, fewer), (above, more) = blocks.pop(), block
            block = ((below * fewer + (above - step * fewer) * more) / (fewer + more), fewer + more)
        blocks.append(block)
    result = np.empty(len(places))
    result[order] = np.concatenate([_lowest(block, step) + step * np.arange(block[1]) for block in blocks])
    return result


def _lowest(block: tuple[float, int], step: float) -> float:
    """Returns where the lowest of a block stands: all of it within 0 to 1, where there is the room."""
    place, count = block
    return float(np.clip(place, 0.0, max(0.0, 1.0 - step * (count - 1))))
