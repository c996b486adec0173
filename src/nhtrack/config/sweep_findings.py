"""What is wrong between the keys of a sweep."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from nhtrack.config.changes import value_text
from nhtrack.config.grid import words_of
from nhtrack.config.sweep import METRICS, MOST_RUNS, ON_WHEELS, Sweep, group_size
from nhtrack.config.tree import Path, lookup
from nhtrack.errors import did_you_mean
from nhtrack.section import Finding


def sweep_findings(tree: Any, *_: object) -> Iterator[Finding]:
    """Yields what is wrong between the keys of a sweep's tree; what of its scenario, `nhtrack.config.sweep_trials`."""
    axes, sample = lookup(tree, ("axes",)), lookup(tree, ("sample",))
    if not isinstance(axes, Mapping):
        return
    for key, axis in axes.items():
        if isinstance(fixed := lookup(tree, ("set",)), Mapping) and key in fixed:
            yield ("axes", key), "this key is in `set`, too; keep one"
        if isinstance(axis, list):
            texts = [value_text(value) for value in axis]
            first = {text: i for i, text in reversed([*enumerate(texts)])}
            twice = (i for i, text in enumerate(texts) if first[text] < i)
            yield from ((("axes", key, i), f"{texts[i]} is given twice; keep one") for i in twice)
        if sample is None and isinstance(axis, Mapping) and {"uniform", "log_uniform", "normal"} & {*axis}:
            yield ("axes", key), "numbers that are drawn need `sample: {count: ...}`"
    expressions = lookup(tree, ("expressions",))
    for name in expressions if isinstance(expressions, Mapping) else ():
        if name in axes:
            yield ("expressions", name), "an axis has this name; choose another"
    yield from _unknown_pairs(tree)
    seeded = "seed" in axes
    if seeded and isinstance(repeats := lookup(tree, ("repeats",)), int) and repeats > 1:
        yield ("repeats",), "runs that repeat a point have seeds of their own; leave out this or the axis `seed`"
    yield from _too_many(tree, axes, sample)


def _unknown_pairs(tree: Mapping[str, Any]) -> Iterator[Finding]:
    """Yields names of pairs that are no columns of the table, and pairs of one column."""
    own, pairs, asked = lookup(tree, ("expressions",), {}), lookup(tree, ("pareto",)), lookup(tree, ("metrics",))
    columns = [*(asked if isinstance(asked, list) else METRICS), *(own if isinstance(own, Mapping) else ())]
    for i, pair in enumerate(pairs if isinstance(pairs, list) else ()):
        for k, name in enumerate(pair if isinstance(pair, list) else ()):
            if isinstance(name, str) and name not in columns:
                yield ("pareto", i, k), f"{name!r} is no column of the table; {did_you_mean(name, columns)}"
        if isinstance(pair, list) and len(pair) == 2 and pair[0] == pair[1]:
            yield ("pareto", i, 1), "a pair is of two columns; this is the first again"


def _too_many(tree: Any, axes: Mapping[str, Any], sample: Any) -> Iterator[Finding]:
    """Yields that there are more runs than anybody waits for."""
    if isinstance(sample, Mapping):
        count = sample.get("count")
        points = count * group_size(sample.get("method", ""), len(axes)) if isinstance(count, int) else None
    else:
        points = math.prod(_length(axis) for axis in axes.values())
    repeats = lookup(tree, ("repeats",), 1)
    if isinstance(points, int) and isinstance(repeats, int) and points * repeats > MOST_RUNS:
        wanted = f"{points * repeats:.3g}" if points * repeats < 10**300 else "endlessly many"
        yield ("axes",), f"{wanted} runs; a sweep has at most {MOST_RUNS:.0e}"


def _length(axis: Any) -> int:
    if isinstance(axis, list):
        return len(axis)
    if isinstance(axis, Mapping):
        count = axis.get("count", len(axis.get("choices") or (1,)))
        return count if isinstance(count, int) else 1
    return 1


def backend_findings(sweep: Sweep, backend: str) -> Iterator[Finding]:
    """Yields metrics that nothing is known of where no run has wheels."""
    if backend != "ideal" or "backend" in sweep.axes:
        return
    asked: list[tuple[Path, str]] = [(("metrics", i), name) for i, name in enumerate(sweep.metrics or ())]
    asked += [(("expressions", name), word) for name, text in sweep.expressions.items() for word in words_of(text)]
    asked += [(("pareto", i, k), name) for i, pair in enumerate(sweep.pareto) for k, name in enumerate(pair)]
    for path, name in asked:
        if name in ON_WHEELS:
            yield path, f"{name} is known of runs on wheels only, and `backend` is ideal"
