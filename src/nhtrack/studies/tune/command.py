"""The command `tune`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.presentation.numbers import cell
from nhtrack.terminal.app import app, fail
from nhtrack.terminal.options import Changes, load_scenario
from nhtrack.terminal.screen import (
    add_note,
    escape,
    make_table,
    print_how_laws_run,
    progress_bars,
    screen,
)

if TYPE_CHECKING:
    from rich.console import Console

    from nhtrack.studies.tune.run import Tuning


@app.command()
def tune(
    scenario: Annotated[str, typer.Argument(help="A scenario file, a bundled name, or a recording.nc.")],
    objective: Annotated[
        str, typer.Option(help="late, settling or utilisation, or weights: late=1,settling=0.5.")
    ] = "late",
    budget: Annotated[int, typer.Option(min=8, help="How many sets of gains to run.")] = 256,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search; the same seed finds the same gains.")] = 0,
    below_bound: Annotated[
        bool, typer.Option("--allow-below-bound", help="Allow gains that their law warns of.")
    ] = False,
    changes: Changes = None,
    write: Annotated[bool, typer.Option("--write", help="Put the gains into the scenario file.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write a copy of the scenario with the gains here.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the copy if it exists.")] = False,
) -> None:
    """Search the gains of a scenario's law on the ideal model."""
    from nhtrack.studies.tune.objective import Objective, ObjectiveError

    try:
        wanted = Objective.parse(objective)
    except ObjectiveError as error:
        raise typer.BadParameter(str(error), param_hint="--objective") from None
    target = _target(scenario, write, out, force)
    loaded = load_scenario(scenario, list(changes or []))
    print_how_laws_run([loaded.law])
    from nhtrack.studies.tune.run import tune as study

    with progress_bars() as stage:
        found = study(loaded, wanted, budget, seed, stage, below_bound=below_bound)
    _print_tuning(found, screen())
    if target is not None:
        _save(found, scenario, target, list(changes or []))
        typer.echo(f"wrote {target}")


def _target(scenario: str, write: bool, out: Path | None, force: bool) -> Path | None:
    """Returns the file to write, or None; refuses before any work is done what could not be written after it."""
    if not write and out is None:
        return None
    if scenario.endswith(".nc"):
        raise typer.BadParameter("a recording is not a file of gains; tune its scenario file", param_hint="--write")
    if out is None and not Path(scenario).is_file():
        raise typer.BadParameter(f"{scenario} is not a file; --out writes a copy", param_hint="--write")
    if out is not None and out.exists() and not force:
        fail(f"error: {out} exists; choose another --out, or --force to replace it")
    return out or Path(scenario)


def _save(found: Tuning, scenario: str, target: Path, changes: list[str]) -> None:
    """Writes the scenario file with the gains, and above its law how they were found."""
    from nhtrack.assets import find_scenario
    from nhtrack.config.edit import save_law_gains
    from nhtrack.experiment.load import LOADER

    source = Path(scenario) if Path(scenario).is_file() else find_scenario(scenario)
    account = found.account + (f", with {' '.join(changes)}" if changes else "")
    save_law_gains(source, target, found.gains, "nhtrack tune:", [f"{account};", found.leaves], LOADER)


def _print_tuning(found: Tuning, console: Console) -> None:
    """Prints the gains and what they leave, before and after, and the search in a line."""
    table = make_table(f"{found.scenario.name}: gains of the {found.scenario.law.name} law")
    for heading in ("", "before", "found"):
        table.add_column(heading, justify="right" if heading else "left")
    for name, gain in found.gains.items():
        table.add_row(name, f"{found.gains_before[name]:g}", f"{gain:g}")
    before, after = found.figures_before, found.figures
    table.add_section()
    for meaning, old, new, unit in (
        ("late error / path", before.late_position, after.late_position, "%"),
        ("late heading error", before.late_heading, after.late_heading, "rad"),
        ("settled after, of the run", before.settling, after.settling, "%"),
        ("peak friction utilisation", before.utilisation, after.utilisation, "%"),
        ("time scale needed, of given", before.pace, after.pace, "%"),
        ("cost", found.cost_before, found.cost, "1"),
    ):
        table.add_row(meaning, cell(old, unit), cell(new, unit))
    from nhtrack.presentation.shown import settled_note
    from nhtrack.settling import settling_limits

    add_note(table, settled_note(settling_limits(found.scenario.similarity.length)))
    console.print(table)
    console.print(escape(found.account), highlight=False, soft_wrap=True)
