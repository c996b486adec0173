"""The command `tune`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nhtrack.errors import noting
from nhtrack.terminal.app import app
from nhtrack.terminal.options import Address, Changes, Engine, Trust, Workers, load_scenario
from nhtrack.terminal.screen import print_how_laws_run, screen


@app.command("tune")
def tune_command(
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
    engine: Engine = "serial",
    address: Address = None,
    processes: Workers = None,
    trust: Trust = False,
    write: Annotated[bool, typer.Option("--write", help="Put the gains into the scenario file.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write a copy of the scenario with the gains here.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the copy if it exists.")] = False,
) -> None:
    """Search the gains of a scenario's law on the ideal model."""
    from nhtrack.execution import executor_of
    from nhtrack.studies.tune.objective import Objective, ObjectiveError

    try:
        wanted = Objective.parse(objective)
    except ObjectiveError as error:
        raise typer.BadParameter(str(error), param_hint="--objective") from None
    target = _target(scenario, write, out, force)
    overrides = list(changes or [])
    loaded = load_scenario(scenario, overrides, trust=trust)
    print_how_laws_run([loaded.law])
    from nhtrack.studies.tune.run import tune
    from nhtrack.studies.tune.save import refuse_other_law, save_gains
    from nhtrack.studies.tune.tables import print_tuning

    if target is not None:
        refuse_other_law(scenario, loaded.law)
    executor = executor_of(engine, processes, address)
    found = tune(loaded, wanted, budget, seed, below_bound=below_bound, executor=executor, progress=True)
    print_tuning(found, screen())
    if target is not None:
        with noting("the gains are those printed above"):
            save_gains(found, scenario, target, overrides)
        typer.echo(f"wrote {target}")
    else:
        into = "--write puts them into the file, --out FILE" if Path(scenario).is_file() else "--out FILE puts them"
        typer.echo(f"to keep these gains: the same command with {into} into a copy; or by hand: {found.law_line}")


def _target(scenario: str, write: bool, out: Path | None, force: bool) -> Path | None:
    """Returns the file to write, or None; refuses before any work is done what could not be written after it."""
    if not write and out is None:
        return None
    if scenario.endswith(".nc"):
        raise typer.BadParameter("a recording is not a file of gains; tune its scenario file", param_hint="--write")
    if out is None and not Path(scenario).is_file():
        raise typer.BadParameter(f"{scenario} is not a file; --out writes a copy", param_hint="--write")
    if out is not None:
        from nhtrack.studies.tune.save import refuse_existing

        refuse_existing(scenario, out, force)
    return out or Path(scenario)
