"""Arrays of the angles that break trigonometric code, and of poses and twists with all of them."""

from __future__ import annotations

import math

import numpy as np

PI = math.pi


def ulps_about(value: float) -> list[float]:
    """Doubles up to eight steps away on either side."""
    return [value + count * math.ulp(value) for count in range(-8, 9)]


def both_signs(angles: list[float]) -> np.ndarray:
    return np.array([*angles, *(-angle for angle in angles)])


# Angles in [-pi, pi] over all 300 decades, zero and both ends; those that log is defined for, |theta| < 2 pi; any.
DECADES = [*np.logspace(-300, -13, 20), *np.logspace(-12, math.log10(PI), 60)]
BRANCH = both_signs([0.0, 5e-324, *DECADES, math.nextafter(1.0, 0.0), 1.0, PI])
BEYOND = both_signs([*ulps_about(PI), *(PI + np.logspace(-12, 0.49, 40)), *(PI - np.logspace(-12, -3, 20))])
LOG_ANGLES = np.concatenate([BRANCH, BEYOND, both_signs([2 * PI - 1e-3, math.nextafter(2 * PI, 0)])])
ANY_ANGLES = np.concatenate([LOG_ANGLES, np.random.default_rng(0).uniform(-100.0, 100.0, 150)])


def triples(angles: np.ndarray, seed: int) -> np.ndarray:
    """Rows of two lengths of any size a robot meets, some zero, and one of the angles, in any order."""
    rng = np.random.default_rng(seed)
    sizes = 10 ** rng.uniform(-12, 3, (len(angles), 2))
    signs = rng.choice([1.0, -1.0, 0.0], sizes.shape, p=[0.45, 0.45, 0.1])
    return np.column_stack([signs * sizes, rng.permutation(angles)])


def poses(seed: int) -> np.ndarray:
    return triples(ANY_ANGLES, seed)


def log_poses(seed: int) -> np.ndarray:
    return triples(LOG_ANGLES, seed)


def twists(seed: int) -> np.ndarray:
    return triples(np.random.default_rng(seed + 1).uniform(-10.0, 10.0, len(ANY_ANGLES)), seed)
