"""Angles: taken to one turn, and the turns counted."""

from __future__ import annotations

from math import pi

from nhtrack.arrays import Array, namespace


def wrap(theta: Array) -> Array:
    """Returns the angle in [-pi, pi] that differs from theta by whole turns (an even number at odd pi)."""
    xp = namespace(theta)
    return theta - 2 * pi * xp.round(theta / (2 * pi))


def winding_number(theta: Array, previous: Array | None = None, hysteresis: float = 0.25) -> Array:
    """Returns the whole turns w to take off an unwrapped heading so that theta - 2 pi w stays near [-pi, pi].

    The memory that a plain wrap lacks. Without `previous` the turn is the nearest one, and at an odd multiple
    of pi the one nearer zero, so that pi and -pi keep their signs. With `previous` the turn changes only once
    |theta - 2 pi previous| exceeds pi + hysteresis, so it cannot chatter at the antipode and never reaches
    the singularity of `log` at 2 pi.

    Args:
        theta: unwrapped headings [rad], shape (...).
        previous: winding numbers of the last call, shape (...), or None at the start.
        hysteresis: how far past the antipode the old branch is kept [rad], in (0, pi).
    """
    xp = namespace(theta)
    turns = theta / (2 * pi)
    nearest = xp.sign(turns) * xp.ceil(xp.abs(turns) - 0.5)
    if previous is None:
        return nearest
    return xp.where(xp.abs(theta - 2 * pi * previous) > pi + hysteresis, nearest, previous)
