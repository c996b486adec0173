"""When each frame is, and what there is to see then."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from nhtrack import se2
from nhtrack.analysis.events import slip_speed, wheel_places
from nhtrack.analysis.spells import spells
from nhtrack.analysis.touches import touch_place, touches
from nhtrack.config.video import film_fault
from nhtrack.errors import RefusedFilmError, RenderError
from nhtrack.recording import Recording
from nhtrack.simulation.scene import Scene

__all__ = [
    "LONGEST",
    "Skid",
    "Timeline",
    "TouchMark",
    "Trail",
    "frame_times",
    "make_timeline",
    "make_trails",
    "pick_speed",
]

LONGEST = 25.0  # [s] of film, unless a speed is asked for
_VERTICES = 800  # of all trails together, unless told otherwise: each costs some 10 microseconds a frame
MOST_SKIDS = 300  # of all skid marks together
MOST_TOUCHES = 60  # of all marks where robots touched
SEEN = 0.6  # [s of film] for which a touch is told at least
_OWN_PLACE = 1e-3  # [m] a place nearer than this to the robot that is followed is that robot's own
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
class Skid:
    """A stretch of floor that a sliding wheel went over.

    Attributes:
        time: robot time at its end [s].
        points: its ends on the floor [m], shape (2, 2).
    """

    time: float
    points: np.ndarray


@dataclass(frozen=True)
class TouchMark:
    """Where two robots touched.

    Attributes:
        start: robot time at which they began to [s].
        end: at which they ceased to, or later where that is too soon to be seen [s].
        point: the middle between them then [m], shape (2,).
        robots: their names.
        places: of them among all robots.
    """

    start: float
    end: float
    point: np.ndarray
    robots: tuple[str, ...]
    places: tuple[int, ...]


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
        twin: poses of the robots of the ideal twin, shape (f, n, 3), NaN where they are unknown, or None.
        slot: poses the robots ought to take, shape (f, n, 3), NaN where that is another robot's pose.
        utilisation: share of friction that each wheel uses, shape (f, n, 2), or None.
        skids: where wheels slid, in the order of their times.
        touches: where robots touched, in the order of their times.
    """

    time: np.ndarray
    pose: np.ndarray
    qpos: np.ndarray
    distance: np.ndarray
    trails: tuple[Trail, ...]
    speed: float
    twin: np.ndarray | None = None
    slot: np.ndarray | None = None
    utilisation: np.ndarray | None = None
    skids: tuple[Skid, ...] = ()
    touches: tuple[TouchMark, ...] = ()

    def __len__(self) -> int:
        """Returns the number of frames."""
        return int(self.time.size)


def pick_speed(duration: float) -> float:
    """Returns the slowest round speed at which `duration` [s] fits into `LONGEST`, never slower than life."""
    fitting = _SPEEDS[duration / _SPEEDS <= LONGEST]
    return float(fitting[0]) if fitting.size else float(np.ceil(duration / LONGEST / 100) * 100)


def frame_times(time: np.ndarray, fps: int, speed: float | None) -> tuple[np.ndarray, float]:
    """Returns the robot time of each frame [s], shape (f,), and the robot seconds per second of film."""
    duration = float(time[-1] - time[0])
    if unmade := film_fault(duration, fps, speed):
        raise RefusedFilmError(f"speed: {unmade}")
    rate = pick_speed(duration) if speed is None else speed
    frames = int(np.floor(duration / rate * fps + 1e-9)) + 1
    return np.minimum(time[0] + np.arange(frames) * rate / fps, time[-1]), rate


def make_timeline(
    recording: Recording, scene: Scene, fps: int, speed: float | None, vertices: int = _VERTICES
) -> Timeline:
    """Returns the frames of a recording, its samples interpolated linearly to the frames' times.

    Args:
        recording: the run.
        scene: the one it was made in.
        fps: frames per second of film.
        speed: robot seconds per second of film, or None for `pick_speed`.
        vertices: how many all trails may have together.
    """
    time = recording.time
    at, rate = frame_times(time, fps, speed)
    error = recording["error"].values
    distance = np.hypot(error[..., 0], error[..., 1])
    return Timeline(
        time=at,
        pose=_interpolate(time, recording["pose"].values, at),
        qpos=_configuration(recording, scene, at),
        distance=_interpolate(time, distance, at),
        trails=make_trails(time, recording["pose"].values, vertices),
        speed=rate,
        twin=_interpolate(time, recording["ideal_pose"].values, at) if recording.has_twin else None,
        slot=_interpolate(time, _slots(recording), at),
        utilisation=_utilisation(recording, at),
        skids=_skids(recording),
        touches=_touches(recording, rate),
    )


def _touches(recording: Recording, rate: float) -> tuple[TouchMark, ...]:
    """Returns the marks of the hardest touches of robots; each is to be seen for a while of film."""
    found = sorted(touches(recording), key=lambda event: -event.worst)[:MOST_TOUCHES]
    marks = []
    for event in sorted(found, key=lambda event: event.start):
        end, places = max(event.end, event.start + SEEN * rate), tuple(map(recording.robots.index, event.robots))
        marks.append(TouchMark(event.start, end, touch_place(recording, event), event.robots, places))
    return tuple(marks)


def _utilisation(recording: Recording, at: np.ndarray) -> np.ndarray | None:
    """Returns the share of friction used, at most 1: that of a wheel without load is infinite."""
    if "friction_utilisation" not in recording.dataset:
        return None
    return _interpolate(recording.time, np.minimum(recording["friction_utilisation"].values, 1.0), at)


def _slots(recording: Recording) -> np.ndarray:
    """Returns what each robot was told to track, NaN where that is just the robot it follows; shape (t, n, 3)."""
    pose = recording["pose"].values
    if "leader_pose" not in recording.dataset:
        return np.full_like(pose, np.nan)
    slots = recording["leader_pose"].values.copy()
    for place, name in enumerate(recording.robots):
        parents = [recording.robots.index(parent) for parent in recording.parents[name]]
        if len(parents) == 1:
            away = np.hypot(*np.moveaxis(slots[:, place, :2] - pose[:, parents[0], :2], -1, 0))
            if not (away >= _OWN_PLACE).any():
                slots[:, place] = np.nan
    return np.asarray(slots)


def _skids(recording: Recording) -> tuple[Skid, ...]:
    """Returns the stretches of floor that sliding wheels went over, a limited number of them."""
    known = {"longitudinal_slip", "lateral_slip", "friction_utilisation"} <= set(recording.dataset.data_vars)
    if not known or not np.isfinite(recording.robot.half_separation):
        return ()
    wheels = wheel_places(recording)
    sliding = (slip_speed(recording) > 0) & _in_a_row(recording)[:, None, None]
    stride = max(1, int(np.ceil(sliding.sum() / MOST_SKIDS)))
    skids = []
    for robot, wheel in zip(*np.nonzero(sliding.any(axis=0)), strict=True):
        for first, last in zip(*spells(sliding[:, robot, wheel]), strict=True):
            # The first row stands for the period before it: the mark begins where that began
            rows = np.unique(np.append(np.arange(max(first - 1, 0), last, stride), last))
            track = wheels[rows, robot, wheel]
            skids += [Skid(float(recording.time[row]), track[k : k + 2]) for k, row in enumerate(rows[1:])]
    skids.sort(key=lambda skid: skid.time)
    return tuple(skids[:: max(1, -(-len(skids) // MOST_SKIDS))])  # wheels that chatter leave spells of a single row


def _in_a_row(recording: Recording) -> np.ndarray:
    """Returns which rows follow on the one before them in the run, too, shape (t,): a thinned recording has gaps."""
    step = np.diff(recording.time, prepend=-np.inf)
    return step <= (1.5 * step.min() if recording.rows > len(step) else np.inf)


def make_trails(time: np.ndarray, pose: np.ndarray, vertices: int) -> tuple[Trail, ...]:
    """Returns for each robot a polyline along its path, at most `vertices` in all.

    Vertices are spread evenly over arc length plus turning, so that straights are sparse and bends stay round, and
    evenly over the robots: stretches of a few pixels would leave a gap between any two.

    Args:
        time: times [s], shape (t,).
        pose: poses, shape (t, n, 3).
        vertices: how many there may be in all.
    """
    share = max(vertices // pose.shape[1], 2)
    paths = np.moveaxis(pose[..., :2], 1, 0)
    efforts = [_effort(xy) for xy in paths]
    most = max(float(effort[-1]) for effort in efforts)
    trails = []
    for xy, effort in zip(paths, efforts, strict=True):
        count = max(round(share * effort[-1] / most), 2) if most > 0 else 2
        marks = np.linspace(0.0, effort[-1], min(count, time.size))
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
        qpos = recording["qpos"].values
        if qpos.shape[1:] != (scene.model.nq,):
            raise RenderError(f"'qpos' has rows of {qpos.shape[1:]} numbers, the recording's scene of {scene.model.nq}")
        return _unit_quaternions(scene.model, _interpolate(time, qpos, at))
    bodies = slice(scene.spec.first_body, None)
    pose = recording["pose"].values[:, bodies]
    angle = np.zeros((*pose.shape[:-1], 2))
    if "wheel_speed" in recording.dataset:
        rate = recording["wheel_speed"].values[:, bodies]
        angle[1:] = np.cumsum(np.diff(time)[:, None, None] * (rate[1:] + rate[:-1]) / 2.0, axis=0)
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
