"""Recordings to film, films as `nhtrack.video` plans them, and what is looked for in their pictures."""

from __future__ import annotations

from functools import cache

import numpy as np

from nhtrack import se2
from nhtrack.colours import robot_colour
from nhtrack.simulation.scene import Scene, SceneSpec, make_scene
from nhtrack.video import camera, timeline
from recordings import HALF_SEPARATION, robot_names, synthetic_recording

SMALL = (320, 240)


def filmable(followers: int = 1, *, virtual: bool = False, **changes):
    scene = SceneSpec(robot_names(followers), virtual_root=virtual)
    return synthetic_recording(followers, backend="ideal", scene=scene.to_json(), **changes)


def pixels_of(picture: np.ndarray, place: int) -> np.ndarray:
    """Returns where (k, 2) a picture has the hue of a robot: x to the right, y down."""
    colour = robot_colour(place)
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], float)
    chroma = picture.astype(float) - picture.mean(axis=-1, keepdims=True)
    wanted -= wanted.mean()
    size = np.linalg.norm(chroma, axis=-1)
    alike = (chroma @ wanted) / np.maximum(size * np.linalg.norm(wanted), 1e-9)
    return np.argwhere((alike > 0.97) & (size > 60))[:, ::-1]


def projected(path: camera.CameraPath, frame: int, point: np.ndarray, fovy: float, size: tuple[int, int]) -> np.ndarray:
    """Returns where in the picture a point (3,) falls [pixels], by the pinhole's own formula."""
    a, e = np.radians([path.azimuth[frame], path.elevation[frame]])
    forward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    offset = point - path.lookat[frame] + path.distance[frame] * forward
    scale = size[1] / 2 / np.tan(np.radians(fovy) / 2) / (offset @ forward)
    return np.array(size) / 2 + scale * np.array([offset @ right, -(offset @ np.cross(right, forward))])


@cache
def shared_scene(text: str) -> Scene:
    """Returns a scene to look at: a `SceneRenderer` changes the one it draws."""
    return make_scene(SceneSpec.from_json(text))


def line_of(recording, fps=1):
    """Returns the timeline of a film as `video.frames` makes it."""
    return timeline.make_timeline(recording, shared_scene(recording.dataset.attrs["scene"]), fps, None)


def film(recording, size=SMALL, fps=1, name="group"):
    """Returns scene, timeline and camera path as `video.frames` makes them."""
    scene = make_scene(SceneSpec.from_json(recording.dataset.attrs["scene"]))
    line = timeline.make_timeline(recording, scene, fps, None)
    fovy = float(scene.model.vis.global_.fovy)
    return scene, line, camera.plan_camera(name, line.pose, fovy, size[0] / size[1], fps)


def parted(apart: float = 0.3, samples: int = 81, followers: int = 1, *, virtual: bool = False):
    """Returns a filmable run on wheels whose twins are so far [m] beside their robots."""
    scene = SceneSpec(robot_names(followers), virtual_root=virtual)
    recording = synthetic_recording(followers, samples=samples, scene=scene.to_json())
    pose = recording["pose"].values
    side = np.zeros(2)
    side[1] = apart
    twin = pose.copy()
    twin[..., :2] += np.asarray(se2.rotate(pose[..., 2], np.broadcast_to(side, (*pose.shape[:-1], 2))))
    recording.dataset["ideal_pose"] = (recording["pose"].dims, twin)
    recording.dataset.attrs["half_separation"] = HALF_SEPARATION
    return recording
