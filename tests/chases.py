"""Random followers and leaders, what laws command them, and where they arrive: for tests of velocity laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from array_laws import Leader, Robots
from nhtrack import se2
from nhtrack.experiment.loop import rollout
from nhtrack.laws import Law
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.network import Network
from nhtrack.simulation.ideal import IdealSimulation, propagate
from nhtrack.simulation.state import State

PI = math.pi
VelocityLaw = Any  # a class of `array_laws` with `k_inner` among its fields

# Central differences over 1e-4 s of functions whose third derivatives reach some hundreds.
STEP, DIFFERENCE = 1e-4, 1e-5


# -- what is drawn ----------------------------------------------------------------------------------

LINE, CIRCLE, REST, REVERSE = (1.0, 0.0, 0.0), (1.0, 0.0, 0.5), (0.0, 0.0, 0.0), (-1.0, 0.0, 0.2)


class Scene(NamedTuple):
    """Followers and their leaders, arrays (..., 3)."""

    follower: Robots
    leader: Leader


def random_scene(shape: tuple[int, ...], seed: int = 0) -> Scene:
    """Places in a square of 10 m, any heading within two turns, velocities and accelerations up to 2."""
    rng = np.random.default_rng(seed)
    g = rng.uniform(-5, 5, (2, *shape, 3)) * [1, 1, 2]
    xi = rng.uniform(-2, 2, (2, *shape, 3)) * [1, 0, 1]
    u = rng.uniform(-2, 2, (*shape, 3)) * [1, 0, 1]
    return Scene(Robots(g[0], xi[0]), Leader(g[1], xi[1], u))


def first_command(law: VelocityLaw, scene: Scene, memory: Any = None) -> np.ndarray:
    return np.asarray(law(*scene, law.init(*scene) if memory is None else memory)[0])


def behind(twist: tuple[float, ...]) -> Scene:
    """Random followers of leaders of one constant twist."""
    follower, leader = random_scene((500,), seed=7)
    return Scene(follower, Leader(leader.g, np.zeros_like(leader.xi) + twist, np.zeros_like(leader.u)))


def velocities(law: VelocityLaw, scene: Scene, memory: Any = None) -> np.ndarray:
    """(v_c, omega_c), read off the command: u = (v_c, omega_c)' - K ((v, omega) - (v_c, omega_c))."""
    without, with_gain = (first_command(replace(law, k_inner=k_inner), scene, memory) for k_inner in (0.0, 1.0))
    return scene.follower.xi[..., ::2] + with_gain - without


def on_command(law: VelocityLaw, scene: Scene) -> Scene:
    """The same places with the velocities that a law commands at them, for laws of which these need no velocity."""
    return scene._replace(follower=scene.follower._replace(xi=np.insert(velocities(law, scene), 1, 0.0, axis=-1)))


def errors(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(e_x, e_y, e_theta), the heading wrapped."""
    e = se2.between(scene.follower.g, scene.leader.g)
    return e[..., 0], e[..., 1], se2.wrap(e[..., 2])


def later(scene: Scene, dt: float, u: np.ndarray | float = 0.0) -> Scene:
    """The same robots after dt, the leader under its acceleration, the follower under another."""
    held = scene.leader.u[..., ::2]
    follower, leader = propagate(*scene.follower, u + 0.0 * held, dt), propagate(*scene.leader[:2], held, dt)
    return Scene(Robots(*follower), Leader(*leader, scene.leader.u))


def require_exact_derivatives(law: VelocityLaw, scene: Scene, *, driven: bool = False) -> None:
    """Fails where (v_c, omega_c)' is not what central differences say, of a leader that accelerates.

    Args:
        law: of which (v_c, omega_c) depend on places and leaders, and omega_c on v.
        scene: where.
        driven: the follower has the commanded speed and keeps it, for laws whose omega_c' has its acceleration; else it
            coasts.
    """
    if driven:
        scene = on_command(law, scene)
    memory = law.init(*scene)
    rate = first_command(replace(law, k_inner=0.0), scene, memory)
    u = rate if driven else 0.0
    steps = np.array([-2, -1, 1, 2]) * STEP
    before_2, before, after, after_2 = (velocities(law, later(scene, dt, u), memory) for dt in steps)
    difference = (8 * (after - before) - (after_2 - before_2)) / (12 * STEP)
    np.testing.assert_allclose(rate, difference, rtol=DIFFERENCE, atol=DIFFERENCE)


def require_falling(storage: Callable[[Scene], np.ndarray], law: VelocityLaw, scene: Scene) -> None:
    """Fails where a function of the scene grows along its motion, by central differences."""
    u = first_command(law, scene)
    rate = (storage(later(scene, STEP, u)) - storage(later(scene, -STEP, u))) / (2 * STEP)
    assert rate.max() <= DIFFERENCE
    assert np.median(rate) < -0.5


# -- sampled at 50 Hz -------------------------------------------------------------------------------

RATE = 50.0  # [Hz]


def starts(count: int, seed: int = 2024) -> tuple[np.ndarray, np.ndarray]:
    """Poses in a disc of 10 m, any heading, and twists |v|, |omega| <= 1, shapes (count, 3)."""
    rng = np.random.default_rng(seed)
    radius, bearing = 10 * np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-PI, PI, count)
    g = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), rng.uniform(-PI, PI, count)], axis=-1)
    return g, rng.uniform(-1, 1, (count, 3)) * [1, 0, 1]


def late_errors(
    law: VelocityLaw,
    twist: tuple[float, ...],
    count: int = 60,
    begin: np.ndarray | None = None,
    turning: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Largest |e_x|, |e_y|, distance and |e_theta| over the last 10 of 60 s of each start, shape (4, starts).

    Args:
        law: of the followers.
        twist: of the leader at the start, in the world's origin.
        count: random starts.
        begin: instead of random starts, poses of followers at rest, shape (starts, 3).
        turning: the leader's angular acceleration over time; none by default.
    """
    poses, twists = starts(count) if begin is None else (begin, np.zeros_like(begin))
    g, xi = np.zeros((2, len(poses), 2, 3))
    g[:, 1], xi[:, 1], xi[:, 0] = poses, twists, twist
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    simulation = IdealSimulation(network.names, None, 1 / RATE, keep_going=True)
    u_0 = np.zeros((round(60 * RATE), 2))
    if turning is not None:
        u_0[:, 1] = turning((np.arange(len(u_0)) + 0.5) / RATE)
    run = rollout(simulation, law.bound(), network, u_0, State(0.0, g, xi))
    assert not simulation.lost.any()
    pose = run.variables["pose"][run.time >= 50]
    x, y, theta = np.moveaxis(se2.between(pose[:, :, 1], pose[:, :, 0]), -1, 0)
    return np.abs([x, y, np.hypot(x, y), se2.wrap(theta)]).max(axis=1)


def reversal_distances(law: Law, period: float, reversals: int, start: float) -> np.ndarray:
    """Distances of followers that start in step but for a small distance, after each reversal, shape (reversals, 8).

    The leader's speed is 0.5 cos(2 pi t/period), on a line.
    """
    dt, count, rate = 0.01, 8, 2 * PI / period
    angles = 2 * PI * np.arange(count) / count
    g_0, xi_0 = np.zeros((count, 3)), np.tile([0.5, 0.0, 0.0], (count, 1))
    g = np.stack([start * np.cos(angles), start * np.sin(angles), np.zeros(count)], axis=-1)
    xi, memory, found = xi_0.copy(), None, []
    each = round(period / 2 / dt)
    for k in range(reversals * each):
        u_0 = np.tile([-0.5 * rate * math.sin(rate * (k + 0.5) * dt), 0.0, 0.0], (count, 1))
        follower, leader = np.concatenate([g, xi], axis=1), np.concatenate([g_0, xi_0, u_0], axis=1)
        if memory is None:
            memory = first_memories(law, follower, leader, dt)
        u, memory = commands(law, follower, leader, memory, dt)
        g, xi = propagate(g, xi, u, dt)
        g_0, xi_0 = propagate(g_0, xi_0, u_0[:, ::2], dt)
        if (k + 1) % each == 0:
            found.append(np.hypot(*(g - g_0)[:, :2].T))
    return np.array(found)
