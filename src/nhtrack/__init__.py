"""Trajectory tracking of nonholonomic mobile robots on MuJoCo wheel contacts, beside the ideal integrator.

    scenario = nhtrack.load("paper/example1")
    recording = nhtrack.run(scenario)

The names below are imported when they are first used: importing the package itself has no effects.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nhtrack.config.scenario import Scenario as Scenario
    from nhtrack.experiment.load import load as load
    from nhtrack.recording import Recording as Recording
    from nhtrack.studies.run.run import run as run

    __version__: str

_HOMES = {
    "Recording": "nhtrack.recording",
    "Scenario": "nhtrack.config.scenario",
    "load": "nhtrack.experiment.load",
    "run": "nhtrack.studies.run.run",
}

__all__ = ["Recording", "Scenario", "__version__", "load", "run"]


def __getattr__(name: str) -> Any:
    """Imports a public name when it is first asked for."""
    if name == "__version__":
        from importlib.metadata import version

        value: Any = version("nhtrack")
    elif name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module 'nhtrack' has no attribute {name!r}; it has {', '.join(__all__)}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Lists the public names, imported or not."""
    return sorted({*globals(), *__all__})
