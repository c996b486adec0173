"""Options that several commands have, and the scenario that most of them begin with."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from nhtrack.execution import engine_names

if TYPE_CHECKING:
    from nhtrack.config.scenario import Scenario


class Backend(StrEnum):
    """What moves the robots."""

    mujoco = "mujoco"
    ideal = "ideal"


Pdf = Annotated[bool, typer.Option("--pdf", help="Draw figures for print: PDF, and PNG of more pixels.")]
Changes = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Override any key: law.kp=3. Repeatable.")
]

Trust = Annotated[
    bool, typer.Option("--trust", help="Run the law that a recording brings along: code of whoever wrote it.")
]

Engine = Annotated[
    str, typer.Option("--executor", metavar="NAME", help=f"What does the work: {', '.join(engine_names())}.")
]
Address = Annotated[
    str | None,
    typer.Option(metavar="HOST:PORT", help="Of the Ray cluster that this machine belongs to; `auto` finds it."),
]
Workers = Annotated[
    int | None, typer.Option("--processes", min=1, help="How many at once; by default one a core.")
]


def load_scenario(source: str, overrides: list[str], *, trust: bool = False) -> Scenario:
    """Returns the scenario of a file, of a bundled name, or the one a recording was made from."""
    from nhtrack.recording.source import load_source

    loaded, notes = load_source(source, overrides, trust=trust)
    for note in notes:
        typer.echo(f"note: {note}", err=True)
    return loaded
