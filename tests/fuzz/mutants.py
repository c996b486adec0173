"""Mutants of all bundled files: a seed and a number give the same mutant everywhere.

`python tests/fuzz/mutants.py --count 1000 --seed 7` judges as many and says what it found.
"""

from __future__ import annotations

import argparse
import random
import re
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeAlias

import numpy as np

from nhtrack import assets
from nhtrack.analysis.time_scale import at_time
from nhtrack.cli.scenarios import _beforehand
from nhtrack.config.campaign import Campaign
from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import Sweep
from nhtrack.errors import FeasibilityError, NhtrackError, RefusedError, ScenarioError, SimulationDiverged
from nhtrack.experiment.load import LOADER, load_either, load_text
from nhtrack.recording import Recording, make_recording
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.run.run import simulate
from nhtrack.studies.sweep.run import plan_of

SECONDS = 5.0  # of the CPU, for one
MEGABYTES = 500.0  # at their most, for one
EVERY = 8  # so many mutants of which one is run where it is sound, as about a sixth are: one in fifty
_RUN, _STEPS, _ROBOTS = 0.1, 20_000, 64  # seconds, physics steps and robots that a run is cut to
# How often what takes long to read is taken, where another file is taken once.
_SHARES = {
    "stress/formation64": 0.2, "stress/formation1000": 0.01, "tour/lemniscate": 0.03, "campaign/bandwidth": 0.03,
    "sweep/friction_gain": 0.3,
}  # fmt: skip
_TOKEN = re.compile(r"[A-Za-z_]\w*|-?\d+\.?\d*(?:e[+-]?\d+)?|\s+|.", re.DOTALL)
_STRANGE = (
    "", "-1", "0", "1e400", "1e-320", "-0.0", ".nan", ".inf", "999999999999999999999", "null", "true", "t", "pi/2", "~",
    "[]", "{}", "''", '"', "'", "*a", "&a", "!!int x", "!!python/object", "<<", "? ", "- ", ": ", ", ", "#", "|", ">",
    "%", "@", "`", "\t", "\n", "\r", "\0", "\x1b[31m", "\u2028", "\ufeff", "\ud7ff", "\U0001f916", "..", "/dev/zero",
    "floor(9)**9**9", "1/(t - t)", "where(t, 1)", "(" * 40, "[" * 60, "- " * 60, "9" * 400, "a" * 3000,
)  # fmt: skip
_FORMULAS = (
    "0.2*cos(t)", "where(t < 2, 0.5, 0)", "0.3*sin(2*pi*t/20) - 0.1*exp(-t)", "sign(sin(t))*abs(1 - t)**0.5",
    "floor(t)/2 + max(0, 1 - t)", "1 if 2 < t <= 3 else -1/(1 + t)**2", "atan2(t, 1) % 2 // 1", "not t > 1 or t == 2",
)  # fmt: skip
_CSV = {
    "csv": "t,u_x,u_theta\n0,0.1,0\n1.5,0,0.2\n4,-0.1,0\n12,0,0\n",
    "velocities": "t,v,omega\n0,0,0\n1,0.2,0\n3,0.2,0.5\n12,0,0\n",
    "poses": "t,x,y,theta\n0,0,0,0\n2,0.4,0,0\n4,0.8,0,0\n12,2.4,0,0\n",
}
_SCENARIO = """name: mutant
duration: 10
leader:
  input: {given}
followers:
  - {{name: follower, parents: [leader], start: {{pose: [-1, 0, 0]}}}}
law: {{name: published, kp: 4, kd: 6, ke: 1, k: 5}}
"""


@dataclass(frozen=True)
class Mutant:
    """A changed file.

    Attributes:
        kind: `text`, `formula`, `columns`, `robot` or `recording`.
        origin: what it was made of.
        data: the file.
    """

    kind: str
    origin: str
    data: bytes


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant.

    Attributes:
        mutant: which.
        said: what is told of it, empty where it is sound.
        broken: how the contract is broken, empty where it is kept.
        seconds: of the CPU.
        megabytes: at their most, of a process that has judged nothing else.
        run: whether it was run.
    """

    mutant: Mutant
    said: str
    broken: str
    seconds: float
    megabytes: float = 0.0
    run: bool = False


@cache
def texts() -> tuple[tuple[str, str], ...]:
    """Returns all bundled scenarios, campaigns and sweeps."""
    names = [(name, assets.find_scenario(name)) for name in assets.bundled_scenarios()]
    names += [(name, assets.find_campaign(name)) for name in assets.bundled_campaigns()]
    names += [(name, assets.find_sweep(name)) for name in assets.bundled_sweeps()]
    return tuple((name, path.read_text(encoding="utf-8")) for name, path in names)


@cache
def robots() -> tuple[tuple[str, str], ...]:
    """Returns all bundled robots; their files may name meshes that are not beside a mutant."""
    return tuple((name, assets.find_robot(name).read_text(encoding="utf-8")) for name in assets.robots())


@cache
def recording() -> bytes:
    """Returns the file of a short run."""
    time, names = 0.01 * np.arange(50.0), ("leader", "follower")
    pose = np.random.default_rng(1).standard_normal((50, 2, 3))
    attributes = {
        "name": "mutant",
        "backend": "ideal",
        "outcome": "completed",
        "length_scale": 1.0,
        "time_scale": 1.0,
        "parents": {"leader": [], "follower": ["leader"]},
        "scenario": load_text(_SCENARIO.format(given="{u_x: 0.1, u_theta: 0}")).model_dump(mode="json"),
        "versions": {},
    }
    made = make_recording(time, names, {"pose": pose, "twist": pose, "ideal_pose": pose}, attributes)
    with tempfile.TemporaryDirectory() as folder:
        return made.save(Path(folder) / "recording.nc").read_bytes()


# -- changes ---------------------------------------------------------------------------------------


def _changed_text(text: str, dice: random.Random) -> str:
    """Returns a text with one to three changes by words, lines or letters."""
    for _ in range(dice.choice((1, 1, 2, 3))):
        text = dice.choice(_CHANGES)(text, dice)
    return text


def _word(text: str, dice: random.Random) -> str:
    words = _TOKEN.findall(text) or [""]
    words[dice.randrange(len(words))] = dice.choice((dice.choice(_STRANGE), dice.choice(words)))
    return "".join(words)


def _number(text: str, dice: random.Random) -> str:
    places = list(re.finditer(r"-?\d+\.?\d*", text))
    if not places:
        return _word(text, dice)
    at = dice.choice(places)
    factor = dice.choice((-1, 0, 1e-9, 1e-3, 10, 1e3, 1e9))
    value = dice.choice((str(float(at.group()) * factor), dice.choice(_STRANGE)))
    return text[: at.start()] + value + text[at.end() :]


def _line(text: str, dice: random.Random) -> str:
    lines = text.split("\n")
    at, other = dice.randrange(len(lines)), dice.randrange(len(lines))
    if dice.random() < 0.4:
        del lines[at]
    elif dice.random() < 0.5:
        lines.insert(at, lines[other])
    else:
        lines[at], lines[other] = lines[other], lines[at]
    return "\n".join(lines)


def _indent(text: str, dice: random.Random) -> str:
    lines = text.split("\n")
    at = dice.randrange(len(lines))
    lines[at] = dice.choice((" ", "  ", "\t")) + lines[at] if dice.random() < 0.5 else lines[at][1:]
    return "\n".join(lines)


def _cut(text: str, dice: random.Random) -> str:
    return text[: dice.randrange(len(text) + 1)]


def _letter(text: str, dice: random.Random) -> str:
    at = dice.randrange(len(text) + 1)
    return text[:at] + dice.choice((chr(dice.randrange(256)), *"{}[]:,-#&*!|>'\"%")) + text[at + dice.randrange(2) :]


_Change: TypeAlias = Callable[[str, random.Random], str]
_CHANGES: tuple[_Change, ...] = (_word, _word, _number, _number, _line, _indent, _cut, _letter)


def _changed_bytes(data: bytes, dice: random.Random) -> bytes:
    """Returns bytes with a bit turned, a stretch overwritten, removed or repeated, or cut."""
    at, length = dice.randrange(len(data)), dice.randrange(1, 64)
    change = dice.randrange(6)
    if change < 3:
        return data[:at] + bytes([data[at] ^ (1 << dice.randrange(8))]) + data[at + 1 :]
    if change == 3:
        return data[:at] + dice.randbytes(length) + data[at + length :]
    return data[:at] if change == 4 else data[:at] + data[at + length :]


def mutant(seed: int, number: int) -> Mutant:
    """Returns a mutant."""
    dice = random.Random(f"{seed} {number}")
    kind = dice.choices(("text", "formula", "columns", "recording", "robot"), (12, 5, 4, 1.2, 0.25))[0]
    if kind == "recording":
        return Mutant(kind, "recording", _changed_bytes(recording(), dice))
    if kind == "formula":
        origin = dice.choice(_FORMULAS)
        quoted = _changed_text(origin, dice).replace("'", "''")
        given = _SCENARIO.format(given=f"{{u_x: '{quoted}', u_theta: 0}}")
        return Mutant(kind, origin, _bytes(given))
    if kind == "columns":
        origin = dice.choice(tuple(_CSV))
        changed = _bytes(_changed_text(_CSV[origin], dice))
        return Mutant(kind, origin, _changed_bytes(changed, dice) if changed and dice.random() < 0.3 else changed)
    files = robots() if kind == "robot" else texts()
    origin, text = dice.choices(files, [_SHARES.get(name, 1.0) for name, _ in files])[0]
    return Mutant(kind, origin, _bytes(_changed_text(text, dice)))


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")


# -- judgement -------------------------------------------------------------------------------------


def judged(mutant: Mutant, folder: Path, whole: bool = False, run: bool = False) -> Verdict:
    """Returns what `nhtrack validate` says of a mutant, or what reading it says of a recording.

    Args:
        mutant: which.
        folder: an empty one to write it to.
        whole: whether what can be run is asked for its warnings, too, which takes longer than all the rest.
        run: whether what is sound is run, cut short.
    """
    before = _begun_memory()
    begin = time.process_time()
    said = broken = ""
    ran = False
    try:
        loaded = _read(mutant, folder)
        if whole and loaded is not None:
            _beforehand(loaded)
        if run and loaded is not None and (cut := _cut_short(loaded)) is not None:
            ran = True
            simulate(cut)
    except (FeasibilityError, RefusedError, SimulationDiverged) as error:
        said = str(error)
    except NhtrackError as error:
        said, broken = str(error), _untold(mutant, error)
    except Exception:  # this is what is looked for
        broken = said = traceback.format_exc()
    seconds, megabytes = time.process_time() - begin, _FRESH + _memory("VmHWM") - before
    if not broken and seconds > SECONDS:
        broken = f"took {seconds:.1f} s of the CPU"
    if not broken and megabytes > MEGABYTES:
        broken = f"took {megabytes:.0f} MB"
    return Verdict(mutant, said, broken, seconds, megabytes, ran)


def _cut_short(loaded: Scenario | Campaign | Sweep) -> Scenario | None:
    """Returns a scenario, or the first of a campaign or sweep, of a short run; None where that has too many robots."""
    if isinstance(loaded, Sweep):
        plan = plan_of(loaded)
        loaded = LOADER.load_tree(plan.tree, overrides=plan.changes(0))
    if isinstance(loaded, Campaign):
        timed = at_time(loaded, 1.0) if loaded.similarity.time == "auto" else loaded
        loaded = Cell(timed, next(iter(timed.laws)), timed.family_names[0]).scenario(0)
    if len(loaded.followers) >= _ROBOTS:
        return None
    scale = 1.0 if loaded.similarity.time == "auto" else loaded.similarity.time_scale
    shortest = min(_RUN, _STEPS * loaded.physics.timestep) / scale
    return loaded.model_copy(update={"duration": min(loaded.duration, shortest)})


_STATUS, _CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def _begun_memory() -> float:
    """Returns how much memory this process has now [MB], and forgets what it had at its most, where the system can."""
    if _CLEAR.exists():
        _CLEAR.write_text("5")
    return _memory("VmRSS")


def _memory(name: str) -> float:
    """Returns a figure of this process [MB], 0 where the system does not tell."""
    if not _STATUS.exists():
        return 0.0
    return int(re.findall(rf"{name}:\s*(\d+)", _STATUS.read_text())[0]) / 1024


_FRESH = _memory("VmRSS")  # of a process that has judged nothing yet, and keeps nothing of others


def _read(mutant: Mutant, folder: Path) -> Scenario | Campaign | Sweep | None:
    if mutant.kind == "recording":
        file = folder / "mutant.nc"
        file.write_bytes(mutant.data)
        found = Recording.load(file).scenario
        assert found.name == "mutant"
        return None
    file = folder / "mutant.yaml"
    if mutant.kind == "columns":
        (folder / "mutant.csv").write_bytes(mutant.data)
        file.write_text(_SCENARIO.format(given=f"{{{mutant.origin}: mutant.csv}}"))
    elif mutant.kind == "robot":
        (folder / "mutant.xml").write_bytes(mutant.data)
        file.write_text(_SCENARIO.format(given="{u_x: 0.1, u_theta: 0}") + "robot: mutant.xml\n")
    else:
        file.write_bytes(mutant.data)
    return load_either(file)


def _untold(mutant: Mutant, error: NhtrackError) -> str:
    """Returns how a message falls short of what it has to tell, empty where it does not."""
    if mutant.kind == "recording":
        return "" if "mutant.nc" in str(error) and "\n" not in str(error) else f"not told: {error}"
    if not isinstance(error, ScenarioError):
        return f"no fault of the file: {type(error).__name__}: {error}"
    # of a file without any content there is no line to tell
    placed = all(fault.line or "empty" in fault.message for fault in error.faults)
    return "" if placed else f"without a line: {error}"


def verdicts(seed: int, count: int, whole: bool = False) -> Iterable[Verdict]:
    """Yields what became of the mutants of a seed; see `judged`. Where the whole is judged, some are run."""
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            yield judged(mutant(seed, number), Path(folder), whole, whole and number % EVERY == 0)


def main() -> int:
    """Judges mutants, prints those that break the contract; returns how many do, 1 at most."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10**6)
    options = parser.parse_args()
    subprocess.run([sys.executable, "-m", "nhtrack.experiment.compile"], check=True)  # its memory is not what is judged
    kinds: dict[str, int] = {}
    faulty, broken, run, slowest, largest = 0, 0, 0, 0.0, 0.0
    for number, verdict in enumerate(verdicts(options.seed, options.count, whole=True)):
        kinds[verdict.mutant.kind] = kinds.get(verdict.mutant.kind, 0) + 1
        faulty += bool(verdict.said)
        run += verdict.run
        slowest, largest = max(slowest, verdict.seconds), max(largest, verdict.megabytes)
        if verdict.broken:
            broken += 1
            print(f"-- mutant {number} of seed {options.seed}, {verdict.mutant.origin}\n{verdict.broken}", flush=True)
    made = ", ".join(f"{count} of {kind}" for kind, count in sorted(kinds.items()))
    print(f"seed {options.seed}: {made}; {faulty} faulty, {run} run, {broken} break the contract")
    print(f"at most {slowest:.2f} s of the CPU and {largest:.0f} MB")
    return min(broken, 1)


if __name__ == "__main__":
    sys.exit(main())
