"""The house style of the figures, and the pieces every figure is drawn with.

Figures of a run are one journal column wide and their letters are of the size they have in print, so that they go into
a paper as they are. Names stand beside curves, not in legends, and what else there is to say in a note below. A figure
has no title, which a paper says in its caption, unless its run did not complete; the file's metadata name the run.

Figures are made without pyplot: nothing registers a window, and the style holds only while a figure is being
drawn. Those one column wide have neither a layout engine nor formulas, which cost more than all the rest: margins are
reckoned (`nhtrack.plots.margins`), and what is written is plain letters.
"""

from __future__ import annotations

import functools
import textwrap
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation, Transform

from nhtrack.colours import INK, robot_dashes
from nhtrack.plots.margins import EDGE, line_height
from nhtrack.recording import Recording

__all__ = [
    "COLUMN",
    "column_styled",
    "line_style",
    "panel_title",
    "plain",
    "run_title",
    "styled",
    "time_axes",
    "write_note",
]

COLUMN = 3.5  # [in] width of a column of a journal

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": "#666666",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-4, 4),
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "mathtext.fontset": "dejavusans",
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "savefig.dpi": 200,
    "pdf.fonttype": 42,  # letters stay letters: searchable, and accepted by journals
    "path.simplify_threshold": 0.5,
}

# Letters of 6 to 7 points are the smallest that journals accept.
COLUMN_STYLE: Any = STYLE | {
    "font.size": 7.0,
    "axes.titlesize": 7.0,
    "axes.titlepad": 3.0,
    "axes.titley": 1.0,
    "axes.formatter.use_mathtext": False,
    "axes.labelsize": 7.0,
    "axes.labelpad": 2.0,
    "axes.linewidth": 0.6,
    "grid.linewidth": 0.4,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
    "lines.linewidth": 1.0,
    "legend.fontsize": 6.5,
    "figure.constrained_layout.use": False,
    "path.simplify_threshold": 0.1,
}

_NOTE = 6.0  # [pt] of letters of a note
_NOTE_LETTERS = 22.0  # of a note in an inch
_TITLE = 7.5  # [pt] of letters of a title
_TITLE_LETTERS = 15.0  # of a title in an inch
_AIR = 0.05  # [in] between title or note and panels

P = ParamSpec("P")
R = TypeVar("R")


def _within(style: Any) -> Callable[[Callable[P, R]], Callable[P, R]]:
    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def inside(*args: P.args, **kwargs: P.kwargs) -> R:
            with mpl.rc_context(style):
                return function(*args, **kwargs)

        return inside

    return decorate


def styled(function: Callable[P, R]) -> Callable[P, R]:
    """Returns `function` run in the house style, which ends with the call."""
    return _within(STYLE)(function)


def column_styled(function: Callable[P, R]) -> Callable[P, R]:
    """Returns `function` run in the house style of figures one column wide, which ends with the call."""
    return _within(COLUMN_STYLE)(function)


def plain(text: str) -> str:
    """Returns a name as letters, whatever is in it: a dollar would begin a formula."""
    return text.replace("$", r"\$")


def panel_title(axes: Axes, letter: str, text: str) -> None:
    """Writes `(letter) text` above a panel."""
    axes.set_title(f"({letter}) {text}", color=INK)


def line_style(index: int) -> Any:
    """Returns the style of a robot's lines by its place in the palette, see `nhtrack.colours.robot_dashes`."""
    dashes = robot_dashes(index)
    return (0, dashes) if dashes else "-"


def time_axes(panels: np.ndarray, recording: Recording) -> None:
    """Labels a grid's time axes, in seconds of the robots' clock."""
    last = float(recording.time[-1]) if recording.time.size else 1.0
    for axes in panels[-1]:
        axes.set_xlabel("time [s]" if recording.time_scale == 1.0 else "robot time [s]")
    for axes in panels.ravel():
        axes.set_xlim(0.0, max(last, 1e-9))
        axes.margins(x=0)


def run_title(figure: Figure, recording: Recording) -> float:
    """Says above a figure one column wide why its run ended, if it did not complete.

    Returns:
        The height that this takes up at the figure's upper edge [in].
    """
    if recording.outcome == "completed":
        return 0.0
    lines = textwrap.wrap(f"{recording.name}: {recording.outcome}", int(_TITLE_LETTERS * COLUMN))
    look: dict[str, Any] = {"ha": "left", "va": "top", "fontsize": _TITLE, "fontweight": "bold", "color": INK}
    figure.suptitle(plain("\n".join(lines)), x=0.01, y=1.0, transform=_inset(figure, -EDGE), **look)
    return EDGE + line_height(_TITLE) * len(lines) + _AIR


def write_note(figure: Figure, recording: Recording, *sentences: str) -> float:
    """Writes sentences below a figure, and what a metre and a second of the scenario are where they are others.

    Returns:
        The height that this takes up at the figure's lower edge [in].
    """
    length, time = recording.length_scale, recording.time_scale
    units = [f"1\N{NO-BREAK SPACE}m is {_metres(length)}"] if length != 1.0 else []
    units += [f"1\N{NO-BREAK SPACE}s is {time:.4g}\N{NO-BREAK SPACE}s"] if time != 1.0 else []
    scale = [f"The scenario's {' and its '.join(units)} here."] if units else []
    whole = len(recording.time) == recording.rows
    rows = "" if whole else f"Drawn: {len(recording.time)} of {recording.rows} rows, peaks among them."
    said = [*sentences, *scale, *([rows] if rows else [])]
    if not said:
        return EDGE
    lines = textwrap.wrap(" ".join(said), int(_NOTE_LETTERS * figure.get_figwidth()))
    look: dict[str, Any] = {"ha": "left", "va": "bottom", "fontsize": _NOTE, "color": "#444444"}
    figure.supxlabel("\n".join(lines), x=0.01, y=0.0, transform=_inset(figure, EDGE), **look)
    return EDGE + line_height(_NOTE) * len(lines) + _AIR


def _inset(figure: Figure, up: float) -> Transform:
    """Returns the figure's coordinates some inches further up, whatever its height becomes."""
    return figure.transFigure + ScaledTranslation(0.0, up, figure.dpi_scale_trans)


def _metres(length: float) -> str:
    """Returns a length [m] in words."""
    value, unit = (1e3 * length, "mm") if length < 1.0 else (length, "m")
    return f"{value:.4g}\N{NO-BREAK SPACE}{unit}"
