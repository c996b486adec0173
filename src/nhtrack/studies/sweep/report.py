"""The page of a sweep: its metrics over its axes, and any run of it again."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.config.documentation import json_schema
from nhtrack.config.edit import scenario_text
from nhtrack.config.sweep import METRICS, Sweep
from nhtrack.experiment.load import LOADER
from nhtrack.files.atomic import atomic_path
from nhtrack.files.names import file_names
from nhtrack.presentation.numbers import counted, grouped, listed
from nhtrack.report.page import Page, write_page
from nhtrack.report.scenario_listing import meanings, yaml_text
from nhtrack.studies.sweep.drawn import DIGITS, Drawn, drawn
from nhtrack.studies.sweep.front import pareto_rows
from nhtrack.studies.sweep.indices import NEED, sobol_indices
from nhtrack.studies.sweep.parts import COMPLETED, LOST_RUN
from nhtrack.studies.sweep.plan import Plan
from nhtrack.studies.sweep.result import SweepResults
from nhtrack.studies.sweep.screen import figure_text, not_completed, unit_of

_OF_A_FRONT = 12  # scenario files of a front
_SECTIONS = {
    "metrics": "Metrics", "heatmap": "Map", "axes": "Axes", "front": "Front", "matrix": "Matrix", "indices": "Indices",
    "run": "Chosen run",
}  # fmt: skip


def write_sweep_report(results: SweepResults) -> Path:
    """Writes the page of a sweep into its folder, and beside it, in `extremes/`, scenario files of its extreme runs."""
    versions = json.loads((results.folder / "sweep.json").read_text())["versions"]
    page = sweep_page(results, versions, write_extremes(results))
    return write_page(page, results.folder / "report.html")


def sweep_page(results: SweepResults, versions: Mapping[str, str], files: Mapping[int, str]) -> Page:
    """Returns what the page of a sweep shows.

    Args:
        results: of the sweep.
        versions: of what made them.
        files: scenario files of some runs, relative to the page.
    """
    sweep, metrics, content = results.sweep, results.known, drawn(results)
    tree, indices = sweep.model_dump(mode="json", exclude_defaults=True), sobol_indices(results)
    sections = {} if not metrics else dict(_SECTIONS)
    if len(results.varied) < 2:
        sections.pop("heatmap", None)
    failed = list(_failed(results))
    sections = sections | ({"failed": "Not completed"} if failed else {}) | {"sweep": "Sweep", "scenario": "Scenario"}
    again = {"order": Plan(sweep, results.base).order, "prefix": command_prefix(sweep)}
    data = content.data | {"again": again, "files": {str(run): file for run, file in files.items()}}
    data |= {"indices": _index_rows(indices, metrics, list(sweep.axes))}
    return Page(
        "sweep.html.j2",
        sweep.name,
        sections,
        list(_verdicts(results, content)),
        [("With the same versions, the sweep below, saved as a file:", "nhtrack sweep sweep.yaml")],
        versions,
        description=sweep.description,
        tiles=_tiles(results),
        warnings=results.warnings,
        facts=[("base", sweep.base), ("backend", results.base.backend), ("results", str(results.folder))],
        scripts=("sweep.js", "sweep_map.js", "sweep_matrix.js") if metrics else (),
        plots=bool(metrics),
        data=data,
        contents={
            "table": list(_table(results, metrics)),
            "indices": bool(len(indices)),
            "no_indices": NEED + "." if sweep.sample is None or sweep.sample.method != "saltelli" else _FEW,
            "left_out": int(indices["left_out"].max()) if len(indices) else 0,
            "failed": failed,
            "drawn": content,
            "digits": DIGITS,
            "yaml": yaml_text(tree),
            "keys": meanings(tree, json_schema(Sweep)),
            "scenario": yaml_text(results.base.model_dump(mode="json")),
        },
    )


_FEW = "Too few groups of points have a value in all of their runs, or no metric varies."


def command_prefix(sweep: Sweep) -> str:
    """Returns how the command begins that repeats a run, for a shell."""
    changes = [word for change in sweep.base_changes for word in ("--set", change)]
    return shlex.join(["nhtrack", "run", sweep.base, *changes])


def write_extremes(results: SweepResults) -> dict[int, str]:
    """Writes scenario files of the runs with the smallest and largest of each metric, of fronts, and the first lost.

    Returns:
        Their names relative to the results folder, by run.
    """
    plan, written = Plan(results.sweep, results.base), dict[int, str]()
    for name, run in _extremes(results):
        file = results.folder / "extremes" / f"{name}.yaml"
        scenario = LOADER.load_tree(plan.tree, plan.base.name, overrides=plan.changes(run))
        with atomic_path(file) as temporary:
            temporary.write_text(scenario_text(scenario), encoding="utf-8")
        written.setdefault(run, file.relative_to(results.folder).as_posix())
    return written


def _extremes(results: SweepResults) -> Iterator[tuple[str, int]]:
    """Yields the runs that get a file of their own, and what it is called."""
    completed, stems = results.completed, file_names(results.metrics)
    for metric in results.known:
        for which, row in (("smallest", completed[metric].idxmin()), ("largest", completed[metric].idxmax())):
            yield f"{which}_{stems[metric]}", int(completed["run"].loc[row])
    for one, other in results.sweep.pareto:
        front = pareto_rows(*(completed[name].to_numpy(dtype=float) for name in (one, other)))
        for k in np.unique(np.linspace(0, len(front) - 1, min(_OF_A_FRONT, len(front))).round().astype(int)):
            run = int(completed["run"].iloc[front[k]])
            yield f"front_{stems[one]}_{stems[other]}_{run}", run
    lost = results.runs.loc[results.runs["outcome"] == LOST_RUN, "run"]
    if len(lost):
        yield "first_lost", int(lost.iloc[0])


# In words and tables --------------------------------------------------------------------------------------------------


def _tiles(results: SweepResults) -> list[tuple[str, str]]:
    told = [("runs", grouped(len(results.runs))), ("completed", grouped(len(results.completed)))]
    counts = results.runs["outcome"].value_counts()
    return told + [(str(name), grouped(int(count))) for name, count in counts.items() if name != COMPLETED]


def _verdicts(results: SweepResults, content: Drawn) -> Iterator[str]:
    sweep = results.sweep
    how = "every combination of their values" if sweep.sample is None else f"{grouped(sweep.points)} points drawn"
    where = "on the ideal integrator" if results.base.backend == "ideal" else "on wheels in MuJoCo"
    repeats = "" if sweep.repeats == 1 else f", {sweep.repeats} runs of each"
    yield f"{listed(list(sweep.axes))} of {Path(sweep.base).name} varied {where}: {how}{repeats}."
    for (outcome, reason), part in not_completed(results.runs):
        yield f"{outcome}: {counted(len(part), 'run')}, the first {int(part['run'].iloc[0])}: {reason}"
    if content.shown < len(results.completed):
        yield (
            f"Maps, medians and bands are of all {grouped(len(results.completed))} completed runs. Dots are of "
            f"{grouped(content.shown)} of them, which can be chosen: the smallest and the largest of each metric, the "
            "fronts of each pair, and a random sample. runs.parquet has all."
        )


def _table(results: SweepResults, metrics: list[str]) -> Iterator[dict[str, Any]]:
    """Yields what came of each metric, and of which runs."""
    for place, name in enumerate(metrics):
        known = results.completed[name].dropna()
        rows = {"smallest": known.idxmin(), "largest": known.idxmax()}
        yield {
            "name": name,
            "place": place,
            "meaning": METRICS.get(name) or results.sweep.expressions.get(name, ""),
            "median": figure_text(float(known.median()), unit_of(name)),
            "count": grouped(len(known)),
            **{
                which: (figure_text(float(known[row]), unit_of(name)), int(results.runs["run"].loc[row]))
                for which, row in rows.items()
            },
        }


def _failed(results: SweepResults) -> Iterator[dict[str, Any]]:
    """Yields why runs did not complete, how many, the first of them and how it is repeated."""
    plan, prefix = Plan(results.sweep, results.base), command_prefix(results.sweep)
    for (outcome, reason), part in not_completed(results.runs, most=50):
        run = int(part["run"].iloc[0])
        changes = shlex.join([word for change in plan.changes(run) for word in ("--set", change)])
        yield {"outcome": outcome, "reason": reason, "runs": grouped(len(part)), "first": run,
               "command": f"{prefix} {changes}"}  # fmt: skip


def _index_rows(indices: Any, metrics: list[str], axes: list[str]) -> list[Any] | None:
    """Returns Sobol indices as the scripts draw them: by metric and axis S1 and ST with half widths of intervals."""
    if not len(indices):
        return None
    held = {(row["metric"], row["axis"]): row for row in indices.to_dict("records")}
    names = ("S1", "S1_conf", "ST", "ST_conf")
    return [
        [[round(held[metric, axis][name], 5) for name in names] for axis in axes] if (metric, axes[0]) in held else None
        for metric in metrics
    ]
