"""Commands that are killed or interrupted: nobody outlives them, and what they leave is whole or gone with the next."""

from __future__ import annotations

import json
import math
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import imageio_ffmpeg
import pandas as pd
import pytest
from ruamel.yaml import YAML

from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.run.run import run_scenario

pytestmark = pytest.mark.slow

PATIENCE = 5.0  # [s] in which everything that worked for a command has to be gone
SCENARIO = """\
name: case
duration: 4
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.05, u_theta: "0.2*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-0.3, 0, 0]}}
law: {name: published, kp: 1, kd: 3, ke: 0.3, k: 5}
video: {size: [128, 96], fps: 30, quality: draft}
"""
CAMPAIGN = """\
name: case
duration: 12
backend: ideal
similarity: {length: 0.1, time: 0.9}
laws: {universal: {name: universal}, k: {name: kanayama}}
families: [sinus, random]
starts: {count: 6, seed: 3}
arrival: {last: 3}
"""
COMMANDS = {
    "run": "run case.yaml --out out --force",
    "render": "render recording.nc --out out/film.mp4 --force --processes 2 --fps 40",
    "compare": "compare case.yaml kanayama --out out --force",
    "tune": "tune case.yaml --budget 8 --out out/tuned.yaml --force",
    "campaign": "campaign campaign.yaml --out out --no-report",
}
# What makes them last longer than anybody waits.
LONGER = {
    "run": "--set duration=600",
    "render": "--fps 100 --speed 0.1",
    "compare": "--set duration=600",
    "tune": "--budget 4096",
    "campaign": "--set starts.count=20000",
}
WHOLE: Mapping[str, Callable[[Path], object]] = {
    ".nc": Recording.load,
    ".json": lambda path: json.loads(path.read_text()),
    ".yaml": lambda path: YAML(typ="safe").load(path),
    ".parquet": pd.read_parquet,
    ".csv": pd.read_csv,
    ".mp4": lambda path: imageio_ffmpeg.count_frames_and_secs(str(path)),
    ".html": lambda path: path.read_text().rstrip().endswith("</html>") or pytest.fail(f"{path} is not whole"),
    ".png": lambda path: b"IEND" in path.read_bytes()[-12:] or pytest.fail(f"{path} is not whole"),
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Returns the working directory, with what commands begin with."""
    monkeypatch.chdir(tmp_path)
    Path("case.yaml").write_text(SCENARIO)
    Path("campaign.yaml").write_text(CAMPAIGN)
    return tmp_path


def begin(command: str, *more: str) -> subprocess.Popen[str]:
    """Returns a command that has begun, in a session of its own."""
    words = [sys.executable, "-m", "nhtrack", *COMMANDS[command].split(), *more]
    if command == "render" and not Path("recording.nc").exists():
        run_scenario(load("case.yaml"), Path("whole"), figures=False, video=False, report=False)
        Path("whole/recording.nc").rename("recording.nc")
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)


def of_session(leader: int) -> list[int]:
    """Returns the processes of a session that are still there, but for those that wait to be buried."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, _, session = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            except OSError:
                continue
            found += [int(entry.name)] if int(session) == leader and state != "Z" else []
    return found


def interrupted(process: subprocess.Popen[str], how: signal.Signals) -> str:
    """Interrupts a command, twice if it does not hear it, and returns what it says.

    Python ignores what a signal raises while something is finalised; whoever presses Ctrl-C then presses it again.
    """
    os.kill(process.pid, how)
    try:
        return process.communicate(timeout=2 * PATIENCE)[1]
    except subprocess.TimeoutExpired:
        os.kill(process.pid, how)
        return process.communicate()[1]


def wait_for_the_last_of(leader: int) -> None:
    """Waits until no process of a session is left."""
    ended = time.monotonic()
    while of_session(leader):
        assert time.monotonic() - ended < PATIENCE, of_session(leader)
        time.sleep(0.05)


def files() -> list[Path]:
    """Returns the files there are; folders may vanish while they are looked at."""
    return [Path(folder, name) for folder, _, names in os.walk("out") for name in names]


def hidden() -> list[Path]:
    return [path for path in Path().rglob(".*")]


def changes(process: subprocess.Popen[str], count: int, patience: float = math.inf) -> None:
    """Waits until files have come or gone so many times, the process has ended, or so many seconds are over."""
    before, end = files(), time.monotonic() + patience
    while count and process.poll() is None and time.monotonic() < end:
        time.sleep(0.005)
        now = files()
        count -= now != before
        before = now


@pytest.mark.parametrize("command", COMMANDS)
def test_what_a_killed_command_leaves(command: str) -> None:
    moment = random.randint(1, 8)
    print(f"killed at change {moment}")
    process = begin(command)
    changes(process, moment)
    process.kill()
    process.communicate()
    wait_for_the_last_of(process.pid)
    for file in files():
        if not any(part.startswith(".") for part in file.parts):
            WHOLE[file.suffix](file)
    following = begin(command)
    _, said = following.communicate()
    assert following.returncode == 0, said
    assert hidden() == []
    assert files() != []


@pytest.mark.parametrize(
    ("command", "how"),
    [
        ("run", signal.SIGINT), ("run", signal.SIGTERM), ("render", signal.SIGTERM), ("compare", signal.SIGINT),
        ("tune", signal.SIGINT), ("campaign", signal.SIGINT), ("campaign", signal.SIGTERM),
    ],
)  # fmt: skip
def test_an_interrupted_command_says_so_in_a_line(command: str, how: signal.Signals) -> None:
    process = begin(command, *LONGER[command].split())
    changes(process, 1, random.uniform(3.0, 8.0))
    said = interrupted(process, how)
    assert process.returncode == 130
    assert said.strip().splitlines()[-1].startswith("interrupted")
    assert "Traceback" not in said
    wait_for_the_last_of(process.pid)
    assert hidden() == []
