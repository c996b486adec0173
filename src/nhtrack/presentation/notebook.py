"""What a notebook shows of a result: a fragment of HTML that loads nothing, for light and dark pages."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined, Template
from markupsafe import Markup
from matplotlib.figure import Figure
from PIL import Image

from nhtrack.arrays import Array
from nhtrack.presentation.result_table import ResultTable

_SVG: dict[str, Any] = {"format": "svg", "metadata": {"Date": None, "Creator": None}}
_INCH = 96  # pixels of a browser


@dataclass(frozen=True)
class PageImage:
    """A picture in a page.

    Attributes:
        address: a `data:` URL of its bytes.
        text: what it shows, for who cannot see it and as its caption.
        width: [pixels] at most; None takes the room there is.
    """

    address: str
    text: str
    width: int | None = None


@dataclass(frozen=True)
class NotebookView:
    """What is shown of a result; parts that are empty are left out.

    Attributes:
        title: what it is.
        lead: a line below the title.
        tiles: names and values of the figures that matter most.
        strip: pictures in a row.
        film: `data:` URL of an MP4 film.
        figures: drawings.
        tables: tables.
        notes: sentences below.
        folded: sentences that are shown when they are asked for, by the line that asks.
    """

    title: str
    lead: str = ""
    tiles: Sequence[tuple[str, str]] = ()
    strip: Sequence[PageImage] = ()
    film: str = ""
    figures: Sequence[PageImage] = ()
    tables: Sequence[ResultTable] = ()
    notes: Sequence[str] = ()
    folded: Sequence[tuple[str, Sequence[str]]] = ()


def html_of(view: NotebookView) -> str:
    """Returns a view as HTML; the same view gives the same text. What users wrote is escaped."""
    return _template().render(view=view, style=Markup(_asset("view.css")))


def drawing(figure: Figure, text: str, scale: float = 1.4) -> PageImage:
    """Returns a figure as a picture that stays sharp at any size.

    Args:
        figure: the drawing.
        text: what it shows.
        scale: how much larger than in print it is shown: letters in a column of a journal are small.
    """
    stream = io.BytesIO()
    figure.savefig(stream, **_SVG)
    return PageImage(data_url("image/svg+xml", stream.getvalue()), text, round(scale * _INCH * figure.get_figwidth()))


def photograph(pixels: Array, text: str) -> PageImage:
    """Returns pixels, bytes of shape (height, width, 3), as a picture."""
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=88)
    return PageImage(data_url("image/jpeg", stream.getvalue()), text)


def picture_file(path: Path, text: str) -> PageImage:
    """Returns a PNG or GIF file as a picture."""
    return PageImage(data_url(f"image/{path.suffix.removeprefix('.')}", path.read_bytes()), text)


def data_url(kind: str, content: bytes) -> str:
    """Returns a URL that holds its content."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


@cache
def _template() -> Template:
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(_asset("view.html.j2"))


def _asset(name: str) -> str:
    return (resources.files("nhtrack.presentation") / "assets" / name).read_text(encoding="utf-8")
