"""Compares runs of the bundled scenarios with the array code: `python tests/reference/compare_recordings.py --help`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # where the package `reference` is

from nhtrack.assets import bundled_scenarios
from nhtrack.config.scenario import Scenario
from nhtrack.experiment.load import load
from nhtrack.studies.feasibility.run import with_time
from nhtrack.studies.run.run import simulate
from reference.comparison import HEADING, POSITION, Comparison, arrays_of, compare, shortened
from reference.run import Backend, run_reference

NUDGE = 1e-12  # [m]


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the comparisons and returns the exit code: 1 if a pose differs without a switch that explains it."""
    given = _parser().parse_args(arguments)
    wrong = []
    for name in given.names or bundled_scenarios():
        for backend in given.backend or (load(name).backend,):
            scenario = load(name).model_copy(update={"backend": backend})
            if not _one(name, scenario, given):
                wrong.append(f"{name} on {backend}")
    if given.only_save:
        return 0
    print(f"\ndifferent: {', '.join(wrong)}" if wrong else "\nall the same")
    return 1 if wrong else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="scenarios, all bundled ones by default")
    parser.add_argument("--seconds", type=float, help="only the first so many seconds on the robots' clock")
    parser.add_argument("--backend", action="append", choices=get_args(Backend), help="instead of the scenario's own")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="where to keep the runs of the array code")
    parser.add_argument("--from", type=Path, metavar="FOLDER", dest="source", help="take kept runs from there")
    parser.add_argument("--only-save", action="store_true", help="compare nothing")
    parser.add_argument(
        "--nudged", action="store_true", help=f"run the array code once more from {NUDGE:g} m beside its start"
    )
    return parser


def _one(name: str, scenario: Scenario, given: argparse.Namespace) -> bool:
    """Prints the comparison of one scenario and returns whether the motion is the same."""
    print(f"\n{name} on {scenario.backend}", flush=True)
    started = time.perf_counter()
    kept = None if given.source is None else _file(given.source, name, scenario)
    if kept is not None and kept.is_file():
        with np.load(kept) as stored:
            reference = dict(stored)
        scenario = _at_time(scenario, float(reference.pop("time_scale")))
        origin = "kept"
    else:
        scenario = with_time(scenario)
        periods = None if given.seconds is None else max(1, round(given.seconds * scenario.control_rate))
        reference, origin = run_reference(scenario, periods), "run"
        if given.nudged:
            reference["nudged_pose"] = run_reference(scenario, periods, nudge=NUDGE)["pose"]
    print(f"  array code: {len(reference['time']) - 1} periods, {origin} in {time.perf_counter() - started:.1f} s")
    if given.save is not None:
        given.save.mkdir(parents=True, exist_ok=True)
        file = _file(given.save, name, scenario)
        np.savez(file, time_scale=np.array(scenario.similarity.time_scale), **reference)
    robots, nudged = tuple(scenario.parents), reference.pop("nudged_pose", None)
    if nudged is not None:
        _print_nudged(reference, nudged)
    if given.only_save:
        return True
    periods = len(reference["time"]) - 1
    if given.seconds is not None:
        periods = min(periods, max(1, round(given.seconds * scenario.control_rate)))
        scenario = shortened(scenario, periods)
    started = time.perf_counter()
    found = arrays_of(simulate(scenario).recording)
    print(f"  compared:   {len(found['time']) - 1} periods, run in {time.perf_counter() - started:.1f} s")
    comparison = compare(reference, found, robots, cut=given.seconds is not None)
    _print(comparison)
    return comparison.is_same


def _file(folder: Path, name: str, scenario: Scenario) -> Path:
    return folder / f"{name.replace('/', '__')}.{scenario.backend}.npz"


def _at_time(scenario: Scenario, time_scale: float) -> Scenario:
    return scenario.model_copy(update={"similarity": scenario.similarity.model_copy(update={"time": time_scale})})


def _print_nudged(reference: dict[str, np.ndarray], nudged: np.ndarray) -> None:
    rows = min(len(nudged), len(reference["time"]))
    apart = np.hypot(*np.moveaxis((nudged[:rows] - reference["pose"][:rows])[..., :2], -1, 0)).max(axis=1)
    beyond = np.flatnonzero(apart > POSITION)
    when = f", beyond {POSITION:g} m from {reference['time'][beyond[0]]:.2f} s on" if len(beyond) else ""
    print(f"  array code from {NUDGE:g} m beside its start: {apart.max():.1e} m from itself{when}")


def _print(comparison: Comparison) -> None:
    for quantity, largest in comparison.largest.items():
        where = f"  at {largest.time:.2f} s {largest.robot}" if largest.size else ""
        print(f"    {quantity:32s}{largest.size:10.2e}{where}")
    if comparison.ends is not None:
        print("  one run ends early: array code at {:.2f} s, the other at {:.2f} s".format(*comparison.ends))
    if comparison.exceeded is not None:
        print(f"  beyond {POSITION:g} m or {HEADING:g} rad from {comparison.exceeded:.2f} s on")
    if comparison.switch is not None:
        switch = comparison.switch
        print(
            f"  BRANCH SWITCH at {switch.time:.2f} s: the input of {switch.robot} differs by {switch.jump:.2e} in one"
            f" period; until then {comparison.position:.1e} m and {comparison.heading:.1e} rad"
        )
    print("  same" if comparison.is_same else "  DIFFERENT")


if __name__ == "__main__":
    sys.exit(main())
