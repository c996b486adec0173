"""The leader seen from its follower, as arrays: kept as second implementation."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader, Robots


class View(NamedTuple):
    """Tracking error in the follower's frame and its rates; arrays of shape (...)."""

    x: Array
    y: Array
    theta: Array
    cos: Array
    sin: Array
    x_rate: Array
    y_rate: Array
    theta_rate: Array

    def turned(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Returns a vector of the leader's frame in the follower's."""
        return self.cos * x - self.sin * y, self.sin * x + self.cos * y


def view(follower: Robots, leader: Leader) -> View:
    """Returns the leader seen from its follower; a lateral velocity v_yr of the leader enters the rates."""
    xp = namespace(follower.g, leader.g)
    e = se2.between(follower.g, leader.g)
    x, y, theta = e[..., 0], e[..., 1], e[..., 2]
    v, omega = follower.xi[..., 0], follower.xi[..., 2]
    still = View(x, y, theta, xp.cos(theta), xp.sin(theta), x, y, theta)
    forward, aside = still.turned(leader.xi[..., 0], leader.xi[..., 1])
    return still._replace(
        x_rate=forward - v + omega * y, y_rate=aside - omega * x, theta_rate=leader.xi[..., 2] - omega
    )


def unturned(seen: View, turns: Array | None, hysteresis: float) -> tuple[View, Array]:
    """Returns a view whose e_theta has whole turns taken off, and their number; see `se2.winding_number`."""
    turns = se2.winding_number(seen.theta, turns, hysteresis)
    return seen._replace(theta=seen.theta - 2 * pi * turns), turns


def sinc(theta: Array) -> tuple[Array, Array]:
    """Returns sin(theta)/theta and its derivative (cos(theta) - sin(theta)/theta)/theta, 1 and 0 at theta = 0."""
    xp = namespace(theta)
    one, square = xp.ones_like(theta), theta * theta
    safe = xp.where(theta == 0, one, theta)
    value = xp.where(theta == 0, one, xp.sin(safe) / safe)
    series = -theta * (1 / 3 - square * (1 / 30 - square * (1 / 840 - square / 45360)))
    return value, xp.where(xp.abs(theta) < 0.1, series, (xp.cos(safe) - value) / safe)
