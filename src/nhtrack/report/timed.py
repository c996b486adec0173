"""What pages with a time slider have in common: film, floor, curves over time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording
from nhtrack.report.data import DIGITS, frame_rows
from nhtrack.report.film import read_film
from nhtrack.report.graph import graph_svg

SCRIPTS = ("floor.js", "panels.js", "film.js", "player.js")
SECTIONS = {"film": "Film", "floor-section": "Floor", "series": "Over time", "graph-section": "Who tracks whom"}


def with_film(data: dict[str, Any], recording: Recording, path: Path | None) -> tuple[dict[str, Any], Any]:
    """Returns a payload that knows how fast the film is, and the film, or None where there is none.

    Args:
        data: see `nhtrack.report.data.payload`.
        recording: what the film shows.
        path: the film, or None.
    """
    film = None if path is None else read_film(path, recording)
    return data | {"film_speed": None if film is None else film.speed}, film


def timed_contents(recording: Recording, data: dict[str, Any]) -> dict[str, Any]:
    """Returns what `timed.html.j2` writes apart from the film.

    Args:
        recording: what is shown.
        data: its payload.
    """
    return {
        "groups": _groups(data["panels"]),
        "bends": any(panel["decades"] or panel["knee"] for panel in data["panels"]),
        "knees": any(panel["knee"] for panel in data["panels"]),
        "crowd": len(recording.robots) - 1 > CROWD,
        "backend": recording.backend,
        "scales": {"length": recording.length_scale, "time": recording.time_scale},
        "thinning": {"rows": recording.rows, "frames": len(frame_rows(recording)), "digits": DIGITS},
        "graph": graph_svg(recording.parents, [robot["colour"] for robot in data["robots"]]),
        "parents": recording.parents,
    }


def _groups(panels: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Returns the headings over the panels, each with its panels."""
    headings = list(dict.fromkeys(panel["group"] for panel in panels))
    return [
        {"name": name, "panels": [panel for panel in panels if panel["group"] == name]} for name in headings
    ]
