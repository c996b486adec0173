"""Columns of arrays, and the quotient of sines that the formulas of SE(2) share."""

from __future__ import annotations

from nhtrack.arrays import Array, Namespace, require_last_axis


def sinc(xp: Namespace, x: Array) -> Array:
    """Returns sin(x)/x, 1 at x = 0; exact to rounding for every x."""
    at_zero = x == 0
    safe = xp.where(at_zero, xp.ones_like(x), x)
    return xp.where(at_zero, xp.ones_like(x), xp.sin(safe) / safe)


def columns(name: str, array: Array) -> tuple[Array, Array, Array]:
    """Returns the three components of poses, twists or coordinates, each of shape (...).

    Raises:
        ValueError: another shape than (..., 3); the message calls the array by its name.
    """
    require_last_axis(name, array, 3)
    return array[..., 0], array[..., 1], array[..., 2]


def stack(xp: Namespace, *components: Array) -> Array:
    """Returns components side by side in a last axis, broadcast over the leading ones."""
    return xp.stack(xp.broadcast_arrays(*components), axis=-1)
