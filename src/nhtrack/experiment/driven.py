"""Where robots are to drive, from the scenario alone, and which patches of the floor lie there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.ground import Ground, Patch
from nhtrack.network import generations

_NODES = 4  # of the quadrature that finds places, in a control period
_SAMPLES = 2000  # of the leader's way while a time scale is yet to be found
_WAY = 200  # samples of the straight way from a start to a place


def root_path(u: Array, dt: float, pose: Array, twist: Array) -> tuple[Array, Array, Array]:
    """Returns how a root moves on the ideal model: poses, shape (k + 1, 3), and v and omega, shape (k + 1,).

    Args:
        u: accelerations held for each period, shape (k, 2).
        dt: the period.
        pose: where it begins, shape (3,).
        twist: its body twist then, shape (3,).
    """
    v, omega = (_summed(rate * dt, start) for rate, start in zip(u.T, twist[::2], strict=True))
    heading = _summed((omega[:-1] + u[:, 1] * dt / 2) * dt, pose[2])
    places = np.zeros(len(u), dtype=complex)
    for node, weight in zip(*np.polynomial.legendre.leggauss(_NODES), strict=True):
        s = dt * (1 + node) / 2
        angle = heading[:-1] + omega[:-1] * s + u[:, 1] * s * s / 2
        places += dt * weight / 2 * (v[:-1] + u[:, 0] * s) * np.exp(1j * angle)
    place = _summed(places, pose[0] + 1j * pose[1])
    return np.stack([place.real, place.imag, heading], axis=-1), v, omega


def _summed(steps: Array, start: Any) -> Array:
    """Returns a quantity at the ends of all steps, and at the start."""
    return np.concatenate([[start], start + np.cumsum(steps)])


def patches_met(scenario: Scenario, ground: Ground, width: float) -> tuple[int, ...]:
    """Returns the indices of the patches that robots meet; needs no time scale.

    Where the leader drives, where followers' places go with it, and on the straight way from every start to its place.

    Args:
        scenario: whose robots.
        ground: with its patches, in robot units.
        width: how near a way comes to a patch that it meets [m].
    """
    if not ground.patches:
        return ()
    met: set[int] = set()
    for way in _ways(scenario):
        met |= {i for i, patch in enumerate(ground.patches) if i not in met and _meets(patch, way, width)}
    return tuple(sorted(met))


def _meets(patch: Patch, way: Array, width: float) -> bool:
    """Returns whether a way, shape (k, 2), comes as near to a patch as a width."""
    steps = np.hypot(*np.diff(way, axis=0).T)
    return bool(patch.grown(width + float(steps.max(initial=0.0)) / 2).covers(way).any())


def _ways(scenario: Scenario) -> Iterator[Array]:
    """Yields the ways of leader, places and starts [m], shape (k, 2) each."""
    length, leader = scenario.similarity.length, scenario.leader
    count = _SAMPLES if scenario.similarity.time == "auto" else scenario.periods
    period = scenario.duration / count
    twist = np.array([leader.start.twist[0], 0.0, leader.start.twist[1]])
    u = leader.input.reference().held(period * np.arange(count + 1))
    pose = root_path(u, period, np.array(leader.start.pose), twist)[0]
    way, turn, places = pose[:, 0] + 1j * pose[:, 1], np.exp(1j * pose[:, 2]), _places(scenario)
    for place in set(places.values()):
        yield length * _plane(way + turn * place)
    for follower in scenario.followers:
        x, y, _ = follower.start.pose
        yield length * _plane(np.linspace(x + 1j * y, way[0] + turn[0] * places[follower.name], _WAY))


def _places(scenario: Scenario) -> dict[str, complex]:
    """Returns the place of every robot in the leader's frame, about: as if all of their leaders headed as it does."""
    own = {follower.name: complex(*follower.offset) for follower in scenario.followers}
    places: dict[str, complex] = {}
    for name in (name for generation in generations(scenario.parents) for name in generation):
        parents = [places[parent] for parent in scenario.parents[name]]
        places[name] = own.get(name, 0j) + (sum(parents) / len(parents) if parents else 0j)
    return places


def _plane(places: Array) -> Array:
    return np.stack([places.real, places.imag], axis=-1)
