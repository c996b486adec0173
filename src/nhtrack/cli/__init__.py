"""The command line. Modules here import what a command needs when it runs, so that `nhtrack --help` answers at once."""

from nhtrack.cli.app import app, main
from nhtrack.cli.campaign import campaign
from nhtrack.cli.compare import compare
from nhtrack.cli.fidelity import fidelity
from nhtrack.cli.paper import paper
from nhtrack.cli.results import render, run
from nhtrack.cli.scenarios import init, list_assets, schema, validate
from nhtrack.cli.studies import feasibility, tune
from nhtrack.cli.system import doctor

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
