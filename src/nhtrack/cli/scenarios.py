"""Commands about scenario files: validate, schema, init, list."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.errors import FeasibilityError, ScenarioError
from nhtrack.terminal.app import EXIT_SCENARIO, app, fail
from nhtrack.terminal.options import Changes
from nhtrack.terminal.screen import screen

if TYPE_CHECKING:
    from nhtrack.config.campaign import Campaign
    from nhtrack.config.scenario import Scenario
    from nhtrack.config.sweep import Sweep


@app.command("validate")
def validate_command(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Scenario, campaign or sweep files, or bundled names.")
    ],
    overrides: Changes = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 2 where there are warnings, too.")] = False,
) -> None:
    """Check files, every fault with its line, and leaders beyond law or robot; nothing is run."""
    from nhtrack.experiment.load import load_either

    faulty = False
    for source in files:
        try:
            loaded = load_either(source, overrides or ())
            extent, warnings = _beforehand(loaded)
        except ScenarioError as error:
            faulty = True
            typer.echo(str(error), err=True)
        except FeasibilityError as error:
            faulty = True
            typer.echo(f"{source}: infeasible: {error}", err=True)
        else:
            typer.echo(f"{source}: ok ({_account(loaded)}{extent and '; ' + extent})")
            for warning in warnings:
                typer.echo(f"{source}: warning: {warning}", err=True)
            faulty = faulty or (strict and bool(warnings))
    if faulty:
        raise typer.Exit(EXIT_SCENARIO)


def _beforehand(loaded: Scenario | Campaign | Sweep) -> tuple[str, tuple[str, ...]]:
    """Returns how much a run is, where that is much and known, and what will go wrong, in sentences."""
    from nhtrack.config.campaign import Campaign
    from nhtrack.config.sweep import Sweep

    if isinstance(loaded, Sweep):
        from nhtrack.studies.sweep.run import plan_of, sweep_beforehand

        return "", sweep_beforehand(plan_of(loaded))
    auto = loaded.similarity.time == "auto"
    if isinstance(loaded, Campaign):
        from nhtrack.studies.campaign import beforehand as campaigns

        if auto:
            return "", campaigns.campaign_beforehand_without_time(loaded)
        return "", campaigns.campaign_beforehand(loaded, most=campaigns.LOOKED_AT)
    from nhtrack.analysis.beforehand import beforehand, beforehand_without_time, told_extent
    from nhtrack.experiment.build import build

    if auto:
        return beforehand_without_time(loaded)
    experiment = build(loaded)
    return told_extent(loaded, experiment), beforehand(loaded, experiment)


def _account(loaded: Scenario | Campaign | Sweep) -> str:
    """Returns what a scenario amounts to on the robot, or how much a campaign or a sweep asks for."""
    from nhtrack.config.campaign import Campaign
    from nhtrack.config.sweep import Sweep
    from nhtrack.presentation.numbers import counted

    if isinstance(loaded, Sweep):
        axes = counted(len(loaded.axes), "axis").replace("axiss", "axes")
        return f"{axes}, {counted(loaded.points, 'point')}, {counted(loaded.runs, 'run')}"
    if isinstance(loaded, Campaign):
        families = len(loaded.family_names)
        runs = len(loaded.laws) * families * loaded.starts.count
        laws, references = counted(len(loaded.laws), "law"), counted(families, "reference")
        return f"{laws}, {references}, {counted(runs, 'run')}, {loaded.backend} backend"
    scenario = loaded
    auto = scenario.similarity.time == "auto"
    time = "a time yet to be found" if auto else f"{scenario.periods / scenario.control_rate:g} s"
    return f"{counted(len(scenario.followers), 'follower')}, {time} on the robot's clock, {scenario.law.name} law"


@app.command()
def schema(
    out: Annotated[Path | None, typer.Option(help="Write to this file instead of the terminal.")] = None,
    campaign: Annotated[bool, typer.Option("--campaign", help="Of campaign files.")] = False,
    sweep: Annotated[bool, typer.Option("--sweep", help="Of sweep files.")] = False,
) -> None:
    """Print the JSON Schema of scenario files, for editors that complete and check them."""
    from nhtrack.config.campaign import Campaign
    from nhtrack.config.documentation import json_schema
    from nhtrack.config.scenario import Scenario
    from nhtrack.config.sweep import Sweep

    text = json.dumps(json_schema(Sweep if sweep else Campaign if campaign else Scenario), indent=2)
    if out is None:
        typer.echo(text)
    else:
        _write(out, text + "\n")
        typer.echo(f"wrote {out}")


@app.command("init")
def init_command(
    path: Annotated[
        Path | None,
        typer.Argument(help="The file to write; by default scenario.yaml, or my_law.py.", show_default=False),
    ] = None,
    law: Annotated[bool, typer.Option("--law", help="A tracking law of your own, in Python.")] = False,
    along: Annotated[
        Path | None,
        typer.Option("--path", metavar="FILE", help="The leader drives after this file of poses or velocities."),
    ] = None,
    sweep: Annotated[bool, typer.Option("--sweep", help="A sweep of a scenario's keys.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")] = False,
) -> None:
    """Write a commented scenario, with --law a law, or with --sweep a sweep, to start from."""
    if law + sweep + (along is not None) > 1:
        raise typer.BadParameter("leave out all but one of --law, --sweep and --path", param_hint="--path")
    target = path or Path("my_law.py" if law else "sweep.yaml" if sweep else "scenario.yaml")
    if law and target.suffix != ".py":
        raise typer.BadParameter(f"a law is a Python file such as my_law.py, got {target}", param_hint="PATH")
    if target.exists() and not force:
        fail(f"error: {target} exists; choose another name, or --force to replace it")
    _write(target, _law_text() if law else _sweep_text(target) if sweep else _scenario_text(target, along))
    if law:
        typer.echo(_LAW_WRITTEN.format(path=target))
    elif sweep:
        typer.echo(f"wrote {target}; run it with: nhtrack sweep {target}")
    else:
        typer.echo(f"wrote {target}; run it with: nhtrack run {target}")


_LAW_WRITTEN = """wrote {path}; try it with:
  nhtrack run tour/hello --set "law={{file: {path}}}"
  nhtrack compare tour/universal kanayama {path}
and in a scenario of yours, with gains: law: {{file: {path}, k_x: 2}}"""


def _law_text() -> str:
    from nhtrack.assets import find_example

    return find_example("write_a_law/my_law.py").read_text(encoding="utf-8")


def _sweep_text(target: Path) -> str:
    from nhtrack.config.sweep_starter import sweep_starter

    return sweep_starter(target.stem)


def _scenario_text(target: Path, along: Path | None) -> str:
    """Returns a scenario that is called as its file, with a leader that drives after another where that is given."""
    if along is not None:
        from nhtrack.config.path_starter import path_starter
        from nhtrack.references import FileFaults

        try:
            return path_starter(target.stem, along, target.parent)
        except FileFaults as error:
            fail(str(error), EXIT_SCENARIO)
    from nhtrack.config.starter import starter

    return starter(target.stem)


def _write(path: Path, text: str) -> None:
    """Writes a text file that appears under its name only once it is whole."""
    from nhtrack.files.atomic import atomic_path

    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


@app.command("list")
def list_assets() -> None:
    """List the bundled scenarios, campaigns, sweeps and robots."""
    from rich.table import Table

    from nhtrack import assets

    scenarios = [(name, _description(assets.find_scenario(name))) for name in assets.bundled_scenarios()]
    campaigns = [(name, _description(assets.find_campaign(name))) for name in assets.bundled_campaigns()]
    sweeps = [(name, _description(assets.find_sweep(name))) for name in assets.bundled_sweeps()]
    robots = [(name, assets.robot_description(name)) for name in assets.robots()]
    console = screen()
    titles = ("Scenarios", scenarios), ("Campaigns", campaigns), ("Sweeps", sweeps), ("Robots", robots)
    for title, rows in titles:
        table = Table(title=title, title_justify="left", box=None, show_header=False, padding=(0, 2))
        table.add_column(no_wrap=True, style="bold")
        table.add_column()
        for row in rows:
            table.add_row(*row)
        console.print(table)


def _description(path: Path) -> str:
    """Returns what a bundled file says it is; all else in it is left unread, which may be a thousand robots."""
    from nhtrack.config.tree import plain_value

    found = re.search(r"^description:(.*(?:\n[ \t].*)*)", path.read_text(encoding="utf-8"), re.MULTILINE)
    return "" if found is None else str(plain_value(found[1]))
