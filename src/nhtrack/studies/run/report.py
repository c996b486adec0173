"""The page of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nhtrack.presentation.thinned import thinned
from nhtrack.recording import Recording
from nhtrack.report.data import payload
from nhtrack.report.page import Page, render_page, write_page
from nhtrack.report.scenario_listing import meanings, yaml_text
from nhtrack.report.summary_text import about, event_spans, run_verdicts, tiles
from nhtrack.report.timed import SCRIPTS, SECTIONS, timed_contents, with_film

_REPEAT = "With the same versions, this repeats the run to the last bit, in the folder of this page:"
_SCENARIO = "So does the scenario above, saved as a file:"


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


def write_run_page(recording: Recording, summary: Mapping[str, Any], path: Path, extras: Extras | None = None) -> Path:
    """Writes the page of a run; the file appears under its name only once it is whole.

    Args:
        recording: the run.
        summary: its figures (`nhtrack.analysis.metrics.summary`), with `warnings` where there are any.
        path: file to write.
        extras: what else to show.
    """
    return write_page(run_page(recording, summary, extras or Extras()), path)


def render_run_page(recording: Recording, summary: Mapping[str, Any], extras: Extras | None = None) -> str:
    """Returns the page of a run as HTML; the same run gives the same bytes. Arguments as `write_run_page`."""
    return render_page(run_page(recording, summary, extras or Extras()))


def run_page(recording: Recording, summary: Mapping[str, Any], extras: Extras) -> Page:
    """Returns what the page of a run shows. Arguments as `write_run_page`."""
    recording = thinned(recording)
    data, film = with_film(payload(recording, event_spans(summary)), recording, extras.film)
    outcome, scenario = recording.outcome, recording.scenario.model_dump(mode="json")
    return Page(
        "run.html.j2",
        recording.name,
        SECTIONS | {"scenario": "Scenario"},
        run_verdicts(summary, about(recording)),
        [(_REPEAT, "nhtrack run recording.nc"), (_SCENARIO, "nhtrack run scenario.yaml")],
        recording.versions,
        description=recording.scenario.description,
        tiles=tiles(summary),
        alarm="" if outcome == "completed" else f"This run did not complete: {outcome}.",
        warnings=list(summary.get("warnings", ())),
        facts=_facts(recording, data["backend"]),
        scripts=SCRIPTS,
        data=data,
        contents=timed_contents(recording, data)
        | {
            "film": film,
            "no_film": extras.no_film,
            "yaml": yaml_text(scenario),
            "keys": meanings(scenario, extras.schema),
        },
    )


def _facts(recording: Recording, backend: str) -> list[tuple[str, str]]:
    facts = {"backend": backend, "seed": recording.seed, "SHA-256 of the compiled model": recording.model_hash or None}
    return [(name, str(value)) for name, value in facts.items() if value is not None]
