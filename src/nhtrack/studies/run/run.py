"""One scenario into one folder of results: recording, summary, figures, film, report."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from nhtrack.analysis.beforehand import beforehand, beforehand_of_law
from nhtrack.analysis.demand import predictions
from nhtrack.analysis.event import sentences
from nhtrack.analysis.events import find_events
from nhtrack.analysis.extent import Extent, extent_of, require_room
from nhtrack.analysis.metrics import summary
from nhtrack.arrays import row_blocks
from nhtrack.config.changes import ScenarioChanges, overrides_of
from nhtrack.config.scenario import Scenario
from nhtrack.errors import SimulationDiverged, noting
from nhtrack.experiment.build import Experiment, build, robot_of
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.leader_notes import leader_notes
from nhtrack.experiment.loop import Rollout
from nhtrack.experiment.recorder import KeepingRecorder
from nhtrack.experiment.robot_checks import robot_notes, robot_warnings
from nhtrack.files.folder import claimed_folder
from nhtrack.files.temporary import temporary_folder
from nhtrack.laws.address import entry_of, runs_as_python
from nhtrack.recording.source import Source, load
from nhtrack.recording.versions import versions
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.contact import tyre_compliance
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import Scene, stepped_scene
from nhtrack.simulation.sliding import firm_friction
from nhtrack.studies.feasibility.run import with_time
from nhtrack.studies.run.files import make_film, save_outcome, save_run_figures, write_run_report
from nhtrack.studies.run.keeping import InFile, InMemory, Keeping
from nhtrack.studies.run.result import DivergedError, Outcome
from nhtrack.terminal.progress import Observer, Stage, Tell, shown_progress

# Robots from which on threads gain more than they cost.
_FLEET = 12



def run(
    scenario: Source,
    *,
    seed: int | None = None,
    out: str | Path | None = None,
    overwrite: bool = False,
    figures: bool = True,
    pdf: bool = False,
    video: bool = True,
    report: bool = True,
    processes: int = 1,
    progress: bool | Observer | None = None,
    trust: bool = False,
    **changes: Unpack[ScenarioChanges],
) -> Outcome:
    """Returns what a run of a scenario left behind: its recording and its figures; files only where `out` is given.

    A run that is interrupted is returned as far as it went.

    Args:
        scenario: a bundled name, a scenario file, a YAML text, a recording, or a loaded scenario.
        seed: of the noise, in place of the scenario's.
        out: a folder for recording, summary, figures, film and report, as `nhtrack run` writes them.
        overwrite: allow a folder that has files in it.
        figures: whether to draw figures; this and what follows are of the folder.
        pdf: whether to draw them for print.
        video: whether to make the film.
        report: whether to write the report.
        processes: how many draw the film; a script that asks for more than one needs `if __name__ == "__main__":`.
        progress: whether to show how far it is, or a function of a stage, the work done and the whole of it; by
            default in terminals and notebooks.
        trust: whether to run a law of one's own that a recording brings along.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with the scenario and its changes.
        OutputError: the folder has files in it, or cannot be written to; nothing is run.
        DivergedError: the run left the region where its numbers mean anything; it has the outcome until then.
    """
    loaded = load(scenario, overrides_of(seed=seed), trust=trust, **changes)
    with shown_progress(progress) as stage:
        if out is None:
            outcome = simulate(loaded, stage)
        else:
            made: dict[str, Any] = {"figures": figures, "pdf": pdf, "video": video, "report": report}
            outcome = run_scenario(loaded, Path(out), overwrite=overwrite, **made, processes=processes, stage=stage)
    if outcome.failure is not None:
        raise DivergedError(outcome)
    return outcome


@np.errstate(over="ignore", invalid="ignore")  # a twin that diverges leaves numbers too large to square
def simulate(
    scenario: Scenario, stage: Stage | None = None, folder: Path | None = None, tell: Tell | None = None
) -> Outcome:
    """Returns the outcome of a scenario and its ideal twin.

    The twin runs first, its own closed loop on the ideal integrator, through the same rollout with the same sampled
    law. A time scale left to be found is found before, and the recording carries the number.

    Args:
        scenario: what to run.
        stage: called with the name of each stage; returns what to report its progress to.
        folder: where a large run may be until its recording is saved; None keeps any run in memory.
        tell: called with each warning there is before anything is run.

    Raises:
        RoomError: there is no room for the rows; nothing is run.
        FeasibilityError: `time: auto`, and no time scale fits.
    """
    compile_once(stage)
    robot = robot_of(scenario)
    if scenario.similarity.time == "auto":
        scenario = with_time(scenario, stage("time scale") if stage is not None else None, robot)
    experiment = build(scenario, robot)
    extent = extent_of(experiment, wheels=scenario.backend != "ideal")
    keeping = _keeping(scenario, experiment, extent, folder)
    if tell is not None:
        for warning in dict.fromkeys((*beforehand(scenario, experiment), *filter(None, [extent.sentence]))):
            tell(warning)
    drive, size = robot.plant, experiment.size
    ideal = IdealSimulation(experiment.network.names, drive, experiment.dt, experiment.scene.ground, size=size)
    twin = _roll(ideal, experiment, stage, "ideal twin", keeping.twin_recorder())
    if twin.interrupted and scenario.backend != "ideal":
        raise KeyboardInterrupt  # before the run proper began: there is nothing to keep
    import xarray  # noqa: F401 - takes a second, for which who interrupts the run need not wait

    predicted = run_warnings(scenario, experiment, twin, drive)  # nor for these
    if scenario.backend == "ideal":
        main, scene = twin, None
    else:
        scene = stepped_scene(experiment.scene, robot)
        threads = (os.cpu_count() or 1) if len(experiment.scene.bodies) >= _FLEET else 1
        simulation = MujocoSimulation(
            scene, experiment.dt, threads=threads, spec=experiment.scene, size=experiment.size
        )
        main = _roll(simulation, experiment, stage, "MuJoCo", keeping.recorder(twin))
    recording = keeping.recording(main, twin, _attributes(scenario, experiment, drive, main, twin, scene))
    events = find_events(recording)
    told = [*predicted, *sentences(events)]
    said = {"warnings": told, "notes": [*robot_notes(experiment), *leader_notes(scenario)]}
    return Outcome(recording, summary(recording, events) | said, main.failure, events)


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
    tell: Tell | None = None,
) -> Outcome:
    """Runs a scenario and writes its results into a folder.

    `recording.nc` and `summary.json` always, `figures/`, `video.mp4` and, last of all, `report.html` unless told
    otherwise. A run that diverges keeps what it recorded; figures and a report are made of it, no film. Of one that is
    interrupted there are recording and summary only: who interrupts does not want to wait.

    Args:
        scenario: what to run.
        out: the folder; `runs/<name>-<n>/` with the first free n by default.
        overwrite: allow a folder that has files in it.
        figures: whether to draw figures.
        pdf: whether to draw them for print, see `nhtrack.plots.files.save_figure`.
        video: whether to make the film.
        report: whether to write the report.
        processes: how many draw the film, see `nhtrack.video.render_film`.
        stage: see `simulate`, and so for the next.
        tell: what to do with warnings before the run.

    Raises:
        OutputError: the folder has files in it, or cannot be written to; nothing is run.
    """
    with claimed_folder(scenario.name, out, overwrite) as folder:
        with temporary_folder(folder) as spare:
            outcome = simulate(scenario, stage, spare, tell)
            files = save_outcome(outcome, folder)
        if outcome.recording.outcome == "interrupted":
            figures = video = report = False
        skipped: list[str] = []
        with noting(f"the run is whole in {files[0]}: `nhtrack plot` and `nhtrack render` draw it"):
            if figures:
                drawn, skipped = save_run_figures(outcome, folder, pdf=pdf)
                files += drawn
            if video and outcome.failure is None:
                film, reason = make_film(outcome.recording, scenario.video, folder / "video.mp4", stage, processes)
                files += film
                skipped += reason
            if report:
                files.append(write_run_report(outcome, folder, skipped))
    return replace(outcome, folder=folder, files=tuple(files), skipped=tuple(skipped))


def run_warnings(scenario: Scenario, experiment: Experiment, twin: Rollout, drive: DiffDrive) -> tuple[str, ...]:
    """Returns what the gains and the ideal run say will go wrong on wheels, in sentences."""
    found = beforehand_of_law(scenario, experiment)
    interpreted = entry_of(experiment.law.kind).interpreted
    if interpreted is not None:
        found = (*found, f"law {scenario.law.name!r} {runs_as_python(interpreted)}")
    if scenario.backend == "ideal":
        return found
    found = (*found, *robot_warnings(scenario, experiment))
    if twin.failure is not None:
        found = (*found, f"the ideal twin diverged ({twin.failure}): from there on nothing is compared with it")
    return (*found, *predictions(scenario, experiment, twin, drive))


def _keeping(scenario: Scenario, experiment: Experiment, extent: Extent, folder: Path | None) -> Keeping:
    """Returns what keeps the rows of a run, where there is room for them."""
    ideal, robots = scenario.backend == "ideal", experiment.network.names
    if require_room(extent, folder) and folder is not None:
        return InFile(robots, folder, ideal=ideal)
    return InMemory(robots)


def _roll(
    simulation: IdealSimulation | MujocoSimulation,
    experiment: Experiment,
    stage: Stage | None,
    name: str,
    recorder: KeepingRecorder,
) -> Rollout:
    return experiment.rollout(simulation, stage(name) if stage is not None else None, recorder=recorder)


def _bounds(twin: Rollout) -> tuple[float, float, float, float]:
    """Returns the rectangle of the floor that the robots of a run cover [m]."""
    pose, ends = twin.variables["pose"], []
    for part in row_blocks(len(pose), 8 * math.prod(pose.shape)):
        places = pose[part][..., :2]
        ends += [places.min(axis=(0, 1)), places.max(axis=(0, 1))]
    low, high = np.min(ends, axis=0), np.max(ends, axis=0)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _attributes(
    scenario: Scenario, experiment: Experiment, drive: DiffDrive, main: Rollout, twin: Rollout, scene: Scene | None
) -> dict[str, Any]:
    """Returns what a recording says of its run."""
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
        "trusted_friction": _trusted_friction(scene),
        "seed": scenario.seed,
        "control_rate": scenario.control_rate,
        "parents": {name: list(parents) for name, parents in scenario.parents.items()},
        "scenario": scenario.model_dump(mode="json"),
        "scene": replace(experiment.scene, bounds=_bounds(twin)).to_json(),
        "model_hash": scene.hash if scene else "",
        "versions": versions(),
    }
    attributes |= {} if experiment.law.kind.built_in else {"law": experiment.law.account}
    return attributes | _end(main.failure)


def _trusted_friction(scene: Scene | None) -> float:
    """Returns up to which friction tyres that slide bear what Coulomb's law gives them; none on MuJoCo's contacts."""
    if scene is None or scene.spec.contact != "stiff":
        return 0.0
    return firm_friction(tyre_compliance(scene))


def _end(failure: SimulationDiverged | None) -> dict[str, str | float]:
    """Returns what a divergence says of itself as attributes of the recording; none where there was none."""
    if failure is None:
        return {}
    return {"diverged_robot": failure.robot, "diverged_time": failure.time, "diverged_reason": failure.reason}
