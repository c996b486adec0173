"""Figures into files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.recording import atomic_path

__all__ = ["save_figure"]


def save_figure(
    figure: Figure, stem: Path, suffixes: Sequence[str] = (".png", ".pdf"), dpi: float = 200.0
) -> list[Path]:
    """Writes a figure as PNG and PDF; the same figure gives the same bytes.

    Args:
        figure: what to write, within the house style.
        stem: the files' path without its suffix.
        suffixes: of the files.
        dpi: pixels of the PNG [1/in].

    Returns:
        The files; each appears under its name only once it is whole.
    """
    written = []
    figure.draw_without_rendering()  # the layout settles in two passes: ticks depend on sizes, sizes on ticks
    for suffix in suffixes:
        target = stem.with_name(stem.name + suffix)
        metadata = {"CreationDate": None} if suffix == ".pdf" else {"Software": None}
        with atomic_path(target) as temporary:
            figure.savefig(temporary, dpi=dpi, metadata=metadata)
        figure.set_layout_engine("none")  # laid out by the first drawing
        written.append(target)
    return written
