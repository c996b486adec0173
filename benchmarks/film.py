"""Prints how many frames a second a film is made at, with ghosts and trails, written as MP4.

    python benchmarks/film.py [--size 640x480] [--robots 4 64] [--processes 1 2]

The run is made of formulas: robots wind their ways in rows, on a floor so slippery that their ideal twins are a hand's
breadth away and drawn as ghosts from the first frame on. `start` is the time to the first frame, `frames/s` counts
from there. OpenGL is whatever this machine has; the first line names it. Run it on an idle machine.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

import numpy as np

from nhtrack import gl, video
from nhtrack.recording import Recording, make_recording
from nhtrack.simulation.scene import SceneSpec

SECONDS, APART = 8.0, 0.15  # [s] of film at 30 frames a second; [m] from a robot to its twin


def winding(n: int) -> Recording:
    """Returns a run of n robots in rows, each on a sine, with their twins beside them."""
    time_axis = np.arange(0, SECONDS + 0.005, 0.01)
    across = int(np.ceil(np.sqrt(n)))
    row, column = np.divmod(np.arange(n), across)
    x = 0.1 * time_axis[:, None] - 0.5 * row
    y = 0.5 * column + 0.1 * np.sin(0.8 * time_axis[:, None] + row)
    theta = np.arctan2(0.08 * np.cos(0.8 * time_axis[:, None] + row), 0.1)
    pose = np.stack(np.broadcast_arrays(x, y, theta), axis=-1)
    twin = pose + np.array([0.0, APART, 0.0])
    twist = np.stack(np.broadcast_arrays(np.hypot(0.1, 0.05), 0.0 * x, np.gradient(theta, 0.01, axis=0)), axis=-1)
    names = tuple(f"r{k}" for k in range(n))
    error = np.full_like(pose, np.nan)
    error[:, 1:] = 0.05
    use = np.broadcast_to(0.5 + 0.5 * np.sin(time_axis)[:, None, None], (*x.shape, 2))
    variables = {"pose": pose, "ideal_pose": twin, "twist": twist, "error": error, "friction_utilisation": use}
    attributes = {
        "name": f"{n} robots", "backend": "mujoco", "outcome": "completed", "scene": SceneSpec(names).to_json(),
        "parents": {name: list(names[:1]) if k else [] for k, name in enumerate(names)},
    }  # fmt: skip
    return make_recording(time_axis, names, variables, attributes)


def pace(recording: Recording, path: Path, quality: str, size: tuple[int, int], processes: int) -> tuple[float, float]:
    """Returns the time to the first frame [s], and frames per second from there to the finished file."""
    marks = [time.perf_counter()]
    video.render_film(
        recording, path, quality=quality, size=size, processes=processes,
        progress=lambda *_: marks.append(time.perf_counter()),
    )  # fmt: skip
    return marks[1] - marks[0], (len(marks) - 2) / (time.perf_counter() - marks[1])


def main() -> None:
    verbatim = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=verbatim)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--robots", type=int, nargs="+", default=[4, 64])
    parser.add_argument("--processes", type=int, nargs="+", default=[1, os.cpu_count() or 1])
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    print(f"{gl.find_backend().renderer}, {given.size}, MP4, {os.cpu_count()} cores")
    print("robots  quality  processes  start [s]  frames/s")
    with tempfile.TemporaryDirectory() as folder:
        for n in given.robots:
            recording = winding(n)
            for quality in video.QUALITIES:
                for processes in given.processes:
                    start, rate = pace(recording, Path(folder) / "film.mp4", quality, (width, height), processes)
                    print(f"{n:6d}  {quality:7s}  {processes:9d}  {start:9.1f}  {rate:8.1f}", flush=True)


if __name__ == "__main__":
    main()
