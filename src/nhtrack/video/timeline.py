"""When each frame is, and where the robots are then."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.integrate import cumulative_trapezoid

from nhtrack import se2
from nhtrack.recording import Recording
from nhtrack.simulation.scene import Scene

__all__ = ["LONGEST", "Timeline", "Trail", "make_timeline", "make_trails", "pick_speed"]

LONGEST = 25.0  # [s] of film, unless a speed is asked for
_VERTICES = 1500  # of all trails together: each costs some 10 microseconds a frame
_STILL, _TURN_WEIGHT = 1e-6, 0.3  # [m] shorter steps have no direction; [m/rad] of path that a turn is worth
_SPEEDS = np.array([1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100])


@dataclass(frozen=True)
class Trail:
    """A robot's path.

    Attributes:
        time: robot time at each vertex [s], shape (k,).
        points: vertices on the floor [m], shape (k, 2).
    """

    time: np.ndarray
    points: np.ndarray


@dataclass(frozen=True)
class Timeline:
    """A film's frames and the state of the scene in each, f frames and n robots.

    Attributes:
        time: robot time of each frame [s], shape (f,).
        pose: poses of all robots, shape (f, n, 3).
        qpos: MuJoCo coordinates, shape (f, nq).
        distance: position error of each robot [m], shape (f, n), NaN for the root.
        trails: where each robot went, as polylines of few vertices.
        speed: robot seconds per second of film.
        fps: frames per second of film.
    """

    time: np.ndarray
    pose: np.ndarray
    qpos: np.ndarray
    distance: np.ndarray
    trails: tuple[Trail, ...]
    speed: float
    fps: int

    def __len__(self) -> int:
        """Returns the number of frames."""
        return int(self.time.size)


def pick_speed(duration: float) -> float:
    """Returns the slowest round speed at which `duration` [s] fits into `LONGEST`, never slower than life."""
    fitting = _SPEEDS[duration / _SPEEDS <= LONGEST]
    return float(fitting[0]) if fitting.size else float(np.ceil(duration / LONGEST / 100) * 100)


def make_timeline(recording: Recording, scene: Scene, fps: int, speed: float | None) -> Timeline:
    """Returns the frames of a recording, its samples interpolated linearly to the frames' times."""
    time = recording.time
    duration = float(time[-1] - time[0])
    rate = pick_speed(duration) if speed is None else speed
    frames = int(np.floor(duration / rate * fps + 1e-9)) + 1
    at = np.minimum(time[0] + np.arange(frames) * rate / fps, time[-1])
    error = recording["error"].values
    distance = np.hypot(error[..., 0], error[..., 1])
    return Timeline(
        time=at,
        pose=_interpolate(time, recording["pose"].values, at),
        qpos=_configuration(recording, scene, at),
        distance=_interpolate(time, distance, at),
        trails=make_trails(time, recording["pose"].values, _VERTICES),
        speed=rate,
        fps=fps,
    )


def make_trails(time: np.ndarray, pose: np.ndarray, vertices: int) -> tuple[Trail, ...]:
    """Returns for each robot a polyline along its path, at most `vertices` in all.

    Vertices are spread evenly over arc length plus turning, so that straights are sparse and bends stay round.

    Args:
        time: times [s], shape (t,).
        pose: poses, shape (t, n, 3).
        vertices: how many there may be in all.
    """
    share = max(vertices // pose.shape[1], 2)
    trails = []
    for xy in np.moveaxis(pose[..., :2], 1, 0):
        effort = _effort(xy)
        marks = np.linspace(0.0, effort[-1], min(share, time.size))
        chosen = np.unique(np.searchsorted(effort, marks).clip(0, time.size - 1))
        trails.append(Trail(time[chosen], xy[chosen]))
    return tuple(trails)


def _effort(xy: np.ndarray) -> np.ndarray:
    """Returns arc length plus weighted turning of the course [m] up to each point, shape (t, 2) -> (t,).

    The course is the direction of motion, not the heading: it turns by pi in a cusp, where the robot backs up.
    """
    step = np.diff(xy, axis=0)
    length = np.hypot(*step.T)
    moving = np.flatnonzero(length > _STILL)
    course = np.arctan2(step[moving, 1], step[moving, 0])
    turn = np.zeros(len(length))
    turn[moving[1:]] = np.abs(se2.wrap(np.diff(course)))
    return np.concatenate([[0.0], np.cumsum(length + _TURN_WEIGHT * turn)])


def _interpolate(time: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Returns values at the times `at`, linear between samples: shape (t, ...) -> (f, ...)."""
    if time.size == 1:
        return np.repeat(values, at.size, axis=0)
    after = np.clip(np.searchsorted(time, at, side="right"), 1, time.size - 1)
    share = ((at - time[after - 1]) / (time[after] - time[after - 1])).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[after - 1] * (1 - share) + values[after] * share)


def _configuration(recording: Recording, scene: Scene, at: np.ndarray) -> np.ndarray:
    """Returns MuJoCo coordinates at the times `at`; recordings without them are stood level on the floor."""
    time = recording.time
    if "qpos" in recording.dataset:
        return _unit_quaternions(scene.model, _interpolate(time, recording["qpos"].values, at))
    bodies = slice(1 if scene.spec.virtual_root else 0, None)
    pose = recording["pose"].values[:, bodies]
    angle = np.zeros((*pose.shape[:-1], 2))
    if "wheel_speed" in recording.dataset:
        rate = recording["wheel_speed"].values[:, bodies]
        angle = cumulative_trapezoid(rate, time, axis=0, initial=0.0) if time.size > 1 else angle
    # Poses are interpolated before they become quaternions, so a fast turn loses nothing
    qpos = scene.qpos_of(_interpolate(time, pose, at), _interpolate(time, angle, at))
    return np.asarray(qpos)


def _unit_quaternions(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    """Returns coordinates with the free joints' quaternions brought back to unit length."""
    first = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE] + 3
    places = first[:, None] + np.arange(4)
    result = qpos.copy()
    result[:, places] /= np.linalg.norm(result[:, places], axis=-1, keepdims=True)
    return result
