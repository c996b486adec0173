"""Search of a law's gains on the ideal model: a Sobol sequence over all of them, then around the best.

The search works on the logarithms of the gains. The first half of the budget is spread over the whole box by a
Sobol sequence. Then, generation by generation, a normal distribution is fitted to the best candidates so far and
sampled, again by a Sobol sequence (the cross-entropy method). A generation is one batched rollout, at a control
rate that is lowered where the scenario's own would ask for more periods than the search needs; the best few are
run again at the scenario's own rate, and those figures decide.
"""

from __future__ import annotations

from pathlib import Path
from typing import Unpack

import numpy as np

from nhtrack.analysis.machines import ready
from nhtrack.arrays import Array
from nhtrack.config.changes import ScenarioChanges, overrides_of
from nhtrack.config.scenario import Scenario
from nhtrack.execution import Executor, serial
from nhtrack.experiment.build import robot_of
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.loop import Progress
from nhtrack.recording.source import Source, load
from nhtrack.studies.feasibility.run import with_time
from nhtrack.studies.tune.box import SearchBox, TuningError, by_name, require_budget
from nhtrack.studies.tune.objective import Objective
from nhtrack.studies.tune.result import Generation, Tuning
from nhtrack.studies.tune.save import refuse_existing, refuse_other_law, save_gains
from nhtrack.studies.tune.trial import Trial, with_gains
from nhtrack.terminal.progress import Observer, Stage, shown_progress

_GENERATIONS = 4  # after the first
_ELITE = 0.125  # share of all candidates that the next generation is drawn around
_FINALISTS = 16


def tune(
    scenario: Source,
    objective: str | Objective = "late",
    budget: int = 256,
    seed: int = 0,
    *,
    below_bound: bool = False,
    out: str | Path | None = None,
    overwrite: bool = False,
    executor: Executor = serial,
    progress: bool | Observer | None = None,
    trust: bool = False,
    **changes: Unpack[ScenarioChanges],
) -> Tuning:
    """Returns the gains of the lowest cost found; never worse than the scenario's own where those were allowed.

    Args:
        scenario: as in `nhtrack.run`; `time: auto` is found for its own gains first, and kept.
        objective: `late`, `settling` or `utilisation`, or weights, `late=1,settling=0.5`.
        budget: how many sets of gains to run, at least 8.
        seed: of the Sobol sequences; the same seed finds the same gains.
        below_bound: allow gains that their law warns of, such as k <= 2 (1 + ke/kp) or kd < 2 sqrt(kp).
        out: a copy of the scenario file to write, with the gains in it.
        overwrite: allow a copy that exists.
        executor: what runs the candidates; they run here, side by side, by default.
        progress: as in `nhtrack.run`.
        trust: whether to run a law of one's own that a recording brings along.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with the scenario and its changes.
        ObjectiveError: an objective that cannot be understood.
        OutputError: the copy exists, or the scenario is no file that can be copied or has another law; nothing is run.
        TuningError: a law without ranges to search, a budget too small, or no candidate that keeps its robots.
        FeasibilityError: `time: auto`, and no time scale fits the scenario's own gains.
    """
    wanted = Objective.parse(objective) if isinstance(objective, str) else objective
    if out is not None:
        refuse_existing(scenario, Path(out), overwrite)
    overrides = overrides_of(**changes)
    loaded = load(scenario, overrides, trust=trust)
    if out is not None:
        refuse_other_law(scenario, loaded.law)
    with shown_progress(progress) as stage:
        found = find_gains(loaded, wanted, budget, seed, stage, below_bound=below_bound, executor=executor)
    if out is not None:
        save_gains(found, scenario, Path(out), overrides)
    return found


def find_gains(
    scenario: Scenario,
    objective: Objective | None = None,
    budget: int = 256,
    seed: int = 0,
    stage: Stage | None = None,
    *,
    below_bound: bool = False,
    executor: Executor = serial,
) -> Tuning:
    """Returns the gains of the lowest cost found; see `tune`.

    Args:
        scenario: what to tune.
        objective: what is wanted; the late errors by default.
        budget: how many sets of gains to run, at least 8.
        seed: of the Sobol sequences.
        stage: see `nhtrack.studies.run.run.simulate`.
        below_bound: allow gains that their law warns of.
        executor: what runs the candidates.

    Raises:
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    require_budget(budget)
    executor = ready(executor, None, scenario.model_dump(mode="json"))
    objective = objective or Objective(late=1.0)
    compile_once(stage)
    robot = robot_of(scenario)
    scenario = with_time(scenario, stage("time scale") if stage is not None else None, robot)
    box = SearchBox.of(scenario, seed, below_bound, robot)
    trial = Trial(scenario, box.names, objective, robot, executor)
    report = stage("tuning") if stage is not None else lambda done, total: None
    found, costs, history = _search(trial, box, budget, report)
    order = np.argsort(costs, kind="stable")[:_FINALISTS]
    finalists = np.concatenate([box.start[None], found[order[np.isfinite(costs[order])]]])
    figures, final = trial.run(finalists, own_rate=True)
    allowed = final.copy()
    allowed[0] = final[0] if box.allows(box.start) else np.inf
    best = int(allowed.argmin())
    if not np.isfinite(allowed[best]):
        raise TuningError(f"none of {budget} candidates keeps its robots near their leaders and on their wheels")
    return Tuning(
        scenario=with_gains(scenario, by_name(box.names, finalists[best])),
        gains=by_name(box.names, finalists[best]),
        figures=figures.of(best),
        cost=float(final[best]),
        gains_before=by_name(box.names, box.start),
        figures_before=figures.of(0),
        cost_before=float(final[0]),
        history=tuple(history),
        objective=objective,
        seed=seed,
        below_bound=below_bound,
    )


def _search(trial: Trial, box: SearchBox, budget: int, report: Progress) -> tuple[Array, Array, list[Generation]]:
    """Returns all candidates tried, shape (budget, d), their costs, shape (budget,), and the generations."""
    later = [budget // 2 // _GENERATIONS] * _GENERATIONS if budget >= 8 * _GENERATIONS else []
    first = budget - sum(later)
    found, costs, history = np.empty((0, len(box.names))), np.empty(0), list[Generation]()
    for size in (first, *later):
        if not history:
            candidates = box.spread(size)
        else:
            elite = found[np.argsort(costs, kind="stable")[: max(len(box.names) + 2, round(_ELITE * len(found)))]]
            candidates = box.around(elite, size)

        def share_done(share: float, done: int = len(found), size: int = size) -> None:
            report(round(done + share * size), budget)

        _, cost = trial.run(candidates, share_done)
        found, costs = np.concatenate([found, candidates]), np.concatenate([costs, cost])
        history.append(Generation(size, float(costs.min())))
    return found, costs, history
