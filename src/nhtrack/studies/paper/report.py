"""The page of the paper's examples: what the paper claims, what came of it, and its figures drawn again."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from nhtrack.presentation.numbers import listed, share
from nhtrack.presentation.shown import within
from nhtrack.report.page import Page, write_page
from nhtrack.settling import settling_limits

NEAR = 0.05  # share of the farthest start, within which followers that did not settle are near their places
MARKS = {"reached": "as claimed", "near": "near, not at zero", "missed": "not as claimed"}

_INTRODUCTION = (
    "The five examples of He and Geng, Trajectory tracking control for nonholonomic mobile robots under arbitrary "
    "reference input, on wheels that friction alone holds, beside the ideal integrator."
)


@dataclass(frozen=True)
class WordTable:
    """A table in words: its caption, its header and its rows, the first `words` columns to the left."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1


@dataclass(frozen=True)
class ExampleSection:
    """What the page says of one example.

    Attributes:
        number: in the paper.
        title: what it is about.
        text: what happens in it.
        claim: what the paper says of it.
        mark: what came of the claim, a key of `MARKS`.
        verdicts: the same in sentences.
        figures: captions and PNG files.
        merits: a row for each of its scenarios, under `HEADER`.
        tables: what else was measured.
        settings: input, law, gains and scales, a line each.
    """

    number: int
    title: str
    text: str
    claim: str
    mark: str
    verdicts: Sequence[str]
    figures: Sequence[tuple[str, Path]]
    merits: Sequence[Sequence[str]]
    tables: Sequence[WordTable]
    settings: Sequence[str]


HEADER = (
    "scenario",
    "farthest start, on the floor",
    "late position, ideal",
    "late position, wheels",
    "late heading",
    "gap to the twin, RMS, on the floor",
    "peak friction utilisation",
)


def write_paper_page(sections: Sequence[ExampleSection], command: str, versions: Mapping[str, str], path: Path) -> Path:
    """Writes the page of the paper's examples; the file appears under its name only once it is whole.

    Args:
        sections: the examples.
        command: what runs them again.
        versions: of what ran them.
        path: file to write.
    """
    return write_page(paper_page(sections, command, versions), path)


def paper_page(sections: Sequence[ExampleSection], command: str, versions: Mapping[str, str]) -> Page:
    """Returns what the page of the paper's examples shows. Arguments as `write_paper_page`."""
    return Page(
        "paper.html.j2",
        "The paper's examples on wheels",
        {"overview": "Overview"} | {f"example-{each.number}": f"Example {each.number}" for each in sections},
        paper_verdicts(sections),
        [("With the same versions, this runs the same:", command)],
        versions,
        description=_INTRODUCTION,
        tiles=[(name, _of(sections, mark)) for mark, name in MARKS.items()],
        plots=False,
        scripts=("still.js",),
        contents={
            "sections": sections,
            "settled": within(settling_limits(1.0)),
            "near": share(NEAR),
            "header": HEADER,
            "marks": MARKS,
            "pictures": _pictures(sections),
        },
    )


def paper_verdicts(sections: Sequence[ExampleSection]) -> list[str]:
    """Returns sentences on which examples came out as the paper says."""
    told = {
        "reached": "In {} it is as claimed: every follower settles, position and heading.",
        "near": "In {} followers come near their places and stay near them, but do not settle.",
        "missed": "In {} followers do not come near their places.",
    }
    found = []
    for mark, sentence in told.items():
        numbers = [str(each.number) for each in sections if each.mark == mark]
        if numbers:
            found.append(sentence.format(f"Example{'s' * (len(numbers) > 1)} {listed(numbers)}"))
    return found


def _of(sections: Sequence[ExampleSection], mark: str) -> str:
    return f"{sum(each.mark == mark for each in sections)} of {len(sections)}"


class Picture(NamedTuple):
    """A PNG file as it stands in the page: its content, and how wide it is there [px]."""

    base64: str
    width: int


def _pictures(sections: Sequence[ExampleSection]) -> dict[Path, Picture]:
    """Returns the figures as they stand in the page, by their files, all letters of one size."""
    contents = {file: file.read_bytes() for each in sections for _, file in each.figures}
    return {file: Picture(base64.b64encode(png).decode(), _width(png)) for file, png in contents.items()}


def _width(png: bytes) -> int:
    """Returns how wide a figure is at the size it was drawn for [px], 96 to an inch; its chunk `pHYs` tells that."""
    place = png.index(b"pHYs") + 4
    per_metre = int.from_bytes(png[place : place + 4])
    return round(int.from_bytes(png[16:20]) * 96 / (0.0254 * per_metre))
