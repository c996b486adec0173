"""The application the commands register with, and what its exit codes mean.

0 done; 1 another error of the package; 2 a scenario, a robot, a recording or a command line at fault; 3 a simulation
that diverged; 130 interrupted by the user.
"""

from __future__ import annotations

import logging
import signal
import subprocess
import warnings
from types import FrameType
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
)

EXIT_ERROR, EXIT_SCENARIO, EXIT_DIVERGED, EXIT_INTERRUPTED = 1, 2, 3, 130
_LATER = 0.01  # [s] when an interruption is tried again
_STARTING = (subprocess.Popen.__init__.__code__, subprocess.Popen._execute_child.__code__)  # type: ignore[attr-defined]


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
            fail("interrupted", EXIT_INTERRUPTED)

    def invoke(self, ctx: Any) -> Any:
        """Runs the command that was asked for."""
        try:
            return super().invoke(ctx)
        except ScenarioError as error:
            fail(str(error), EXIT_SCENARIO)
        except RefusedError as error:
            fail(f"refused: {error}", EXIT_SCENARIO)
        except FeasibilityError as error:
            fail(f"infeasible: {error}", EXIT_SCENARIO)
        except (RobotError, RecordingError) as error:
            fail(f"error: {error}", EXIT_SCENARIO)
        except SimulationDiverged as error:
            fail(f"diverged: {error}", EXIT_DIVERGED)
        except NhtrackError as error:
            fail(f"error: {error}")
        except KeyboardInterrupt:
            fail("interrupted", EXIT_INTERRUPTED)
        except BrokenPipeError:
            raise  # the reader of our output left: typer ends quietly
        except OSError as error:
            fail(f"error: {error}")


app = typer.Typer(
    cls=Commands,
    help="Nonholonomic robots on real MuJoCo wheel contacts, beside the ideal integrator.",
    no_args_is_help=True,
    rich_markup_mode=None,  # boxes around help are drawn by a library that takes longer to import than all the rest
    add_completion=False,
    pretty_exceptions_enable=False,
)


def run_app() -> None:
    """Runs the command line; what is asked to end (SIGTERM) ends as if interrupted, and keeps what it has."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    gl.withhold()
    warnings.filterwarnings("ignore", "law .* runs as Python")  # the commands say it themselves
    app()


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raises KeyboardInterrupt, a little later while a process is being started.

    In what logging does beside the fork Python would ignore it; in what starts the process nobody would end that.
    """
    if frame is not None and (frame.f_code in _STARTING or frame.f_code.co_filename == logging.__file__):
        signal.setitimer(signal.ITIMER_REAL, _LATER)
        return
    raise KeyboardInterrupt


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
