"""Commands that are killed or interrupted: nobody outlives them, and what they leave is whole or gone with the next.

NHTRACK_KILLS says how often each is, and NHTRACK_KILLS_SEED at which moments.
"""

from __future__ import annotations

import json
import os
import random
import resource
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
ANSWER = 2.0  # [s] of a processor that a command may still take before it ends, on a machine that may be busy
LONGEST = 5.0  # [s] of a processor after which a command is stopped, unless it has ended
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
SWEEP = """\
name: case
base: case.yaml
set: {backend: ideal}
axes: {law.k: [4, 5, 6], control_rate: [50, 62.5, 100, 125]}
"""
COMMANDS = {
    "run": "run case.yaml --out out --force",
    "render": "render recording.nc --out out/film.mp4 --force --processes 2 --fps 40",
    "compare": "compare case.yaml kanayama --out out --force",
    "tune": "tune case.yaml --budget 8 --out out/tuned.yaml --force",
    "campaign": "campaign campaign.yaml --out out --no-report",
    "sweep": "sweep sweep.yaml --out out",
}
HOWS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
KILLS = int(os.environ.get("NHTRACK_KILLS", "3"))  # of each command
SEED = int(os.environ.get("NHTRACK_KILLS_SEED", random.randrange(10**6)))
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
    Path("sweep.yaml").write_text(SWEEP)
    return tmp_path


def begin(command: str, *more: str, largest: int | None = None) -> subprocess.Popen[str]:
    """Returns a command that has begun, in a session of its own, and hears Ctrl-C however this one was begun.

    Args:
        command: one of `COMMANDS`.
        *more: words to add.
        largest: of the files that it may write [bytes].
    """

    def prepare() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if largest is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    words = [sys.executable, "-m", "nhtrack", *COMMANDS[command].split(), *more]
    pipe = subprocess.PIPE
    return subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, start_new_session=True, preexec_fn=prepare)


def listens(process: subprocess.Popen[str]) -> bool:
    """Returns whether a process has come as far as to hear SIGTERM; before, Python itself answers."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)


def spent(process: subprocess.Popen[str]) -> float:
    """Returns the seconds of a processor that a process has taken."""
    numbers = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, numbers[11:15])) / os.sysconf("SC_CLK_TCK")


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


def stop(process: subprocess.Popen[str], how: signal.Signals) -> tuple[float, str]:
    """Stops a command once, Ctrl-C with all that works for it; returns the seconds it took to end, and what it says."""
    before, waited = spent(process), os.times()
    if how == signal.SIGINT:
        os.killpg(process.pid, how)
    else:
        os.kill(process.pid, how)
    try:
        said = process.communicate(timeout=20 * PATIENCE)[1]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    now = os.times()
    took = now.children_user + now.children_system - waited.children_user - waited.children_system - before
    return min(took, now.elapsed - waited.elapsed), said


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


def reach(process: subprocess.Popen[str], changes: int, seconds: float) -> None:
    """Waits until files have come or gone so often, a command has taken so long or has ended, and hears signals."""
    before = files()
    while process.poll() is None and (not listens(process) or (changes and spent(process) < seconds)):
        time.sleep(0.005)
        now = files()
        changes -= now != before
        before = now


def check_what_is_there() -> None:
    """Opens every file that has a good name."""
    for file in files():
        if not any(part.startswith(".") for part in file.parts):
            WHOLE[file.suffix](file)


@pytest.mark.parametrize("command", COMMANDS)
def test_what_a_command_leaves_that_is_stopped(command: str, record_property: Callable[[str, object], None]) -> None:
    """Stops a command time and again, at random moments, at some of them while it writes."""
    chance = random.Random(f"{SEED} {command}")
    print(f"NHTRACK_KILLS_SEED={SEED}")
    if command == "render":
        run_scenario(load("case.yaml"), Path("whole"), figures=False, video=False, report=False)
        Path("whole/recording.nc").rename("recording.nc")
    took = list[float]()
    for kill in range(KILLS):
        how, changes, seconds = HOWS[kill % len(HOWS)], chance.randint(1, 12), chance.uniform(0.2, LONGEST)
        process = begin(command)
        reach(process, changes, seconds)
        ended = process.poll() is not None
        seconds_to_end, said = (0.0, process.communicate()[1]) if ended else stop(process, how)
        print(f"{kill}: {how.name} after {seconds:.1f} s or {changes} changes: {process.returncode}", seconds_to_end)
        wait_for_the_last_of(process.pid)
        check_what_is_there()
        if ended:
            assert process.returncode == 0, said
        elif how != signal.SIGKILL:
            assert process.returncode in (130, 0, -how), said  # it may have been done, and about to end
            assert process.returncode != 130 or said.strip().splitlines()[-1].startswith("interrupted")
            assert "Traceback" not in said
            assert "Error" not in said
            assert seconds_to_end < ANSWER
            took.append(seconds_to_end)
    record_property("took", took)
    following = begin(command)
    _, said = following.communicate()
    assert following.returncode == 0, said
    assert hidden() == []
    assert files() != []
    if command == "sweep":
        undisturbed = begin(command, "--out", "whole", "--no-report", "--no-figures")
        assert undisturbed.communicate()[0]
        pd.testing.assert_frame_equal(*(pd.read_parquet(f"{folder}/runs.parquet") for folder in ("out", "whole")))


def test_a_sweep_without_room_says_so_and_goes_on_when_there_is() -> None:
    for largest, name in ((0, "sweep.json"), (8000, "parts/"), (None, "")):
        process = begin("sweep", "--processes", "1", "--no-report", "--no-figures", largest=largest)
        said = process.communicate()[1].strip().splitlines()
        assert process.returncode == (largest is not None)
        assert name in said[-1]
        assert largest is None or (said[-1].startswith("error: cannot write ") and "File too large" in said[-1])
        check_what_is_there()
        assert hidden() == []
    assert len(pd.read_parquet("out/runs.parquet")) == 12


@pytest.mark.parametrize(("largest", "told"), [(0, "recording.nc: File too large"), (500_000, "draw it")])
def test_a_file_that_cannot_be_written_is_told_and_what_was_before_it_kept(largest: int, told: str) -> None:
    process = begin("run", "--set", "duration=0.5", "--no-video", largest=largest)
    said = process.communicate()[1].strip().splitlines()
    assert process.returncode == 1
    assert said[-1].startswith("error: cannot write out/")
    assert said[-1].endswith(told)
    assert Path("out").exists() == Path("out/summary.json").exists() == (largest > 0)
    check_what_is_there()
    assert hidden() == []
