"""Robots that touched each other: who, whom, when, for how long and how hard."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nhtrack.analysis.event import Event, Touch
from nhtrack.analysis.spells import begins, joined_spells
from nhtrack.arrays import row_blocks
from nhtrack.recording import Recording


def touches(recording: Recording) -> Iterator[Event]:
    """Yields the contacts of a run, pair by pair; those less than `nhtrack.analysis.spells.GAP` apart are one event.

    Its measure is the largest speed at which the hulls closed in, along the normal of their contact; it begins and ends
    with the rows in which there was contact.
    """
    if "touch" not in recording.dataset:
        return
    time, (row, robot, noted) = recording.time, _noted(recording)
    pairs = np.sort(np.stack([robot, noted[:, 0].astype(int)], axis=-1), axis=-1)
    for pair in np.unique(pairs, axis=0):
        its = (pairs == pair).all(axis=-1)
        yield from _events(recording, pair, row[its], noted[its], begins(time))


def _noted(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns the rows with a contact and the robots that it was noted with, shape (k,), and what was noted of it."""
    table = recording["touch"]
    found = [(np.empty(0, dtype=int), np.empty(0, dtype=int), np.empty((0, table.shape[-1])))]
    for part in row_blocks(len(table), table.nbytes):
        values = table[part].values
        row, robot, slot = np.nonzero(np.isfinite(values[..., 0]))
        found.append((part.start + row, robot, values[row, robot, slot]))
    rows, robots, noted = zip(*found, strict=True)
    return np.concatenate(rows), np.concatenate(robots), np.concatenate(noted)


def _events(
    recording: Recording, pair: np.ndarray, row: np.ndarray, noted: np.ndarray, begin: np.ndarray
) -> Iterator[Event]:
    """Yields the events of a pair that touched in rows, shape (k,), as was noted there, shape (k, components)."""
    time, (one, other) = recording.time, (recording.robots[place] for place in pair)
    holds = np.zeros(len(time), dtype=bool)
    holds[row] = True
    for rows in joined_spells(holds, time):
        _, seconds, impulse, closing, overlap = noted[(row >= rows.start) & (row < rows.stop)].T
        touch = Touch(other, float(seconds.sum()), float(impulse.sum()), float(overlap.max()))
        span = float(begin[rows.start]), float(time[rows.stop - 1])
        yield Event("touched", one, None, *span, "closing speed", float(closing.max()), "m/s", touch)


def touch_place(recording: Recording, event: Event) -> np.ndarray:
    """Returns where two robots were when they began to touch, the middle between them [m], shape (2,)."""
    row = min(int(np.searchsorted(recording.time, event.start, side="right")), len(recording.time) - 1)
    places = [recording.robots.index(name) for name in event.robots]
    return np.asarray(recording["pose"].values[row, places, :2].mean(axis=0))
