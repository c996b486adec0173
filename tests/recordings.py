"""Recordings made of formulas: what figures, film and tables are shown when no physics is wanted."""

from __future__ import annotations

from typing import Any

import numpy as np

from nhtrack import se2
from nhtrack.experiment.load import load
from nhtrack.recording import Recording, make_recording

WHEEL_RADIUS, HALF_SEPARATION = 0.016, 0.043  # [m]
TORQUE_LIMIT = 0.03  # [N m]


def robot_names(followers: int) -> tuple[str, ...]:
    return (
        ("leader", "follower") if followers == 1 else ("leader", *(f"f{k}" for k in range(1, followers + 1)))
    )


def leader_path(time: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns poses and body twists (t, 3) of a leader that winds its way along some 6 m."""
    omega = 8.0 / duration * np.cos(4 * np.pi * time / duration + 0.4)
    v = 6.0 / duration * (1.0 + 0.4 * np.sin(2 * np.pi * time / duration))
    theta = integral(omega, time)
    path = np.stack([integral(v * np.cos(theta), time), integral(v * np.sin(theta), time), theta], axis=-1)
    return path, np.stack([v, np.zeros_like(v), omega], axis=-1)


def integral(rate: np.ndarray, time: np.ndarray) -> np.ndarray:
    steps = np.diff(time, prepend=time[0])
    return np.cumsum(rate * steps, axis=0)


def twists(poses: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Returns body twists (t, n, 3) of poses (t, n, 3) by differences."""
    rate = np.gradient(poses, time, axis=0)
    return np.concatenate([se2.rotate(-poses[..., 2], rate[..., :2]), rate[..., 2:]], axis=-1)


def follower_paths(leader: np.ndarray, followers: int, time: np.ndarray, duration: float) -> np.ndarray:
    """Returns poses (t, followers, 3) that begin 1 to 3 m from the leader and end beside it."""
    rng = np.random.default_rng(7)
    bearing = -np.pi / 4 + 2 * np.pi * np.arange(followers) / followers
    reach = np.linspace(1.2, 2.8, followers) if followers > 1 else np.array([2.8])
    turn = rng.uniform(-2.5, 2.5, followers)
    decay = np.exp(-time / (duration / 12))[:, None]
    wobble = 0.004 * np.sin(40 * time / duration)[:, None]
    x = decay * reach * np.cos(bearing + 2.0 * (1 - decay)) + wobble
    y = decay * reach * np.sin(bearing + 2.0 * (1 - decay))
    offset = np.stack([x, y, decay * turn + 2 * wobble], axis=-1)
    return np.asarray(se2.compose(leader[:, None, :], offset))


def wheel_quantities(twist: np.ndarray, time: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    v, omega = twist[..., 0], twist[..., 2]
    sides = np.array([-1.0, 1.0])
    spin = (v[..., None] + sides * HALF_SEPARATION * omega[..., None]) / WHEEL_RADIUS
    demand = 2e-4 * np.gradient(spin, time, axis=0) + 1e-3 * rng.standard_normal(spin.shape)
    load = 1.0 + 0.1 * sides * np.tanh(v * omega)[..., None] + 0.005 * rng.standard_normal(spin.shape)
    use = np.clip(np.hypot(demand / WHEEL_RADIUS / load, (v * omega)[..., None] / 9.81), 0, 0.999)
    return {
        "wheel_speed": spin,
        "wheel_torque_demand": demand,
        "wheel_torque": np.clip(demand, -TORQUE_LIMIT, TORQUE_LIMIT),
        "wheel_load": load,
        "longitudinal_slip": 2e-5 * rng.standard_normal(spin.shape) + 1e-4 * demand,
        "lateral_slip": 1e-5 * rng.standard_normal(v.shape) + 1e-4 * v * omega,
        "friction_utilisation": use,
        "friction_utilisation_predicted": np.clip(use * 0.97, 0, None),
        "wheel_clearance": np.zeros_like(spin),
        "tilt": 1e-4 * np.abs(rng.standard_normal(v.shape)),
    }


def synthetic_recording(
    followers: int = 1, *, backend: str = "mujoco", samples: int = 801, **changes: Any
) -> Recording:
    """Returns a run of formulas: a winding leader and followers that come to it.

    Args:
        followers: how many.
        backend: `ideal` leaves out what only wheels have.
        samples: control instants in 80 s.
        **changes: attributes to replace; `stop` [s] cuts the run short as an interruption would.
    """
    stop, duration = changes.pop("stop", None), 80.0
    time = np.linspace(0.0, duration, samples)
    leader, _ = leader_path(time, duration)
    poses = np.concatenate([leader[:, None, :], follower_paths(leader, followers, time, duration)], axis=1)
    rng = np.random.default_rng(3)
    twist = twists(poses, time)
    wheels = wheel_quantities(twist, time, rng)
    told = np.broadcast_to(poses[:, :1], poses.shape).copy()
    told[:, 0] = np.nan
    gap = 2e-4 * np.stack([np.sin(time / 7), np.cos(time / 5), np.sin(time / 9)], axis=-1)[:, None, :]
    error = np.asarray(se2.between(told, poses))
    error[..., 2] = np.asarray(se2.wrap(error[..., 2]))
    acceleration = np.gradient(twist, time, axis=0)[..., [0, 2]]
    variables = {"pose": poses, "twist": twist, "input": acceleration, "error": error, "leader_pose": told}
    variables["leader_twist"] = np.where(np.isnan(told), np.nan, twist[:, :1])
    variables["ideal_pose"] = poses if backend == "ideal" else poses - gap * np.exp(-time / 60)[:, None, None]
    variables |= {"wheel_speed": wheels["wheel_speed"]} if backend == "ideal" else wheels
    kept = slice(None) if stop is None else time <= stop
    names = robot_names(followers)
    attributes: dict[str, Any] = {
        "name": "example1",
        "backend": backend,
        "length_scale": 0.004,
        "time_scale": 4.0,
        "outcome": "completed" if stop is None else "interrupted",
        "parents": {name: [names[0]] if name != names[0] else [] for name in names},
        "torque_limit": TORQUE_LIMIT,
        "scenario": load("tour/hello").model_dump(mode="json"),
        "versions": {},
    }
    return make_recording(time[kept], names, {k: v[kept] for k, v in variables.items()}, attributes | changes)
