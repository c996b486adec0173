"""The command line, given in this process."""

from __future__ import annotations

from typer.testing import CliRunner, Result

from nhtrack.cli import app


def invoke(*arguments: object) -> Result:
    """Returns what a command line prints and its exit code."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])
