"""The time scale at which a scenario fits its robots, found from ideal runs alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from nhtrack.analysis.demand import PeakDemand, demands
from nhtrack.analysis.speedup import Binding, bindings, rounded_up
from nhtrack.config.checks import MOST_PERIODS
from nhtrack.config.schema import Scenario
from nhtrack.errors import FeasibilityError
from nhtrack.experiment.build import Experiment, build, make_scene_spec
from nhtrack.experiment.loop import Progress, Rollout
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.scene import reduced_models

_CLOSE_ENOUGH = 0.998  # a fitting time scale this close to what its own run asks for is taken
_FIRST_PERIODS = 2000  # of the first run of a search
_FEWEST_PERIODS = 100  # below this a run no longer is the motion of its scenario
_MOST_RUNS = 20
_MOST_BLIND_PERIODS = 200_000  # of a run that diverges: beyond it the control period is not to blame


@dataclass(frozen=True)
class Feasibility:
    """What a scenario asks of its robots at its time scale, and the time scale that fits.

    Attributes:
        scenario: with its time scale as a number.
        demands: see `demands`.
        bindings: see `bindings`, with the scenario's margin.
        fitting_time: smallest time scale that fits, or None where none does.
        obstacle: why none does, or None.
    """

    scenario: Scenario
    demands: tuple[PeakDemand, ...]
    bindings: tuple[Binding, ...]
    fitting_time: float | None
    obstacle: str | None = None

    @property
    def fits(self) -> bool:
        """Whether the scenario fits as it is, with its friction margin."""
        return all(binding.factor >= 1 for binding in self.bindings)

    @property
    def table(self) -> list[dict[str, Any]]:
        """Rows of plain values for JSON; what is not finite becomes None.

        After a robot's demands comes its `time_scale`: the scenario's as value, the smallest that fits the robot as
        limit, when and on which wheel it is bound.
        """
        present = self.scenario.similarity.time_scale
        rows = [vars(demand) for demand in self.demands]
        for binding in self.bindings:
            limit = present / binding.factor if binding.factor > 0 else math.inf
            place = binding.time, binding.wheel
            rows.append(vars(PeakDemand(binding.robot, "time_scale", present, "1", limit, limit / present, *place)))
        order = list(dict.fromkeys(row["robot"] for row in rows))
        rows.sort(key=lambda row: order.index(row["robot"]))
        return [{key: _finite(value) for key, value in row.items()} for row in rows]

    @property
    def verdict(self) -> str:
        """What the figures say, in a sentence."""
        time, margin = self.scenario.similarity.time_scale, self.scenario.similarity.friction_margin
        if self.fitting_time is None:
            return f"No time scale fits: {self.obstacle}."
        smallest = f"the smallest time scale that fits is {self.fitting_time:g}"
        if self.fits:
            return f"Fits at similarity.time {time:g}, with friction used to {margin:.3g} at most; {smallest}."
        worst = min(self.bindings, key=lambda binding: binding.factor)
        place = f"{worst.robot}'s {worst.wheel} wheel at {worst.time:.3g} s"
        return f"Does not fit at similarity.time {time:g}: {worst.limit} of {place}; {smallest}."


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def feasibility(scenario: Scenario, progress: Progress | None = None) -> Feasibility:
    """Returns what a scenario asks of its robots, from ideal runs alone.

    Args:
        scenario: what to look at; `time: auto` is resolved first.
        progress: called with the control periods done and their number, anew for every run.

    Raises:
        FeasibilityError: `time: auto` and no time scale fits, or the law does not hold the robots at this one.
    """
    drive, auto = reduced_plant(scenario), scenario.similarity.time == "auto"
    scenario = with_time(scenario, progress)
    experiment = build(scenario)
    run, lost = ideal_motion(experiment, progress)
    if lost:
        raise FeasibilityError(f"at similarity.time {scenario.similarity.time_scale:g} the ideal run diverges")
    ground = experiment.scene.ground
    wanted = demands(experiment, run, drive, ground)
    bound = bindings(experiment, run, drive, ground.scaled(scenario.similarity.friction_margin))
    try:
        smallest = scenario.similarity.time_scale if auto else fitting_time(scenario, progress)
        return Feasibility(scenario, wanted, bound, smallest)
    except FeasibilityError as error:
        return Feasibility(scenario, wanted, bound, None, str(error))


def reduced_plant(scenario: Scenario) -> DiffDrive:
    """Returns the reduced model of a scenario's robots as they are, with what they carry and their motors' limits."""
    return reduced_models(make_scene_spec(scenario))[1]


def with_time(scenario: Scenario, progress: Progress | None = None) -> Scenario:
    """Returns the scenario with a number for `time: auto`, the smallest that fits; any other as it is.

    Raises:
        FeasibilityError: none fits.
    """
    if scenario.similarity.time != "auto":
        return scenario
    return _at_time(scenario, fitting_time(scenario, progress))


def fitting_time(scenario: Scenario, progress: Progress | None = None) -> float:
    """Returns the smallest time scale at which the ideal run fits wheels and motors, rounded up to four digits.

    One run tells by what factor its motion may be sped up. The control rate stays on the robot's clock, so the run at
    the new time scale differs a little; it is run as well, and again, until a time scale fits in its own run and is no
    larger than that run asks for.

    Raises:
        FeasibilityError: nothing fits, with robot, time and quantity.
    """
    drive = reduced_plant(scenario)
    per_unit = scenario.duration * scenario.control_rate  # control periods at T = 1
    floor, ceiling = rounded_up(_FEWEST_PERIODS / per_unit), MOST_PERIODS / per_unit
    time, too_small, fitted = max(_FIRST_PERIODS / per_unit, floor), 0.0, None
    for _ in range(_MOST_RUNS):
        worst = _worst(_at_time(scenario, time), drive, progress)
        if worst is None and time * per_unit > _MOST_BLIND_PERIODS:
            raise FeasibilityError(f"the ideal run diverges at every time scale tried, up to {time:.3g}")
        if worst is None:
            wanted = 4 * time
        elif worst.factor == 0:
            place = f"{worst.robot}'s {worst.wheel} wheel at {worst.time:.3g} s"
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
    reason = f"{worst.limit} of {worst.robot}'s {worst.wheel} wheel at {worst.time:.3g} s asks for it"
    count = scenario.duration * time * scenario.control_rate
    return (
        f"time scale {time:.3g} needed: {reason}; "
        f"that is {count:.2g} control periods, and at most {MOST_PERIODS:.2g} fit in a recording"
    )


def _worst(scenario: Scenario, drive: DiffDrive, progress: Progress | None) -> Binding | None:
    """Returns the limit that the robots of a scenario's ideal run meet first, or None for a run that diverges."""
    experiment = build(scenario)
    run, lost = ideal_motion(experiment, progress)
    if lost:
        return None
    found = bindings(experiment, run, drive, experiment.scene.ground.scaled(scenario.similarity.friction_margin))
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
