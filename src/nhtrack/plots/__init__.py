"""Figures of a recording: pure functions of it; only `save_figures` writes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.plots.files import save_figure
from nhtrack.plots.paths import trajectories
from nhtrack.plots.series import errors, inputs, slip
from nhtrack.plots.style import styled
from nhtrack.recording import Recording

__all__ = ["FIGURES", "errors", "inputs", "save_figures", "slip", "trajectories"]

FIGURES: dict[str, Callable[[Recording], Figure]] = {
    "trajectories": trajectories,
    "errors": errors,
    "inputs": inputs,
    "slip": slip,
}


@styled
def save_figures(recording: Recording, folder: Path) -> list[Path]:
    """Writes every figure as PNG (200 dpi) and PDF; each file appears under its name only once it is whole.

    Returns:
        The files, in the order of `FIGURES`, PNG before PDF.
    """
    return [path for name, draw in FIGURES.items() for path in save_figure(draw(recording), folder / name)]
