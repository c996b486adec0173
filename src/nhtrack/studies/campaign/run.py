"""A campaign from its file to its tables: planned in parts, done in processes, gone on with where it was left."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import pandas as pd

from nhtrack.analysis.account import account_of, changed, held_account, made_of, read_account
from nhtrack.analysis.extent import extent_of, runs_a_part
from nhtrack.analysis.machines import ready
from nhtrack.analysis.time_scale import at_time
from nhtrack.config.campaign import Campaign
from nhtrack.config.changes import overrides_of
from nhtrack.config.edit import scenario_text
from nhtrack.config.law_sections import Law
from nhtrack.config.similarity_section import SimilaritySection
from nhtrack.errors import RefusedError
from nhtrack.execution import Executor, Processes
from nhtrack.experiment.build import build
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.load import load_campaign
from nhtrack.experiment.loop import Progress
from nhtrack.files.appeared import wait_for
from nhtrack.files.atomic import atomic_path
from nhtrack.files.folder import save_json
from nhtrack.studies.campaign.beforehand import campaign_beforehand
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.parts import Part, parts_of, run_part, slug
from nhtrack.studies.campaign.result import CampaignResults, write_campaign_report
from nhtrack.studies.campaign.tables import cells_of, save_cells, save_runs, worst_first
from nhtrack.studies.feasibility.run import fitting_time
from nhtrack.studies.tune.run import find_gains
from nhtrack.terminal.progress import Observer, Stage, Tell, shown_progress

# What gains depend on, with the time scale; neither backend nor starts.
_TUNED_BY = ("duration", "robot", "physics", "control_rate", "delay", "noise", "laws", "families", "tuning")

_ACCOUNT = "campaign.json"
_LEAST = 1.0  # [s] of a part: its scene and its law are made first

Key = tuple[str, str]
Task = TypeVar("Task", Part, "_Search")


class CampaignError(RefusedError):
    """A campaign that cannot be gone on with."""


def campaign(
    source: str | Path | Campaign,
    *,
    out: str | Path | None = None,
    set: Mapping[str, Any] | Iterable[str] = (),
    tuned_by: str | Path | None = None,
    processes: int | None = None,
    executor: Executor | None = None,
    figures: bool = False,
    pdf: bool = False,
    report: bool = False,
    progress: bool | Observer | None = None,
    tell: Tell | None = None,
) -> CampaignResults:
    """Returns what came of laws against references from many random starts; stopped, the same call goes on.

    Args:
        source: a bundled name (`campaign/small`), a campaign file, or a loaded campaign.
        out: results folder; by default `runs/campaign-<name>`.
        set: changes of its keys, `{"starts.count": 100}` or `["starts.count=100"]`; not of a loaded campaign.
        tuned_by: folder of a campaign whose gains are taken.
        processes: how many at once, one for each core by default; a script that asks for more than one needs
            `if __name__ == "__main__":`.
        executor: what does the runs in place of processes, such as `nhtrack.execution.executor_of("ray")`.
        figures: whether to draw figures into the folder.
        pdf: whether to draw them for print.
        report: whether to write the report.
        progress: as in `nhtrack.run`.
        tell: called with each warning there is before its runs.

    Raises:
        ScenarioError: everything wrong with the campaign and its changes.
        CampaignError: the folder holds another campaign, or what was tuned is not the same.
        FeasibilityError: `time: auto`, and no time scale fits.
        TuningError: a law to be tuned has no ranges.
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    loaded = source if isinstance(source, Campaign) else load_campaign(source, overrides_of(set=set))
    folder = Path("runs") / f"campaign-{loaded.name}" if out is None else Path(out)
    taken = None if tuned_by is None else Path(tuned_by)
    with shown_progress(progress) as stage:
        results = run_campaign(loaded, folder, stage, executor or Processes(processes), taken, tell)
    written = list(results.files)
    if figures:
        from nhtrack.studies.campaign.plots import save_campaign_figures

        labels = {grid.name: grid.labels for grid in loaded.grids}
        written += save_campaign_figures(results.runs, results.cells, folder / "figures", labels=labels, pdf=pdf)
    if report:
        written.append(write_campaign_report(results))
    return replace(results, files=tuple(written))


def run_campaign(
    campaign: Campaign,
    folder: Path,
    stage: Stage | None = None,
    executor: Executor | None = None,
    tuned_by: Path | None = None,
    tell: Tell | None = None,
) -> CampaignResults:
    """Runs a campaign into a folder; what is there of it already is kept.

    The folder gets `campaign.json` (what was asked for, and versions), `tuning/` (gains found), `parts/` (rows of some
    starts each), and at the end `runs.parquet`, `cells.csv` and `worst/` (a scenario file for each law).

    Args:
        campaign: what to run.
        folder: where to; one that holds another campaign is refused.
        stage: called with the name of each stage; returns what to report its progress to.
        executor: what does the parts; processes, one for each core, by default. Its machines share the folder.
        tuned_by: folder of a campaign whose gains are taken: the same laws, families, time scale and tuning.
        tell: called with each warning there is before its runs.

    Raises:
        CampaignError: the folder holds another campaign, or what was tuned is not the same.
        FeasibilityError: `time: auto`, and no time scale fits.
        TuningError: a law to be tuned has no ranges.
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    executor = executor or Processes()
    workers = executor.workers
    report = stage or (lambda name: lambda done, total: None)
    compile_once(stage)
    tree = campaign.model_dump(mode="json")
    files, executor = made_of(tree), ready(executor, folder, tree)
    campaign, size = _claim(campaign, files, folder, report, workers)
    if tuned_by is not None:
        _take_gains(campaign, files, tuned_by, folder)
    gains = _tuned(campaign, folder, report("tuning"), executor)
    warnings = campaign_beforehand(campaign, gains)
    if tell is not None:
        for warning in warnings:
            tell(warning)
    cells = {key: Cell(campaign, *key, gains.get(key, {})) for key in product(campaign.laws, campaign.family_names)}
    parts = [part for cell in cells.values() for part in parts_of(cell, folder.absolute(), size)]
    _all([part for part in parts if not part.path.exists()], run_part, report("runs"), executor)
    if said := changed(files):
        raise CampaignError(said)
    runs = pd.concat([pd.read_parquet(part.path) for part in parts], ignore_index=True)
    limits = {"position_limit": campaign.arrival.position, "heading_limit": campaign.arrival.heading}
    table = cells_of(runs, gains, backend=campaign.backend, **limits)
    written = (save_runs(runs, folder / "runs.parquet"), save_cells(table, folder / "cells.csv"))
    return CampaignResults(campaign, runs, table, _worst(cells, runs, folder / "worst"), folder, written, warnings)


def _claim(
    campaign: Campaign, files: Mapping[str, str], folder: Path, report: Callable[[str], Progress], workers: int
) -> tuple[Campaign, int]:
    """Returns the campaign with its time scale, and starts a part, after its account is written or found the same."""
    account = folder / _ACCOUNT
    asked = account_of(files, asked=campaign.model_dump(mode="json"))
    held, why = held_account(account, "campaign", asked)
    if why:
        raise CampaignError(why)
    if held:
        return at_time(campaign, float(held["time_scale"])), int(held["part"])
    campaign = at_fitting_time(campaign, report("time scale"))
    size = _part_size(campaign, workers)
    save_json(account, asked | {"time_scale": campaign.similarity.time_scale, "part": size})
    return campaign, size


def _part_size(campaign: Campaign, workers: int) -> int:
    """Returns how many starts a part has where so many parts are done at once, by what one of them takes."""
    label, law = next(iter(campaign.laws.items()))
    sketch = campaign.model_copy(update={"laws": {label: _free(law)}})
    families = campaign.family_names
    one = extent_of(build(Cell(sketch, label, families[0]).scenario(0)), wheels=campaign.backend != "ideal")
    runs = campaign.starts.count * len(campaign.laws) * len(families)
    return runs_a_part(one.bare_seconds, runs, workers, least=_LEAST)


def _free(law: Law) -> Law:
    """Returns a law without its limits, which leave it nothing where its floor or motors do not."""
    return law.model_copy(update={"limits": None}) if "limits" in type(law).model_fields else law


def at_fitting_time(campaign: Campaign, progress: Progress | None = None) -> Campaign:
    """Returns the campaign with a number for `time: auto`: the smallest at which every family fits.

    Leader, here a robot as well, and probing followers run under the first law without its limits, which would let
    them fit at any time scale but no longer follow.

    Raises:
        FeasibilityError: none fits.
    """
    if campaign.similarity.time != "auto":
        return campaign
    label, law = next(iter(campaign.laws.items()))
    starts = campaign.starts.model_copy(update={"count": campaign.probes})
    guess = SimilaritySection(length=campaign.similarity.length, friction_margin=campaign.similarity.friction_margin)
    probe = campaign.model_copy(update={"laws": {label: _free(law)}, "starts": starts, "similarity": guess})
    times = []
    for done, family in enumerate(campaign.family_names):
        scenario = Cell(probe, label, family).scenario(*range(campaign.probes), virtual=False)
        times.append(fitting_time(scenario.model_copy(update={"similarity": campaign.similarity})))
        if progress is not None:
            progress(done + 1, len(campaign.family_names))
    return at_time(campaign, max(times))


def _tuned(campaign: Campaign, folder: Path, progress: Progress, executor: Executor) -> dict[Key, dict[str, float]]:
    """Returns the gains of the laws to be tuned, by label and family, searched where they are not there yet."""
    if campaign.tuning is None:
        return {}
    searches = {
        (label, family): _Search(campaign, label, at, folder.absolute() / "tuning" / f"{slug(f'{label}-{at}')}.json")
        for label, (family, at) in product(campaign.tuning.laws, campaign.tuned_at.items())
    }
    missing = {search.path: search for search in searches.values() if not search.path.exists()}
    _all(list(missing.values()), _search, progress, executor)
    return {key: json.loads(search.path.read_text())["gains"] for key, search in searches.items()}


def _take_gains(campaign: Campaign, files: Mapping[str, str], source: Path, folder: Path) -> None:
    """Copies the gains that another campaign found for the same laws, families, time scale and tuning."""
    account = source / _ACCOUNT
    if not account.is_file():
        raise CampaignError(f"{source} holds no campaign")
    held, asked = read_account(account), campaign.model_dump(mode="json")
    before, tuned_with = held.get("asked", {}), held.get("files", {})
    other = [key for key in _TUNED_BY if before.get(key) != asked[key]]
    other += ["similarity.time"] if held.get("time_scale") != campaign.similarity.time_scale else []
    other += [name for name, known in files.items() if tuned_with.get(name) != known]
    if other:
        raise CampaignError(f"{source} was tuned for something else: {', '.join(other)} differ")
    for path in sorted((source / "tuning").glob("*.json")):
        save_json(folder / "tuning" / path.name, json.loads(path.read_text()))


class _Search(NamedTuple):
    """Gains of a law against a family to be searched, and the file they are written to."""

    campaign: Campaign
    label: str
    family: str
    path: Path


def _search(search: _Search) -> None:
    """Tunes a law on a run of several followers, whose starts are not the campaign's."""
    campaign, tuning = search.campaign, search.campaign.tuning
    assert tuning is not None  # else nothing is searched
    starts = campaign.starts.model_copy(update={"count": tuning.starts, "seed": tuning.seed, "special": 0.0})
    cell = Cell(campaign.model_copy(update={"starts": starts, "backend": "ideal"}), search.label, search.family)
    found = find_gains(cell.scenario(*range(tuning.starts)), None, tuning.budget, tuning.seed, below_bound=True)
    save_json(search.path, {"gains": found.gains, "account": found.account, "leaves": found.leaves})


def _all(tasks: list[Task], work: Callable[[Task], None], progress: Progress, executor: Executor) -> None:
    """Does tasks side by side and sees their files; what is done when one fails is on disk and stays."""
    for done, _ in enumerate(executor(tasks, work), start=1):
        progress(done, len(tasks))
    wait_for(task.path for task in tasks)


def _worst(cells: Mapping[Key, Cell], runs: pd.DataFrame, folder: Path) -> dict[str, Path]:
    """Writes the scenario of each law's worst run, and returns the files by label."""
    written = {}
    for label, part in runs.groupby("law", sort=False):
        worst: Any = worst_first(part).iloc[0]
        cell, path = cells[str(label), worst["family"]], folder / f"{slug(str(label))}.yaml"
        with atomic_path(path) as temporary:
            temporary.write_text(scenario_text(cell.scenario(int(worst["start"]))), encoding="utf-8")
        written[str(label)] = path
    return written
