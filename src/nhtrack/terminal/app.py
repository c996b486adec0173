"""The application the commands register with, and what its exit codes mean.

0 done; 1 another error of the package; 2 a scenario, a robot, a recording or a command line at fault; 3 a simulation
that diverged; 130 interrupted by the user.
"""

from __future__ import annotations

import errno
import os
import warnings
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from nhtrack import gl
from nhtrack.errors import (
    FeasibilityError,
    NhtrackError,
    RecordingError,
    RefusedError,
    RobotError,
    ScenarioError,
    SimulationDiverged,
    WriteError,
)
from nhtrack.stopping import comes_of_interruption, heard

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # what a disk says that takes no more
EXIT_ERROR, EXIT_SCENARIO, EXIT_DIVERGED, EXIT_INTERRUPTED = 1, 2, 3, 130


def fail(message: str, code: int = EXIT_ERROR) -> NoReturn:
    """Ends the command with a message on stderr, unwrapped: one line per fault stays one line."""
    typer.echo(message, err=True)
    raise typer.Exit(code)


class Commands(TyperGroup):
    """The commands, with the package's errors turned into plain lines and an exit code."""

    def make_context(self, *arguments: Any, **more: Any) -> Any:
        """Reads the command line."""
        try:
            return super().make_context(*arguments, **more)
        except KeyboardInterrupt:
            heard()
            fail("interrupted", EXIT_INTERRUPTED)

    def invoke(self, ctx: Any) -> Any:
        """Runs the command that was asked for; what stops it is told with the notes that were added on its way."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise  # the reader of our output left: typer ends quietly
        except typer.Exit:
            raise
        except (Exception, KeyboardInterrupt) as stopped:
            notes = getattr(stopped, "__notes__", ())
            if comes_of_interruption(stopped):
                heard()
                stopped = KeyboardInterrupt()
            elif isinstance(stopped, OSError) and stopped.filename is None and stopped.errno in _FULL:
                stopped = WriteError(f"cannot write the output: {os.strerror(stopped.errno)}")
            elif not isinstance(stopped, NhtrackError | OSError):
                raise
            said, code = next((said, code) for kind, said, code in _ENDS if isinstance(stopped, kind))
            fail("; ".join([said.format(stopped), *notes]), code)


# What a command that is stopped says, and its exit code; the first that fits.
_ENDS: tuple[tuple[type[BaseException], str, int], ...] = (
    (KeyboardInterrupt, "interrupted", EXIT_INTERRUPTED),
    (ScenarioError, "{}", EXIT_SCENARIO),
    (RefusedError, "refused: {}", EXIT_SCENARIO),
    (FeasibilityError, "infeasible: {}", EXIT_SCENARIO),
    (RobotError, "error: {}", EXIT_SCENARIO),
    (RecordingError, "error: {}", EXIT_SCENARIO),
    (SimulationDiverged, "diverged: {}", EXIT_DIVERGED),
    (BaseException, "error: {}", EXIT_ERROR),
)

app = typer.Typer(
    cls=Commands,
    help="Nonholonomic robots on real MuJoCo wheel contacts, beside the ideal integrator.",
    no_args_is_help=True,
    rich_markup_mode=None,  # boxes around help are drawn by a library that takes longer to import than all the rest
    add_completion=False,
    pretty_exceptions_enable=False,
)


def run_app() -> None:
    """Runs the command line."""
    gl.withhold()
    warnings.filterwarnings("ignore", "law .* runs as Python")  # the commands say it themselves
    app()


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"nhtrack {version('nhtrack')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    pass
