"""Figures into files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.plots.style import COLUMN
from nhtrack.recording import atomic_path

__all__ = ["save_figure"]

COLUMN_DPI, WIDE_DPI = 600.0, 200.0  # [1/in]


def save_figure(
    figure: Figure,
    stem: Path,
    suffixes: Sequence[str] = (".png", ".pdf"),
    dpi: float | None = None,
    title: str | None = None,
) -> list[Path]:
    """Writes a figure as PNG and PDF; the same figure gives the same bytes.

    Args:
        figure: what to write, within the house style.
        stem: the files' path without its suffix.
        suffixes: of the files.
        dpi: pixels of the PNG [1/in]; by default what journals ask of drawings in a figure one column wide, and 200
            in wider ones.
        title: written into the files' metadata.

    Returns:
        The files; each appears under its name only once it is whole.
    """
    written = []
    pixels = dpi if dpi is not None else COLUMN_DPI if figure.get_figwidth() <= COLUMN else WIDE_DPI
    figure.draw_without_rendering()  # the layout settles in two passes: ticks depend on sizes, sizes on ticks
    for suffix in suffixes:
        target = stem.with_name(stem.name + suffix)
        metadata: dict[str, str | None] = {"CreationDate": None} if suffix == ".pdf" else {"Software": None}
        metadata |= {"Title": title} if title is not None else {}
        with atomic_path(target) as temporary:
            figure.savefig(temporary, dpi=pixels, metadata=metadata)
        figure.set_layout_engine("none")  # laid out by the first drawing
        written.append(target)
    return written
