"""What the scripts that write pages of docs/ share: tables, and the places between markers that they go to."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Returns a Markdown table."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [header, ["---"] * len(header), *rows])


def fill(page: Path, parts: Mapping[str, str]) -> None:
    """Writes parts of a page anew, each between `<!-- begin: marker -->` and `<!-- end: marker -->`.

    Args:
        page: a Markdown file; what stands outside the markers is left as it is.
        parts: what to write, by marker.

    Raises:
        ValueError: the page lacks a pair of markers, or has it twice; nothing is written.
    """
    text = page.read_text(encoding="utf-8")
    for marker, content in parts.items():
        begin, end = f"<!-- begin: {marker} -->", f"<!-- end: {marker} -->"
        pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
        text, found = pattern.subn(f"{begin}\n{content}\n{end}".replace("\\", r"\\"), text)
        if found != 1:
            raise ValueError(f"{page.name}: expected one {begin} ... {end}, found {found}")
    page.write_text(text, encoding="utf-8")
