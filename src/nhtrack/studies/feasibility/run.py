"""The time scale at which a scenario fits its robots, found from ideal runs alone."""

from __future__ import annotations

from typing import Unpack

from nhtrack.analysis.demand import demands
from nhtrack.analysis.speedup import Binding, bindings
from nhtrack.analysis.time_scale import at_time, smallest_time
from nhtrack.config.changes import ScenarioChanges
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError
from nhtrack.experiment.build import Experiment, build, robot_of
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.loop import Progress, Rollout
from nhtrack.recording.source import Source, load
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.studies.feasibility.result import Feasibility
from nhtrack.terminal.progress import Observer, shown_progress


def feasibility(
    scenario: Source,
    *,
    progress: bool | Observer | None = None,
    trust: bool = False,
    **changes: Unpack[ScenarioChanges],
) -> Feasibility:
    """Returns what a scenario asks of its robots, from ideal runs alone.

    Args:
        scenario: as in `nhtrack.run`; `time: auto` is resolved first.
        progress: as in `nhtrack.run`.
        trust: whether to run a law of one's own that a recording brings along.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with the scenario and its changes.
        FeasibilityError: `time: auto` and no time scale fits, or the law does not hold the robots at this one.
    """
    loaded = load(scenario, trust=trust, **changes)
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
    return at_time(scenario, fitting_time(scenario, progress, robot))


def fitting_time(scenario: Scenario, progress: Progress | None = None, robot: RobotModels | None = None) -> float:
    """Returns the smallest time scale at which the ideal run fits wheels and motors; see `smallest_time`.

    Arguments as in `with_time`.

    Raises:
        FeasibilityError: nothing fits, with robot, time and quantity.
    """
    known = robot or robot_of(scenario)
    return smallest_time(scenario, lambda tried: _worst(tried, known, progress))


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
