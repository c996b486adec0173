"""What the families of a campaign's tree mean together: their names, and inputs without a value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from nhtrack.config.checks import Clock, input_findings
from nhtrack.config.families import SETS
from nhtrack.config.family_sections import GridFamily
from nhtrack.config.tree import Path, lookup
from nhtrack.section import Finding

_TIMES = 100  # at which points of a grid are tried that are none of its corners


def family_findings(tree: Mapping[str, Any], clock: Clock) -> Iterator[Finding]:
    """Yields families of one name, and inputs that have no value at some time.

    Args:
        tree: of a campaign; anything in it may be of the wrong type.
        clock: its times.
    """
    families, seen = lookup(tree, ("families",)), set[str]()
    for i, family in enumerate(families if isinstance(families, list) else ()):
        at: Path = ("families", i)
        named = lookup(family, ("name",))
        for name in SETS.get(family, (family,)) if isinstance(family, str) else (named,):
            if isinstance(name, str) and name in seen:
                yield at, f"two families are called {name!r}"
            seen.add(str(name))
        if not isinstance(family, Mapping):
            continue
        if "grid" in family:
            yield from _grid_findings(family, clock, at)
        else:
            yield from input_findings(family.get("input", family), clock, (*at, "input") if "input" in family else at)


def _grid_findings(given: Mapping[str, Any], clock: Clock, at: Path) -> Iterator[Finding]:
    """Yields the first point of a grid at which a formula has no value: corners in all periods, others in some."""
    try:
        family = GridFamily.model_validate(given)
    except ValidationError:
        return  # told where the section is judged
    points = family.points
    corners = {*list(points)[:1], *list(points)[-1:]}
    times = clock.times
    few = None if times is None else times[:: max(1, len(times) // _TIMES)]
    told = set[Path]()
    for name in points:
        leader = family.leader(name)
        for path, message in type(leader.input).findings(
            leader.input.model_dump(), times if name in corners else few
        ):
            if path not in told:
                yield (*at, *path), f"{message}, at the point {name!r}"
            told.add(path)
