"""Trajectory tracking of nonholonomic mobile robots on MuJoCo wheel contacts, beside the ideal integrator.

    run = nhtrack.run("paper/example1", set={"law.k": 5})
    run["error"], run.summary, run.recording

The names below are imported when they are first used: importing the package itself has no effects. What they return
shows itself in notebooks.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nhtrack.config.scenario import Scenario as Scenario
    from nhtrack.errors import NhtrackError as NhtrackError
    from nhtrack.errors import ScenarioError as ScenarioError
    from nhtrack.errors import SimulationDiverged as SimulationDiverged
    from nhtrack.recording import Recording as Recording
    from nhtrack.recording.source import load as load
    from nhtrack.recording.source import validate as validate
    from nhtrack.studies.campaign.run import campaign as campaign
    from nhtrack.studies.compare.run import compare as compare
    from nhtrack.studies.feasibility.run import feasibility as feasibility
    from nhtrack.studies.inspect.run import inspect as inspect
    from nhtrack.studies.plot.run import plot as plot
    from nhtrack.studies.render.run import render as render
    from nhtrack.studies.run.run import run as run
    from nhtrack.studies.sweep.run import sweep as sweep
    from nhtrack.studies.tune.run import tune as tune

    __version__: str

_HOMES = {
    "NhtrackError": "nhtrack.errors",
    "Recording": "nhtrack.recording",
    "Scenario": "nhtrack.config.scenario",
    "ScenarioError": "nhtrack.errors",
    "SimulationDiverged": "nhtrack.errors",
    "load": "nhtrack.recording.source",
    "validate": "nhtrack.recording.source",
} | {
    name: f"nhtrack.studies.{name}.run"
    for name in ("campaign", "compare", "feasibility", "inspect", "plot", "render", "run", "sweep", "tune")
}

__all__ = [
    "NhtrackError",
    "Recording",
    "Scenario",
    "ScenarioError",
    "SimulationDiverged",
    "__version__",
    "campaign",
    "compare",
    "feasibility",
    "inspect",
    "load",
    "plot",
    "render",
    "run",
    "sweep",
    "tune",
    "validate",
]


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
