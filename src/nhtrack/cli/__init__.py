"""The command line. Modules here import what a command needs when it runs, so that `nhtrack --help` answers at once."""

from nhtrack.cli.scenarios import init, list_assets, schema, validate
from nhtrack.cli.system import doctor
from nhtrack.studies.campaign.command import campaign
from nhtrack.studies.compare.command import compare
from nhtrack.studies.fidelity.command import fidelity
from nhtrack.studies.paper.command import paper
from nhtrack.studies.run.command import render, run
from nhtrack.studies.tune.command import feasibility, tune
from nhtrack.terminal.app import app, main

__all__ = [
    "app",
    "campaign",
    "compare",
    "doctor",
    "feasibility",
    "fidelity",
    "init",
    "list_assets",
    "main",
    "paper",
    "render",
    "run",
    "schema",
    "tune",
    "validate",
]
