"""Parts of a sweep done side by side, also where one of their runs ends every worker that does it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from nhtrack.arrays import Array
from nhtrack.execution import TRIES, Executor, WorkerError
from nhtrack.studies.campaign.tables import save_runs
from nhtrack.studies.sweep.parts import Part, failed_rows, run_part
from nhtrack.studies.sweep.plan import Plan


def do_parts(plan: Plan, parts: Sequence[Part], executor: Executor) -> Iterator[Part]:
    """Does parts and yields each once its rows are written.

    Where a worker ends, the parts that it may have ended with have workers of their own; one that ends `TRIES` of them
    is halved time and again until the run is found, which is a failed row.

    Raises:
        WorkerError: workers end whatever they do, such as of a script without `if __name__ == "__main__":`.
    """
    left = dict(enumerate(parts))
    while left:
        places = list(left)
        try:
            for place, _ in executor([left[each] for each in places], partial(run_part, plan)):
                yield left.pop(places[place])
        except WorkerError as error:
            if not all(lived for _, lived in executor.survived([None], _nothing)):
                raise error
            suspects = [places[place] for place in error.suspects]
            yield from _one_by_one(plan, [left.pop(place) for place in suspects], executor)


class _Piece(NamedTuple):
    """Some runs of a part, and the file of their rows."""

    whole: Part
    part: Part


def _one_by_one(plan: Plan, parts: Sequence[Part], executor: Executor) -> Iterator[Part]:
    """Does parts whose workers ended, or may have, and yields each once its rows are written."""
    pieces = [_Piece(part, part) for part in parts]
    done: dict[Path, list[Part]] = {part.path: [] for part in parts}
    missing = {part.path: len(part.runs) for part in parts}
    while pieces:
        halves = list[_Piece]()
        for place, lived in executor.survived([piece.part for piece in pieces], partial(run_part, plan)):
            whole, part = pieces[place]
            if not lived and len(part.runs) > 1:
                middle = len(part.runs) // 2
                halves += [_Piece(whole, _some(whole, runs)) for runs in (part.runs[:middle], part.runs[middle:])]
                continue
            if not lived:
                save_runs(failed_rows(plan, part.runs, f"ended the process that ran it, {TRIES} times"), part.path)
            done[whole.path].append(part)
            missing[whole.path] -= len(part.runs)
            if not missing[whole.path]:
                _join(whole, done[whole.path])
                yield whole
        pieces = halves


def _some(whole: Part, runs: Array) -> Part:
    return Part(runs, whole.path.with_name(f"{whole.path.stem}-{int(runs[0])}-{int(runs[-1])}.parquet"))


def _join(whole: Part, pieces: Sequence[Part]) -> None:
    """Writes the rows of a part's pieces as those of the part, in its order."""
    if [part.path for part in pieces] == [whole.path]:
        return
    rows = pd.concat([pd.read_parquet(part.path) for part in pieces], ignore_index=True)
    save_runs(rows.set_index("run", drop=False).loc[whole.runs].reset_index(drop=True), whole.path)
    for part in pieces:
        part.path.unlink(missing_ok=True)


def _nothing(task: None) -> None:
    """Does nothing: whether a worker lives through that says whether any would live."""
