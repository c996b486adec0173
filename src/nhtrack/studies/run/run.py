"""One scenario into one folder of results: recording, summary, figures, film, report."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.analysis.demand import predictions
from nhtrack.analysis.events import Event, find_events, sentences
from nhtrack.analysis.metrics import summary
from nhtrack.config.schema import Scenario, Video
from nhtrack.errors import RenderError, SimulationDiverged
from nhtrack.experiment.build import Experiment, build
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.load import load
from nhtrack.experiment.loop import Progress, Rollout
from nhtrack.experiment.recorder import FullRecorder, Shape
from nhtrack.experiment.stability import stability_warnings
from nhtrack.experiment.storage import storage
from nhtrack.files.folder import OutputError, claimed_folder, clear, fresh_folder, save_json
from nhtrack.laws.address import runs_as_python
from nhtrack.recording import Recording, make_recording
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation, stepped_scene
from nhtrack.simulation.scene import Scene
from nhtrack.studies.feasibility.run import reduced_plant, with_time

__all__ = [
    "Outcome",
    "OutputError",
    "Stage",
    "fresh_folder",
    "make_film",
    "run",
    "run_scenario",
    "run_warnings",
    "save_json",
    "simulate",
    "versions",
]

# What a stage of a run is called on the screen, and a way to report how far it is.
Stage = Callable[[str], Progress]

# MuJoCo's coordinates of one robot, about.
_COORDINATES = 9
# Robots from which on threads gain more than they cost.
_FLEET = 12

_VERSIONED = ("nhtrack", "mujoco", "numpy", "scipy", "dm-control", "array-api-compat")


@dataclass(frozen=True)
class Outcome:
    """What a run left behind.

    Attributes:
        recording: the run.
        summary: its figures, see `nhtrack.analysis.metrics.summary`, with the warnings.
        failure: why it ended early, or None.
        events: what went wrong on wheels.
        folder: where the files are, or None for a run in memory.
        files: the files written, in the order of writing.
        skipped: what was asked for and could not be made, with the reason.
    """

    recording: Recording
    summary: dict[str, Any]
    failure: SimulationDiverged | None
    events: tuple[Event, ...] = ()
    folder: Path | None = None
    files: tuple[Path, ...] = ()
    skipped: tuple[str, ...] = field(default=())


def run(scenario: Scenario | str | Path) -> Recording:
    """Returns the recording of a scenario, run in memory.

    Args:
        scenario: a loaded scenario, a scenario file, or the name of a bundled scenario.

    Raises:
        ScenarioError: everything wrong with the file.
        SimulationDiverged: the run left the region where its numbers mean anything.
    """
    outcome = simulate(scenario if isinstance(scenario, Scenario) else load(scenario))
    if outcome.failure is not None:
        raise outcome.failure
    return outcome.recording


@np.errstate(over="ignore", invalid="ignore")  # a twin that diverges leaves numbers too large to square
def simulate(scenario: Scenario, stage: Stage | None = None, folder: Path | None = None) -> Outcome:
    """Returns the outcome of a scenario and its ideal twin, in memory.

    The twin runs first, its own closed loop on the ideal integrator, through the same rollout with the same sampled
    law. A time scale left to be found is found before, and the recording carries the number.

    Args:
        scenario: what to run.
        stage: called with the name of each stage; returns what to report its progress to.
        folder: where rows may go that memory is too small for.

    Raises:
        RoomError: there is no room for the rows; nothing is run.
        FeasibilityError: `time: auto`, and no time scale fits.
    """
    compile_once(stage)
    if scenario.similarity.time == "auto":
        scenario = with_time(scenario, stage("time scale") if stage is not None else None)
    experiment = build(scenario)
    storage(_bytes(experiment), folder)  # told before anything runs
    drive = reduced_plant(scenario)
    ideal = IdealSimulation(
        experiment.network.names, drive, experiment.dt, experiment.scene.ground, size=experiment.size
    )
    twin = _roll(ideal, experiment, stage, "ideal twin", folder)
    if twin.interrupted:
        raise KeyboardInterrupt  # before the run proper began: there is nothing to keep
    if scenario.backend == "ideal":
        main, scene = twin, None
    else:
        scene = stepped_scene(experiment.scene)
        threads = (os.cpu_count() or 1) if len(experiment.scene.bodies) >= _FLEET else 1
        simulation = MujocoSimulation(
            scene, experiment.dt, threads=threads, spec=experiment.scene, size=experiment.size
        )
        main = _roll(simulation, experiment, stage, "MuJoCo", folder)
    recording = _recording(scenario, experiment, drive, main, twin, scene)
    events = find_events(recording)
    told = [*run_warnings(scenario, experiment, twin, drive), *sentences(events)]
    return Outcome(recording, summary(recording, events) | {"warnings": told}, main.failure, events)


def run_scenario(
    scenario: Scenario,
    out: Path | None = None,
    *,
    overwrite: bool = False,
    figures: bool = True,
    pdf: bool = False,
    video: bool = True,
    report: bool = True,
    processes: int = 1,
    stage: Stage | None = None,
) -> Outcome:
    """Runs a scenario and writes its results into a folder.

    `recording.nc` and `summary.json` always, `figures/`, `video.mp4` and, last of all, `report.html` unless told
    otherwise. A run that diverges or is interrupted keeps what it recorded; figures and a report are made of it, no
    film.

    Args:
        scenario: what to run.
        out: the folder; `runs/<name>-<n>/` with the first free n by default.
        overwrite: allow a folder that has files in it.
        figures: whether to draw figures.
        pdf: whether to draw them for print, see `nhtrack.plots.files.save_figure`.
        video: whether to make the film.
        report: whether to write the report.
        processes: how many draw the film, see `nhtrack.video.render`.
        stage: see `simulate`.

    Raises:
        OutputError: the folder has files in it, or cannot be written to; nothing is run.
    """
    with claimed_folder(scenario.name, out, overwrite) as folder:
        outcome = simulate(scenario, stage, folder)
    clear(folder)
    files = [outcome.recording.save(folder / "recording.nc"), save_json(folder / "summary.json", outcome.summary)]
    skipped: list[str] = []
    if figures:
        drawn, reason = _figures(outcome, folder, pdf=pdf)
        files += drawn
        skipped += reason
    if video and outcome.recording.outcome == "completed":
        film, reason = make_film(outcome.recording, scenario.video, folder / "video.mp4", stage, processes)
        files += film
        skipped += reason
    if report:
        files.append(_report(outcome, folder, skipped))
    return replace(outcome, folder=folder, files=tuple(files), skipped=tuple(skipped))


def run_warnings(scenario: Scenario, experiment: Experiment, twin: Rollout, drive: DiffDrive) -> tuple[str, ...]:
    """Returns what the gains and the ideal run say will go wrong on wheels, in sentences."""
    found = experiment.law.warnings()
    interpreted = experiment.law.kind.entry.interpreted
    if interpreted is not None:
        found = (*found, f"law {scenario.law.name!r} {runs_as_python(interpreted)}")
    if scenario.backend == "ideal":
        return found
    found = (*found, *stability_warnings(scenario, experiment, drive))
    if twin.failure is not None:
        found = (*found, f"the ideal twin diverged ({twin.failure}): from there on nothing is compared with it")
    return (*found, *predictions(scenario, experiment, twin, drive))


def _roll(
    simulation: IdealSimulation | MujocoSimulation,
    experiment: Experiment,
    stage: Stage | None,
    name: str,
    folder: Path | None,
) -> Rollout:
    progress = stage(name) if stage is not None else None
    return experiment.rollout(simulation, progress, recorder=FullRecorder(folder=folder))


def _bytes(experiment: Experiment) -> int:
    """Returns how many bytes the rows of a run and of its twin take."""
    robots = len(experiment.network)
    rows = Shape(len(experiment.inputs), 1, robots, True, 0, (robots, _COORDINATES), 0.0, 0.0, experiment.every)
    return 2 * rows.row_bytes * rows.total


def _bounds(twin: Rollout) -> tuple[float, float, float, float]:
    """Returns the rectangle of the floor that the robots of a run cover [m]."""
    pose = twin.variables["pose"]
    low, high = pose[..., :2].min(axis=(0, 1)), pose[..., :2].max(axis=(0, 1))
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _recording(
    scenario: Scenario, experiment: Experiment, drive: DiffDrive, main: Rollout, twin: Rollout, scene: Scene | None
) -> Recording:
    # A run that ended early has fewer rows than its twin; where the twin ended early, its pose is not known.
    shared = min(len(main.time), len(twin.time))
    ideal_pose = np.full_like(main.variables["pose"], np.nan)
    ideal_pose[:shared] = twin.variables["pose"][:shared]
    variables = main.variables | {"ideal_pose": ideal_pose}
    outcome = "interrupted" if main.interrupted else "completed"
    attributes = {
        "name": scenario.name,
        "backend": scenario.backend,
        "outcome": f"diverged: {main.failure}" if main.failure else outcome,
        "length_scale": experiment.similarity.length,
        "time_scale": experiment.similarity.time,
        "friction": scenario.physics.friction,
        "torque_limit": drive.motor.torque_limit,
        "no_load_speed": drive.motor.no_load_speed,
        "wheel_radius": drive.wheel_radius,
        "half_separation": drive.half_separation,
        "seed": scenario.seed,
        "control_rate": scenario.control_rate,
        "parents": {name: list(parents) for name, parents in scenario.parents.items()},
        "scenario": scenario.model_dump(mode="json"),
        "scene": replace(experiment.scene, bounds=_bounds(twin)).to_json(),
        "model_hash": scene.hash if scene else "",
        "versions": versions(),
    }
    attributes |= {} if experiment.law.kind.built_in else {"law": experiment.law.account}
    attributes |= _end(main.failure)
    return make_recording(main.time, experiment.network.names, variables, attributes, main.qpos)


def _end(failure: SimulationDiverged | None) -> dict[str, str | float]:
    """Returns what a divergence says of itself as attributes of the recording; none where there was none."""
    if failure is None:
        return {}
    return {"diverged_robot": failure.robot, "diverged_time": failure.time, "diverged_reason": failure.reason}


@cache
def versions() -> Mapping[str, str]:
    """Returns the versions of Python, of the package and of the libraries that move its numbers."""
    import importlib.metadata

    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in _VERSIONED}


def _figures(outcome: Outcome, folder: Path, *, pdf: bool) -> tuple[list[Path], list[str]]:
    """Returns the figures, or the reason why there are none: a run gone wild has numbers that no axis can show."""
    from nhtrack.plots import save_figures

    try:
        return save_figures(outcome.recording, folder / "figures", pdf=pdf, events=outcome.events), []
    except (ValueError, OverflowError) as error:
        return [], [f"no figures: {error}"]


def _report(outcome: Outcome, folder: Path, skipped: list[str]) -> Path:
    """Returns the report of a run, with the film in it if the folder has one."""
    from nhtrack.config.documentation import json_schema
    from nhtrack.studies.run.report import Extras, write_run_page

    film, mark = folder / "video.mp4", "no video: "
    reasons = [reason.removeprefix(mark) for reason in skipped if reason.startswith(mark)]
    if outcome.recording.outcome != "completed":
        reasons.append("the run did not complete")
    reason = next(iter(reasons), "none was asked for")
    extras = Extras(film if film.exists() else None, reason, json_schema())
    return write_run_page(outcome.recording, outcome.summary, folder / "report.html", extras)


def make_film(
    recording: Recording, wanted: Video, path: Path, stage: Stage | None = None, processes: int = 1
) -> tuple[list[Path], list[str]]:
    """Returns the film, or the reason why there is none: a machine without GL still gets its numbers.

    Args:
        recording: what to film.
        wanted: how.
        path: file to write, ending in .mp4.
        stage: see `simulate`.
        processes: how many draw it.
    """
    from nhtrack.video import render

    progress = stage("video") if stage is not None else None
    try:
        return [render(recording, path, **wanted.model_dump(), processes=processes, progress=progress)], []
    except RenderError as error:
        return [], [f"no video: {error}"]
