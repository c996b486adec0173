"""The command about the machine: doctor."""

from __future__ import annotations

import typer

from nhtrack.terminal.app import EXIT_ERROR, app


@app.command()
def doctor() -> None:
    """Check what this machine has for running and filming, and say what to do about what is missing."""
    from nhtrack.cli.doctor import report

    checks = report()
    for check in checks:
        mark = typer.style("ok  ", fg="green") if check.ok else typer.style("miss", fg="red")
        typer.echo(f"{mark} {check.name}: {check.detail}")
        if not check.ok and check.remedy:
            typer.echo(f"     {check.remedy}")
    if not all(check.ok for check in checks):
        raise typer.Exit(EXIT_ERROR)
