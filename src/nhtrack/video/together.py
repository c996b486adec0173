"""Runs of several laws as one recording, for a film in which their followers drive together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from nhtrack.presentation.shown import Room
from nhtrack.recording import Recording, make_recording
from nhtrack.simulation.scene import SceneSpec

_ROOT = "leader"  # no follower is called so here: their names end in labels


def together(runs: Mapping[str, Recording], room: Room) -> Recording:
    """Returns a recording in which the root drives once and the followers of all runs drive with it.

    The root is called `leader` and is that of the first run that went as far as any. Followers are called
    `<follower>-<label>` and have the colour of their run: the second of the palette for the first run, and so on. A
    follower stays where its run ended, and where it left the room until it is back. Attribute `groups` names those of
    each run.

    Args:
        runs: by their labels, of one scenario under several laws: same robots, same times as far as they go.
        room: part of the floor that is shown; every robot starts in it.
    """
    root = max(runs.values(), key=lambda run: len(run.time))
    rows = {label: _shown_rows(run, room, len(root.time)) for label, run in runs.items()}
    parts = [_followers(run, rows[label]) for label, run in runs.items()]
    variables = {
        name: np.concatenate([root[name].values[:, :1], *(part[name] for part in parts)], axis=1) for name in parts[0]
    }
    names = {label: [f"{name}-{label}" for name in root.followers] for label in runs}
    spec = _scene(root, names)
    attributes: dict[str, Any] = {name: getattr(root, name) for name in ("backend", "length_scale", "time_scale")}
    attributes["scenario"] = root.scenario.model_dump(mode="json")
    attributes |= {"name": f"{root.name}: {len(runs)} laws", "outcome": "completed", "versions": root.versions}
    attributes |= {"scene": spec.to_json(), "groups": names, "parents": _parents(root, runs)}
    return make_recording(root.time, spec.robots, variables, attributes, _qpos(runs, root, rows))


def _shown_rows(run: Recording, room: Room, length: int) -> np.ndarray:
    """Returns which row of a run shows each follower in each row of the film, shape (length, n - 1).

    That is the last one so far in which it was in the room.
    """
    x, y = np.moveaxis(run["pose"].values[:, 1:, :2], -1, 0)
    x_min, x_max, y_min, y_max = room
    inside = (x >= x_min) & (x <= x_max) & (y >= y_min) & (y <= y_max)
    rows = np.maximum.accumulate(np.where(inside, np.arange(len(inside))[:, None], 0), axis=0)
    return np.asarray(rows[np.minimum(np.arange(length), len(rows) - 1)])


def _followers(run: Recording, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Returns what the film shows of a run's followers, shapes (length, n - 1, ...).

    Wheels stand where a follower is held. Its error is what it was all the same, NaN once its run ended or it was lost.
    """
    driving = rows == np.arange(len(rows))[:, None]
    error = np.full((*rows.shape, 3), np.nan)
    error[: len(run.time)] = run["error"].values[:, 1:]
    error[~np.isfinite(error)] = np.nan
    pose, speed = (_taken(run[name].values[:, 1:], rows) for name in ("pose", "wheel_speed"))
    return {"pose": pose, "error": error, "wheel_speed": np.where(driving[..., None], speed, 0.0)}


def _taken(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Returns values (t, k, ...) of k followers in rows (length, k) of their own, shape (length, k, ...)."""
    return np.asarray(values[rows, np.arange(rows.shape[1])])


def _scene(root: Recording, names: Mapping[str, list[str]]) -> SceneSpec:
    """Returns the scene of all followers; they do not touch, since each run was alone on its floor."""
    robots = (_ROOT, *(name for followers in names.values() for name in followers))
    colours = (0, *(place for place, followers in enumerate(names.values(), start=1) for _ in followers))
    return replace(root.scene, robots=robots, robot_contact=False, colours=colours)


def _parents(root: Recording, labels: Iterable[str]) -> dict[str, list[str]]:
    """Returns who tracks whom: within each run as it was, and the one root."""
    parents: dict[str, list[str]] = {_ROOT: []}
    for label in labels:
        called = {name: f"{name}-{label}" for name in root.followers} | {root.robots[0]: _ROOT}
        parents |= {called[name]: [called[parent] for parent in root.parents[name]] for name in root.followers}
    return parents


def _qpos(runs: Mapping[str, Recording], root: Recording, rows: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """Returns MuJoCo's coordinates of all robots: each is a copy of one model, its coordinates one block."""
    if any("qpos" not in run.dataset for run in runs.values()):
        return None
    bodies = len(root.scene.bodies)
    blocks = {label: run["qpos"].values.reshape(len(run.time), bodies, -1) for label, run in runs.items()}
    first = bodies - len(root.followers)  # 0 for a virtual root, which has no coordinates
    of_root = root["qpos"].values.reshape(len(root.time), bodies, -1)[:, :first]
    parts = [_taken(block[:, first:], rows[label]) for label, block in blocks.items()]
    return np.concatenate([of_root, *parts], axis=1).reshape(len(root.time), -1)
