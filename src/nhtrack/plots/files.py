"""Figures into files."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from nhtrack.files.atomic import atomic_path
from nhtrack.plots.style import COLUMN

__all__ = ["save_figure"]

# [1/in] Pixels for a screen, and for print: of figures one column wide what journals ask of drawings.
_SCREEN = {"column": 200.0, "wide": 150.0}
_PRINT = {"column": 600.0, "wide": 200.0}


def save_figure(figure: Figure, stem: Path, *, pdf: bool = False, title: str | None = None) -> list[Path]:
    """Writes a figure as PNG for a screen, or as PNG and PDF for print; the same figure gives the same bytes.

    Args:
        figure: what to write, within the house style.
        stem: the files' path without its suffix.
        pdf: whether to write for print: a PDF too, and 600 pixels an inch in figures one column wide, else 200.
        title: written into the files' metadata.

    Returns:
        The files, PNG before PDF; each appears under its name only once it is whole.
    """
    dpi = (_PRINT if pdf else _SCREEN)["column" if figure.get_figwidth() <= COLUMN else "wide"]
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()  # the layout settles in two passes: ticks depend on sizes, sizes on ticks
    written = []
    for suffix in (".png", ".pdf") if pdf else (".png",):
        target = stem.with_name(stem.name + suffix)
        metadata: dict[str, str | None] = {"CreationDate": None} if suffix == ".pdf" else {"Software": None}
        metadata |= {"Title": title} if title is not None else {}
        with atomic_path(target) as temporary:
            figure.savefig(temporary, dpi=dpi, metadata=metadata)
        figure.set_layout_engine("none")  # laid out by the first drawing
        written.append(target)
    return written
