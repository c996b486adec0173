"""The page: template, styles, scripts and the run's numbers in one file that loads nothing else."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from nhtrack.plots.style import CROWD
from nhtrack.recording import Recording, atomic_path
from nhtrack.report.data import DIGITS, frame_rows, payload
from nhtrack.report.graph import graph_svg
from nhtrack.report.keys import meanings, yaml_text
from nhtrack.report.words import tiles, verdicts


@dataclass(frozen=True)
class Extras:
    """What a page shows that neither the recording nor the summary knows.

    Attributes:
        film: an MP4 file to embed, or None.
        no_film: why there is none.
        schema: JSON Schema of scenario files, which describes their keys; empty to leave the descriptions out.
    """

    film: Path | None = None
    no_film: str = "none was asked for"
    schema: Mapping[str, Any] = field(default_factory=dict)


def write(recording: Recording, summary: Mapping[str, Any], path: Path, extras: Extras | None = None) -> Path:
    """Writes the page of a run; the file appears under its name only once it is whole.

    Args:
        recording: the run.
        summary: its figures (`nhtrack.metrics.summary`), with `warnings` where there are any.
        path: file to write.
        extras: what else to show.
    """
    with atomic_path(path) as temporary:
        temporary.write_text(render(recording, summary, extras), encoding="utf-8")
    return path


def render(recording: Recording, summary: Mapping[str, Any], extras: Extras | None = None) -> str:
    """Returns the page of a run as HTML; the same run gives the same bytes. Arguments as `write`."""
    given, data = extras or Extras(), payload(recording)
    scripts = {"plotly": _plotly(), "script": _script()}
    return _environment().get_template("template.html.j2").render(
        **scripts,
        **_contents(recording, summary),
        hashes=[_hash(text) for text in scripts.values()],
        style=Markup(_asset("report.css")),
        data=data,
        groups=_groups(data["panels"]),
        film=None if given.film is None else base64.b64encode(given.film.read_bytes()).decode(),
        no_film=given.no_film,
        keys=meanings(recording.scenario, given.schema),
    )  # fmt: skip


def _contents(recording: Recording, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what the template writes out in words, tables and SVG."""
    attributes = recording.dataset.attrs
    return {
        "title": recording.name,
        "description": recording.scenario.get("description", ""),
        "outcome": recording.outcome,
        "tiles": tiles(summary),
        "verdicts": verdicts(summary),
        "warnings": list(summary.get("warnings", ())),
        "crowd": len(recording.robots) - 1 > CROWD,
        "backend": recording.backend,
        "scales": {"length": recording.length_scale, "time": recording.time_scale},
        "thinning": {"rows": len(recording.time), "frames": len(frame_rows(recording)), "digits": DIGITS},
        "graph": graph_svg(recording.parents),
        "parents": recording.parents,
        "yaml": yaml_text(recording.scenario),
        "versions": recording.versions,
        "model_hash": attributes.get("model_hash", ""),
        "seed": attributes.get("seed"),
    }


def _groups(panels: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the headings over the panels, each with its panels and whether any of them has a logarithmic axis."""
    headings = list(dict.fromkeys(panel["group"] for panel in panels))
    grouped = [(name, [panel for panel in panels if panel["group"] == name]) for name in headings]
    return [
        {"name": name, "panels": members, "logarithmic": any(panel["decades"] for panel in members)}
        for name, members in grouped
    ]


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("nhtrack.report", "assets"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return environment


@cache
def _plotly() -> Markup:
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())


@cache
def _script() -> Markup:
    """Returns the page's own scripts as one function of their own: no name of theirs is global."""
    parts = "\n".join(_asset(name) for name in ("plots.js", "report.js"))
    return Markup(f"(() => {{\n'use strict';\n{parts}}})();\n")


def _asset(name: str) -> str:
    return (resources.files("nhtrack.report") / "assets" / name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Returns what the page's Content-Security-Policy knows a script by; no other script runs."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
