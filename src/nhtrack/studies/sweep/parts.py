"""Parts of a sweep: some of its runs, and the file of their rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import METRICS, ON_WHEELS, Sweep
from nhtrack.errors import NhtrackError
from nhtrack.experiment.build import make_scene_spec, robot_of
from nhtrack.experiment.load import LOADER
from nhtrack.files.carried import as_named
from nhtrack.simulation.faults import LOST
from nhtrack.simulation.robot_models import RobotModels
from nhtrack.studies.campaign.tables import save_runs
from nhtrack.studies.sweep.batch import alike, run_side_by_side
from nhtrack.studies.sweep.metrics import expression_value, metrics_of
from nhtrack.studies.sweep.plan import Plan

COMPLETED, LOST_RUN, FAILED = "completed", "lost", "failed"  # what the column `outcome` says

Row = dict[str, Any]


class Part(NamedTuple):
    """Some runs of a sweep, few enough to go side by side, and where their rows go."""

    runs: Array
    path: Path


def run_part(plan: Plan, part: Part) -> None:
    """Runs a part and writes its rows; the file appears only once it is whole."""
    save_runs(part_rows(plan, part.runs), part.path)


def read_rows(files: Iterable[Path]) -> pd.DataFrame:
    """Returns the rows of parts, in order of the runs."""
    from pyarrow.parquet import ParquetDataset

    table = ParquetDataset(list(files)).read()
    return table.take(np.argsort(table["run"].to_numpy())).to_pandas(ignore_metadata=False)


def part_rows(plan: Plan, runs: Array) -> pd.DataFrame:
    """Returns the rows of some runs; what one of them cannot do is its reason, and no other's."""
    scenarios, rows = dict[int, Scenario](), dict[int, Row]()
    for run in map(int, runs):
        try:
            scenarios[run] = LOADER.load_tree(plan.tree, plan.base.name, overrides=plan.changes(run))
        except NhtrackError as error:
            rows[run] = _failed(error)
    judged, robots = list(scenarios), dict[str, RobotModels]()
    for group in alike(list(scenarios.values())):
        members = [judged[place] for place in group]
        rows |= dict(zip(members, _group_rows([scenarios[run] for run in members], plan.sweep, robots), strict=True))
    return _table(plan, runs, [rows[run] for run in map(int, runs)])


def failed_rows(plan: Plan, runs: Array, reason: str) -> pd.DataFrame:
    """Returns the rows of runs of which nothing came."""
    return _table(plan, runs, [_failed(reason) for _ in runs])


def _table(plan: Plan, runs: Array, rows: list[Row]) -> pd.DataFrame:
    table = plan.labels(runs)
    for name in metric_columns(plan.sweep, plan.base):
        table[name] = np.array([row.get(name, np.nan) for row in rows], dtype=float)
    for name in ("outcome", "reason"):
        table[name] = [row[name] for row in rows]
    return table


def metric_columns(sweep: Sweep, base: Scenario) -> list[str]:
    """Returns the columns of metrics and expressions of a sweep's table."""
    known = [name for name in METRICS if base.backend != "ideal" or name not in ON_WHEELS]
    return [*(sweep.metrics or known), *sweep.expressions]


def _group_rows(scenarios: list[Scenario], sweep: Sweep, robots: dict[str, RobotModels]) -> list[Row]:
    """Returns the rows of scenarios that go side by side; one by one where that cannot be."""
    try:
        robot = _robot(scenarios[0], robots)
        figures = run_side_by_side(scenarios, robot, twins=_asks_for_gaps(sweep))
    except NhtrackError as error:
        if len(scenarios) == 1:
            return [_failed(error)]
        return [row for scenario in scenarios for row in _group_rows([scenario], sweep, robots)]
    found = metrics_of(figures)
    return [
        _row({name: float(values[b]) for name, values in found.items()}, sweep, lost=bool(figures.lost[b]))
        for b in range(len(scenarios))
    ]


def _robot(scenario: Scenario, robots: dict[str, RobotModels]) -> RobotModels:
    """Returns what is read of a scenario's robot, once for all scenarios that differ in nothing that it depends on."""
    key = repr(make_scene_spec(scenario))
    if key not in robots:
        robots[key] = robot_of(scenario)
    return robots[key]


def _asks_for_gaps(sweep: Sweep) -> bool:
    words = " ".join((*(sweep.metrics or METRICS), *sweep.expressions.values()))
    return "gap_" in words


def _row(metrics: Mapping[str, float], sweep: Sweep, *, lost: bool) -> Row:
    own = {name: expression_value(formula, metrics) for name, formula in sweep.expressions.items()}
    return {**metrics, **own, "outcome": LOST_RUN if lost else COMPLETED, "reason": LOST if lost else ""}


def _failed(reason: object) -> Row:
    return {"outcome": FAILED, "reason": as_named(str(reason))}
