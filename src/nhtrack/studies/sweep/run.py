"""A sweep from its file to its table: planned in parts, done side by side, gone on with where it was left."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from nhtrack.analysis import extent
from nhtrack.analysis.beforehand import beforehand
from nhtrack.analysis.machines import ready
from nhtrack.config.changes import overrides_of
from nhtrack.config.sweep import Sweep
from nhtrack.errors import FeasibilityError
from nhtrack.execution import Executor, Processes, cores
from nhtrack.experiment.build import Experiment, build
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.load import load, load_sweep
from nhtrack.files.appeared import wait_for
from nhtrack.studies.campaign.tables import save_runs
from nhtrack.studies.sweep.account import claim, files_of, require_unchanged
from nhtrack.studies.sweep.batch import most_side_by_side
from nhtrack.studies.sweep.parts import Part, metric_columns, read_rows
from nhtrack.studies.sweep.plan import Plan
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.stubborn import do_parts
from nhtrack.terminal.progress import Observer, Stage, Tell, shown_progress

_JUDGED = 1e-3  # [s] that a run's scenario takes to be made and judged


def sweep(
    source: str | Path | Sweep,
    *,
    out: str | Path | None = None,
    set: Mapping[str, Any] | Iterable[str] = (),
    processes: int | None = None,
    executor: Executor | None = None,
    figures: bool = False,
    pdf: bool = False,
    report: bool = False,
    progress: bool | Observer | None = None,
    tell: Tell | None = None,
) -> SweepResults:
    """Returns what came of one scenario under many values of some of its keys; stopped, the same call goes on.

    Args:
        source: a bundled name (`sweep/small`), a sweep file, or a loaded sweep.
        out: results folder; by default `runs/sweep-<name>`.
        set: changes of the sweep's own keys, `{"repeats": 3}` or `["repeats=3"]`; not of a loaded sweep.
        processes: how many at once, one for each core by default; a script that asks for more than one needs
            `if __name__ == "__main__":`.
        executor: what does the runs in place of processes, such as `nhtrack.execution.executor_of("ray")`.
        figures: whether to draw figures into the folder.
        pdf: whether to draw them for print.
        report: whether to write its page, `report.html`, and scenario files of its extreme runs.
        progress: as in `nhtrack.run`.
        tell: called with each warning there is before its runs.

    Raises:
        ScenarioError: everything wrong with the sweep, its scenario and the values of its axes.
        SweepError: the folder holds another sweep, or a file that runs read changed meanwhile.
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    loaded = source if isinstance(source, Sweep) else load_sweep(source, overrides_of(set=set))
    folder = Path("runs") / f"sweep-{loaded.name}" if out is None else Path(out)
    with shown_progress(progress) as stage:
        results = run_sweep(loaded, folder, stage, executor or Processes(processes), tell)
    if figures:
        from nhtrack.studies.sweep.figure import save_sweep_figures

        results = replace(results, files=(*results.files, *save_sweep_figures(results, folder / "figures", pdf=pdf)))
    if report:
        from nhtrack.studies.sweep.report import write_sweep_report

        results = replace(results, files=(*results.files, write_sweep_report(results)))
    return results


def run_sweep(
    sweep: Sweep,
    folder: Path,
    stage: Stage | None = None,
    executor: Executor | None = None,
    tell: Tell | None = None,
) -> SweepResults:
    """Runs a sweep into a folder; what is there of it already is kept.

    The folder gets `sweep.json` (what was asked for, and versions), `parts/` (rows of some runs each), and at the end
    `runs.parquet`, a row a run.

    Args:
        sweep: what to run.
        folder: where to; one that holds another sweep is refused.
        stage: called with the name of each stage; returns what to report its progress to.
        executor: what does the parts; processes, one for each core, by default. Its machines share the folder.
        tell: called with each warning there is before its runs.

    Raises:
        SweepError: the folder holds another sweep, or a file that runs read changed meanwhile.
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    executor, plan = executor or Processes(), plan_of(sweep)
    workers = executor.workers
    compile_once(stage)
    warnings = sweep_beforehand(plan)
    executor = ready(executor, folder, plan.tree, sweep.model_dump(mode="json", include={"axes"}))
    size = claim(plan, folder, lambda: part_size(plan, workers))
    if tell is not None:
        for warning in warnings:
            tell(warning)
    written = folder.absolute() / "parts"  # a worker may be in another folder
    parts = [Part(runs, written / f"{k}.parquet") for k, runs in enumerate(plan.parts(size))]
    missing = [part for part in parts if not part.path.exists()]
    report = (stage or (lambda name: lambda done, total: None))("runs")
    done = sum(len(part.runs) for part in parts) - sum(len(part.runs) for part in missing)
    report(done, sweep.runs)
    for part in do_parts(plan, missing, executor):
        done += len(part.runs)
        report(done, sweep.runs)
    wait_for(part.path for part in parts)
    require_unchanged(plan)
    runs = read_rows(part.path for part in parts)
    file = save_runs(runs, folder / "runs.parquet")
    metrics = tuple(metric_columns(sweep, plan.base))
    return SweepResults(sweep, plan.base, runs, metrics, folder, (file,), warnings)


def plan_of(sweep: Sweep) -> Plan:
    """Returns the plan of a sweep, its scenario loaded."""
    base = load(sweep.base, sweep.base_changes)
    return Plan(sweep, base, files_of(sweep, base.model_dump(mode="json")))


def sweep_beforehand(plan: Plan) -> tuple[str, ...]:
    """Returns what is known to go wrong, in sentences: of the scenario as its first run has it, and of repetitions."""
    sweep, scenario = plan.sweep, load(plan.sweep.base, [*plan.sweep.base_changes, *plan.changes(0)])
    found = list[str]()
    noisy = any(scenario.noise.model_dump().values()) or any(key.startswith("noise") for key in sweep.axes)
    if sweep.repeats > 1 and not noisy:
        found.append("repeats: nothing is random without `noise`; the runs of a point will be the same")
    try:
        found += [f"first run: {warning}" for warning in beforehand(scenario, build(scenario))]
    except FeasibilityError as error:
        found.append(f"first run: infeasible: {error}")
    return tuple(found)


def seconds_of(plan: Plan) -> float:
    """Returns how long a run takes on one core, about [s]; nothing of it is written or drawn."""
    return _JUDGED + extent.extent_of(_sketch(plan), wheels=plan.base.backend != "ideal").bare_seconds


def part_size(plan: Plan, workers: int | None = None) -> int:
    """Returns how many runs a part has where so many are done at once; one a core by default."""
    return extent.runs_a_part(seconds_of(plan), plan.sweep.runs, workers or cores(), most_side_by_side(_sketch(plan)))


def _sketch(plan: Plan) -> Experiment:
    """Returns an experiment of about a run's size: the scenario's, without limits, which its floor may not leave."""
    law = plan.base.law
    free = law.model_copy(update={"limits": None}) if "limits" in type(law).model_fields else law
    return build(plan.base.model_copy(update={"law": free}))
