"""Where the camera is in every frame: decided for the whole film before the first frame is drawn.

A film is made after the run, so the camera may look ahead. Its path is smoothed without delay by a filter that is
symmetric in time: it does not lag behind the robots and does not jitter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from nhtrack.errors import RenderError, did_you_mean

__all__ = ["CAMERAS", "CameraPath", "plan_camera"]

_ELEVATION = -38.0  # [deg] of `group` and `isometric`
_CLOSEST = 0.95  # [m] nearest the group camera goes: a robot of 0.1 m is then a fifth of the picture wide
_ROBOT_REACH = 0.08  # [m] from a robot's axle midpoint to its outermost point, with air
_TURNS, _GAIN = (-30.0, 25.0, 50.0, 75.0), 0.05  # [deg] other directions, and how much nearer is worth to turn
_LOOKS = 60  # frames in which directions are compared
_CALM = 0.9  # [s] of film over which the camera's path is smoothed (standard deviation)
# Share of the half picture that robots may fill: left and right, below, above (above are the title and the map).
_SIDE, _BELOW, _ABOVE = 0.80, 0.80, 0.40
# Share of the half picture by which its subject lies below the middle: less than half way between those bounds, since
# what is near, below, looks larger.
_LOWERED = 0.1


@dataclass(frozen=True)
class CameraPath:
    """A free camera in each of f frames, in MuJoCo's terms.

    Attributes:
        lookat: points looked at [m], shape (f, 3).
        distance: from them [m], shape (f,).
        azimuth: direction of view about the vertical [deg], shape (f,).
        elevation: direction of view above the horizontal [deg], shape (f,).
    """

    lookat: np.ndarray
    distance: np.ndarray
    azimuth: np.ndarray
    elevation: np.ndarray

    def place(self, camera: mujoco.MjvCamera, frame: int) -> None:
        """Puts MuJoCo's camera where it is in a frame."""
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat, camera.distance = self.lookat[frame], float(self.distance[frame])
        camera.azimuth, camera.elevation = float(self.azimuth[frame]), float(self.elevation[frame])

    def project(self, frame: int, points: np.ndarray, fovy: float, size: tuple[int, int]) -> np.ndarray:
        """Returns where points fall in the picture of a frame, x to the right and y down [pixels]; NaN behind it.

        Args:
            frame: which frame it is.
            points: in the world [m], shape (k, 3).
            fovy: vertical field of view [deg].
            size: width and height of the picture [pixels].
        """
        axes = _axes(float(self.azimuth[frame]), float(self.elevation[frame]))
        right, up, depth = ((points - self.lookat[frame]) @ axes.T).T
        depth = depth + self.distance[frame]
        scale = size[1] / 2 / np.tan(np.radians(fovy) / 2) / np.where(depth > 0, depth, np.nan)
        return np.asarray(np.stack([size[0] / 2 + scale * right, size[1] / 2 - scale * up], axis=-1))


@dataclass(frozen=True)
class Lens:
    """What the picture holds: half its height and width as tangents of the angle from its middle."""

    vertical: float
    horizontal: float


def plan_camera(
    name: str, pose: np.ndarray, fovy: float, aspect: float, fps: int, scale: float = 1.0
) -> CameraPath:
    """Returns the path of one of `CAMERAS` over a film.

    Args:
        name: `group`, `isometric`, `top` or `chase`.
        pose: poses of the robots in each frame, shape (f, n, 3).
        fovy: vertical field of view [deg].
        aspect: width over height of the picture.
        fps: frames per second of film.
        scale: size of the robots over that of nh_mini, for which the distances of this module are meant.

    Raises:
        RenderError: no camera of that name.
    """
    if name not in CAMERAS:
        raise RenderError(f"no camera {name!r}; {did_you_mean(name, CAMERAS)}")
    vertical = float(np.tan(np.radians(fovy) / 2))
    small = pose / np.array([scale, scale, 1.0])
    path = CAMERAS[name](small, Lens(vertical, vertical * aspect), fps * _CALM)
    return replace(path, lookat=scale * path.lookat, distance=scale * path.distance)


def _group(pose: np.ndarray, lens: Lens, calm: float) -> CameraPath:
    """Frames all robots, closer as they come together, from a fixed direction oblique to the leader's way."""
    points = _with_height(pose[..., :2])
    azimuth = _closest_azimuth(pose, points, lens)
    axes = _axes(azimuth, _ELEVATION)
    lookat = _smooth(_middle(points, axes), calm)
    needed = _fitting_distance(points - lookat[:, None], axes, lens, _ELEVATION)
    # The widest need within reach of the filter, so that smoothing cannot push a robot out of the picture
    needed = maximum_filter1d(needed, size=2 * int(2 * calm) + 1, mode="nearest")
    distance = np.exp(np.maximum(_smooth(np.log(needed), calm), np.log(_CLOSEST)))
    return _still(lookat, distance, azimuth, _ELEVATION, lens)


def _isometric(pose: np.ndarray, lens: Lens, calm: float) -> CameraPath:
    """Frames the whole run from one place."""
    return _whole_run(pose, lens, _oblique_azimuth(pose), _ELEVATION)


def _top(pose: np.ndarray, lens: Lens, calm: float) -> CameraPath:
    """Frames the whole run from above, x to the right and y up as in the figures."""
    return _whole_run(pose, lens, 90.0, -90.0)


def _chase(pose: np.ndarray, lens: Lens, calm: float) -> CameraPath:
    """Follows behind the first follower, turning with it: what it tracks is ahead."""
    chased = min(1, pose.shape[1] - 1)
    lookat = _with_height(_smooth(pose[:, chased, :2], 0.3 * calm))
    azimuth = np.degrees(_smooth(pose[:, chased, 2], calm))
    frames = len(pose)
    return CameraPath(lookat, np.full(frames, 1.1), azimuth, np.full(frames, -22.0))


CAMERAS: dict[str, Callable[[np.ndarray, Lens, float], CameraPath]] = {
    "group": _group,
    "isometric": _isometric,
    "top": _top,
    "chase": _chase,
}


def _whole_run(pose: np.ndarray, lens: Lens, azimuth: float, elevation: float) -> CameraPath:
    axes = _axes(azimuth, elevation)
    points = _with_height(pose[..., :2]).reshape(1, -1, 3)
    lookat = _middle(points, axes)
    distance = np.maximum(_fitting_distance(points - lookat[:, None], axes, lens, elevation), _CLOSEST)
    frames = len(pose)
    return _still(np.repeat(lookat, frames, axis=0), np.repeat(distance, frames), azimuth, elevation, lens)


def _still(subject: np.ndarray, distance: np.ndarray, azimuth: float, elevation: float, lens: Lens) -> CameraPath:
    """Returns a path of one direction of view that looks a little beyond its subject (f, 3), see `_beyond`."""
    frames = len(subject)
    lookat = subject + _beyond(lens, elevation) * distance[:, None] * _ahead(_axes(azimuth, elevation))
    return CameraPath(lookat, distance, np.full(frames, azimuth), np.full(frames, elevation))


def _beyond(lens: Lens, elevation: float) -> float:
    """Returns how far beyond its subject the camera looks, over its distance, to see it lower than the middle.

    Looking k d ahead on the floor lowers the subject by k d s and brings it nearer by k d c, s and c the sine and
    cosine of the angle of view with the floor: k s = m v (1 - k c) for a share m of the picture's half height v.
    """
    s, c = abs(np.sin(np.radians(elevation))), np.cos(np.radians(elevation))
    lowered = _LOWERED * lens.vertical
    return float(lowered / (s + lowered * c))


def _closest_azimuth(pose: np.ndarray, points: np.ndarray, lens: Lens) -> float:
    """Returns the direction of view [deg] from which all robots are seen from nearest, on the mean over the film.

    The root travels to the right all the same; without much to gain it travels away, too, see `_oblique_azimuth`.
    """
    usual, some = _oblique_azimuth(pose), points[:: max(1, len(points) // _LOOKS)]
    found, least = usual, np.inf
    for turn in (0.0, *_TURNS):
        axes = _axes(usual + turn, _ELEVATION)
        needed = _fitting_distance(some - _middle(some, axes)[:, None], axes, lens, _ELEVATION)
        far = float(np.log(np.maximum(needed, _CLOSEST)).mean())
        if far < least - _GAIN:
            found, least = usual + turn, far
    return found


def _oblique_azimuth(pose: np.ndarray) -> float:
    """Returns a direction of view [deg] from which the root travels to the right and away."""
    way = pose[-1, 0, :2] - pose[0, 0, :2]
    if np.hypot(*way) < 0.3:  # it ends where it began: no direction of travel to speak of
        return 60.0
    return float(np.degrees(np.arctan2(way[1], way[0]))) + 55.0


def _axes(azimuth: float, elevation: float) -> np.ndarray:
    """Returns the camera's right, up and forward directions in the world, shape (3, 3), one a row."""
    a, e = np.radians(azimuth), np.radians(elevation)
    forward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    return np.stack([right, np.cross(right, forward), forward])


def _ahead(axes: np.ndarray) -> np.ndarray:
    """Returns the view's direction on the floor, shape (3,), from the camera's directions."""
    return np.array([-axes[0, 1], axes[0, 0], 0.0])


def _with_height(xy: np.ndarray) -> np.ndarray:
    """Returns points on the level of the axles, shape (..., 2) -> (..., 3)."""
    return np.concatenate([xy, np.full((*xy.shape[:-1], 1), 0.03)], axis=-1)


def _middle(points: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Returns the middle of the box, in the camera's directions, around each frame's points: (f, p, 3) -> (f, 3).

    The box is taken on the floor: to the right, and along the view's horizontal direction.
    """
    floor = np.stack([axes[0], _ahead(axes)])
    along = points @ floor.T
    middle = (along.min(axis=1) + along.max(axis=1)) / 2
    height = points[:, :1, 2]
    return np.asarray(middle @ floor + height * np.array([0.0, 0.0, 1.0]))


def _fitting_distance(offset: np.ndarray, axes: np.ndarray, lens: Lens, elevation: float) -> np.ndarray:
    """Returns how far the camera must stand to hold all points: offsets from its subject (f, p, 3) -> (f,).

    Looking k d beyond the subject (`_beyond`), a point right, up and depth from it falls at
    right/(d (1 - k c) + depth) of the picture, and at (up - m v d (1 - k c))/(d (1 - k c) + depth): linear in d.
    """
    right, up, depth = np.moveaxis(offset @ axes.T, -1, 0)
    v, nearer = lens.vertical, 1 - _beyond(lens, elevation) * np.cos(np.radians(elevation))
    across = (np.abs(right) + _ROBOT_REACH) / (_SIDE * lens.horizontal) - depth
    above = (up + _ROBOT_REACH - _ABOVE * v * depth) / ((_ABOVE + _LOWERED) * v)
    below = (_ROBOT_REACH - up - _BELOW * v * depth) / ((_BELOW - _LOWERED) * v)
    return np.asarray(np.maximum(np.maximum(above, below), across).max(axis=1) / nearer)


def _smooth(values: np.ndarray, frames: float) -> np.ndarray:
    """Returns values (f, ...) without what is faster than `frames`, as near to the robots at the ends as between.

    Both ends are continued point-symmetrically, so that motion goes on there: the camera neither starts late nor
    stays behind.
    """
    reach = min(int(4 * frames) + 1, len(values) - 1)
    if reach < 1:
        return values
    before = 2 * values[:1] - values[reach:0:-1]
    after = 2 * values[-1:] - values[-2 : -reach - 2 : -1]
    continued = np.concatenate([before, values, after])
    return np.asarray(gaussian_filter1d(continued, frames, axis=0, mode="nearest")[reach:-reach])
