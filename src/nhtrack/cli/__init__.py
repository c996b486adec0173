"""The command line: commands about files and the machine, and that of every study.

Modules import what a command needs when it runs, so that `nhtrack --help` answers at once.
"""

from importlib import import_module
from pkgutil import iter_modules

from nhtrack import studies
from nhtrack.terminal.app import app, run_app

__all__ = ["app", "run_app"]

# A module's commands register themselves when it is imported, and help lists them in that order.
for _study in iter_modules(studies.__path__):
    import_module(f"nhtrack.studies.{_study.name}.command")
for _module in ("scenarios", "system"):
    import_module(f"nhtrack.cli.{_module}")
