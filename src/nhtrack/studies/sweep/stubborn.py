"""Parts of a sweep done side by side, also where one of their runs ends every process that does it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from nhtrack.execution import Executor, Processes, WorkerError
from nhtrack.studies.campaign.tables import save_runs
from nhtrack.studies.sweep.parts import Part, failed_rows, run_part

TRIES = 3  # processes that a run may end before it is a row that says so


def do_parts(parts: Sequence[Part], executor: Executor) -> Iterator[Part]:
    """Does parts and yields each once its rows are written.

    Where a process ends, whichever run it was of, those left are done by themselves, each in a process of its own; a
    part that ends `TRIES` of them is done run by run, and a run that does is a failed row.

    Raises:
        WorkerError: processes end whatever they do, such as of a script without `if __name__ == "__main__":`.
    """
    left = dict(enumerate(parts))
    try:
        for place, _ in executor(parts, run_part):
            yield left.pop(place)
    except WorkerError as error:
        some = len(left) < len(parts)
        for part in left.values():
            if not _alone(part):
                some = _run_by_run(part, some, error)
            some = True
            yield part


def _alone(part: Part) -> bool:
    """Does a part in a process of its own; returns whether one has lived through it."""
    for _ in range(TRIES):
        try:
            list(Processes(1, begin=_begin)([part], run_part))
        except WorkerError:
            continue
        return True
    return False


def _run_by_run(part: Part, some: bool, error: WorkerError) -> bool:
    """Does the runs of a part each by itself and writes the rows of all."""
    rows = list[pd.DataFrame]()
    for run in part.runs:
        one = replace(part, runs=np.array([run]), path=part.path.with_name(f"{part.path.stem}-{run}.parquet"))
        if _alone(one):
            some = True
            rows.append(pd.read_parquet(one.path))
            one.path.unlink()
        elif len(part.runs) == 1 and not some:
            raise error
        else:
            rows.append(failed_rows(part.plan, one.runs, f"ended the process that ran it, {TRIES} times"))
    if not some:
        raise error
    save_runs(pd.concat(rows, ignore_index=True), part.path)
    return True


def _begin() -> None:
    """Does nothing: what is begun so has a process of its own."""
