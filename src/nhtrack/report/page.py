"""What all pages have in common: template, styles, scripts and numbers in one file that loads nothing else."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from nhtrack.files.atomic import atomic_path

_MEASURE = re.compile(r"\d (?:[^\W\d]{1,4}\b(?: [ms]\b)?|[%°])")  # a number and its unit


@dataclass(frozen=True)
class Page:
    """What a page shows, whatever it is about.

    Attributes:
        template: file in `assets/` that says what stands between verdict and provenance.
        title: what the page is about.
        sections: titles of the template's sections by their ids, for the list at the head of the page.
        verdicts: what came of it, in sentences.
        commands: what repeats it, each with a sentence that leads to it.
        versions: of what moved the numbers.
        description: a line below the title.
        tiles: names and values of the figures that stand at the head.
        alarm: what went so wrong that everything else has to be read with it in mind; empty where nothing did.
        warnings: further sentences, folded up where there are many.
        facts: names and values of what else decides the numbers.
        scripts: files in `assets/` that are joined to the page's script, after `common.js`.
        plots: whether Plotly is needed.
        data: what the scripts draw, ready for JSON.
        contents: what else the template writes.
    """

    template: str
    title: str
    sections: Mapping[str, str]
    verdicts: Sequence[str]
    commands: Sequence[tuple[str, str]]
    versions: Mapping[str, str]
    description: str = ""
    tiles: Sequence[tuple[str, str]] = ()
    alarm: str = ""
    warnings: Sequence[str] = ()
    facts: Sequence[tuple[str, str]] = ()
    scripts: tuple[str, ...] = ()
    plots: bool = True
    data: Mapping[str, Any] = field(default_factory=dict)
    contents: Mapping[str, Any] = field(default_factory=dict)


def write_page(page: Page, path: Path) -> Path:
    """Writes a page as HTML; the file appears under its name only once it is whole."""
    with atomic_path(path) as temporary:
        temporary.write_text(render_page(page), encoding="utf-8")
    return path


def render_page(page: Page) -> str:
    """Returns a page as HTML; the same page gives the same bytes. What users wrote is escaped by the templates."""
    scripts = [*([_plotly()] if page.plots else []), _script("common.js", *page.scripts)]
    return (
        _environment()
        .get_template(page.template)
        .render(
            **page.contents,
            page=page,
            data=page.data,
            scripts=scripts,
            hashes=[_hash(script) for script in scripts],
            style=Markup(_asset("report.css")),
        )
    )


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("nhtrack.report", "assets"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters["whole"] = _whole
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return environment


def _whole(text: str) -> str:
    """Returns a sentence in which no line ends between a number and its unit."""
    return _MEASURE.sub(lambda found: found[0].replace(" ", "\N{NO-BREAK SPACE}"), text)


@cache
def _plotly() -> Markup:
    """Returns Plotly, its one large function in parentheses: browsers compile it as they read it, not read it twice."""
    from plotly.offline import get_plotlyjs

    head, arrow, body = get_plotlyjs().rpartition("this, () => {")
    return Markup(f"{head}this, (() => {{{body.rstrip().removesuffix('}));')}}})));" if arrow else body)


@cache
def _script(*names: str) -> Markup:
    """Returns the page's own scripts as one function of their own: no name of theirs is global."""
    parts = "\n".join(_asset(name) for name in names)
    return Markup(f"(() => {{\n'use strict';\n{parts}}})();\n")


def _asset(name: str) -> str:
    return (resources.files("nhtrack.report") / "assets" / name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Returns what the page's Content-Security-Policy knows a script by; no other script runs."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
