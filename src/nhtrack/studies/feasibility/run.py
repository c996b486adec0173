"""The time scale at which a scenario fits its robots, found from ideal runs alone."""

from __future__ import annotations

from typing import Unpack

from nhtrack.analysis.demand import demands
from nhtrack.analysis.speedup import Binding, bindings, rounded_up
from nhtrack.config.changes import ScenarioChanges
from nhtrack.config.checks import MOST_PERIODS
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError
from nhtrack.experiment.build import Experiment, build, robot_of
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.loop import Progress, Rollout
from nhtrack.presentation.numbers import seconds
from nhtrack.recording.source import Source, load
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.studies.feasibility.result import Feasibility
from nhtrack.terminal.progress import Observer, shown_progress

_CLOSE_ENOUGH = 0.998  # a fitting time scale this close to what its own run asks for is taken
_FIRST_PERIODS = 2000  # of the first run of a search
_FEWEST_PERIODS = 100  # below this a run no longer is the motion of its scenario
_MOST_RUNS = 20
_MOST_BLIND_PERIODS = 200_000  # of a run that diverges: beyond it the control period is not to blame


def feasibility(
    scenario: Source, *, progress: bool | Observer | None = None, **changes: Unpack[ScenarioChanges]
) -> Feasibility:
    """Returns what a scenario asks of its robots, from ideal runs alone.

    Args:
        scenario: as in `nhtrack.run`; `time: auto` is resolved first.
        progress: as in `nhtrack.run`.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with the scenario and its changes.
        FeasibilityError: `time: auto` and no time scale fits, or the law does not hold the robots at this one.
    """
    loaded = load(scenario, **changes)
    with shown_progress(progress) as stage:
        compile_once(stage)
        return _asked_of_robots(loaded, stage("ideal runs"))


def _asked_of_robots(scenario: Scenario, progress: Progress) -> Feasibility:
    robot, auto = robot_of(scenario), scenario.similarity.time == "auto"
    scenario = with_time(scenario, progress, robot)
    experiment = build(scenario, robot)
    run, lost = ideal_motion(experiment, progress)
    if lost:
        raise FeasibilityError(f"at similarity.time {scenario.similarity.time_scale:g} the ideal run diverges")
    ground = experiment.scene.ground
    wanted = demands(experiment, run, robot.plant, ground)
    bound = bindings(experiment, run, robot.plant, ground.scaled(scenario.similarity.friction_margin))
    try:
        smallest = scenario.similarity.time_scale if auto else fitting_time(scenario, progress, robot)
        return Feasibility(scenario, wanted, bound, smallest)
    except FeasibilityError as error:
        return Feasibility(scenario, wanted, bound, None, str(error))


def with_time(scenario: Scenario, progress: Progress | None = None, robot: RobotModels | None = None) -> Scenario:
    """Returns the scenario with a number for `time: auto`, the smallest that fits; any other as it is.

    Args:
        scenario: whose time scale.
        progress: called with the control periods done and their number, anew for every run.
        robot: see `nhtrack.experiment.build.robot_of`, where it has been read already.

    Raises:
        FeasibilityError: none fits.
    """
    if scenario.similarity.time != "auto":
        return scenario
    return _at_time(scenario, fitting_time(scenario, progress, robot))


def fitting_time(scenario: Scenario, progress: Progress | None = None, robot: RobotModels | None = None) -> float:
    """Returns the smallest time scale at which the ideal run fits wheels and motors, rounded up to four digits.

    One run tells by what factor its motion may be sped up. The control rate stays on the robot's clock, so the run at
    the new time scale differs a little; it is run as well, and again, until a time scale fits in its own run and is no
    larger than that run asks for. Arguments as in `with_time`.

    Raises:
        FeasibilityError: nothing fits, with robot, time and quantity.
    """
    robot = robot or robot_of(scenario)
    per_unit = scenario.duration * scenario.control_rate  # control periods at T = 1
    floor, ceiling = rounded_up(_FEWEST_PERIODS / per_unit), MOST_PERIODS / per_unit
    time, too_small, fitted = max(_FIRST_PERIODS / per_unit, floor), 0.0, None
    for _ in range(_MOST_RUNS):
        worst = _worst(_at_time(scenario, time), robot, progress)
        if worst is None and time * per_unit > _MOST_BLIND_PERIODS:
            raise FeasibilityError(f"the ideal run diverges at every time scale tried, up to {time:.3g}")
        if worst is None:
            wanted = 4 * time
        elif worst.factor == 0:
            place = f"{worst.robot}'s {worst.wheel} wheel at {seconds(worst.time)}"
            raise FeasibilityError(f"{place} asks for {worst.limit} and there is none, however slow the motion")
        else:
            wanted = max(rounded_up(time / worst.factor), floor)
        if worst is not None and worst.factor >= 1:
            fitted = time if fitted is None else min(fitted, time)
            if wanted <= too_small or wanted >= _CLOSE_ENOUGH * time:
                return fitted
        else:
            too_small = max(too_small, time)
            if fitted is not None and wanted >= fitted:
                return fitted
        time = wanted
        if time > ceiling and worst is not None:
            raise FeasibilityError(_too_long(scenario, time, worst))
    raise FeasibilityError(f"no time scale found in {_MOST_RUNS} runs; the last tried was {time:g}")


def _too_long(scenario: Scenario, time: float, worst: Binding) -> str:
    reason = f"{worst.limit} of {worst.robot}'s {worst.wheel} wheel at {seconds(worst.time)} asks for it"
    count = scenario.duration * time * scenario.control_rate
    return (
        f"time scale {time:.3g} needed: {reason}; "
        f"that is {count:.2g} control periods, and at most {MOST_PERIODS:.2g} fit in a recording"
    )


def _worst(scenario: Scenario, robot: RobotModels, progress: Progress | None) -> Binding | None:
    """Returns the limit that the robots of a scenario's ideal run meet first, or None for a run that diverges."""
    experiment = build(scenario, robot)
    run, lost = ideal_motion(experiment, progress)
    if lost:
        return None
    found = bindings(experiment, run, robot.plant, experiment.scene.ground.scaled(scenario.similarity.friction_margin))
    return min(found, key=lambda binding: binding.factor)


def ideal_motion(experiment: Experiment, progress: Progress | None = None) -> tuple[Rollout, bool]:
    """Returns the run of an experiment on the ideal model, without telemetry, and whether a robot ran away.

    Raises:
        SimulationDiverged: the law raised an exception.
    """
    simulation = IdealSimulation(
        experiment.network.names, None, experiment.dt, keep_going=True, size=experiment.size
    )
    run = experiment.rollout(simulation, progress)
    run.require_whole()  # a robot that runs away is lost, and no failure
    return run, bool(simulation.lost.any())


def _at_time(scenario: Scenario, time: float) -> Scenario:
    return scenario.model_copy(update={"similarity": scenario.similarity.model_copy(update={"time": time})})
