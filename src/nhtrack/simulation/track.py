"""What open-loop inputs make of simulations, written period by period."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.simulation import columns
from nhtrack.simulation.motion import copy
from nhtrack.simulation.state import Driven, State


class Track(NamedTuple):
    """Where simulations write what open-loop inputs make of them, for k periods.

    Attributes:
        g: poses at the end of each period, shape (k, b, n, 3), or no periods.
        xi: twists, likewise.
        telemetry: shape (k, b, n, WIDTH), or no periods.
        written: periods finished, shape (b,).
    """

    g: np.ndarray
    xi: np.ndarray
    telemetry: np.ndarray
    written: np.ndarray


def make_track(periods: int, motion: Any, *, telemetry: bool) -> Track:
    """Returns room for so many periods of simulations, with or without telemetry; none where nobody asks for any."""
    return Track(
        np.empty((periods, *motion.g.shape)),
        np.empty((periods, *motion.xi.shape)),
        np.empty((periods if telemetry else 0, *motion.telemetry.shape)),
        np.zeros(len(motion.g), dtype=np.int64),
    )


@compiled_inside
def write_track(track: Track, k: int, b: int, motion: Any) -> None:
    """Writes a period of a simulation, and counts it."""
    for i in range(motion.g.shape[1]):
        if track.g.shape[0] > 0:
            copy(track.g[k, b, i], motion.g[b, i])
            copy(track.xi[k, b, i], motion.xi[b, i])
        if track.telemetry.shape[0] > 0:
            copy(track.telemetry[k, b, i], motion.telemetry[b, i])
    track.written[b] = k + 1


def driven(begin: State, dt: float, track: Track, shape: tuple[int, ...]) -> Driven:
    """Returns what a track holds, with the state that it began with.

    Args:
        begin: the state.
        dt: control period [s].
        track: what was driven.
        shape: of the batch.
    """
    g, xi, rows = (values.reshape(len(values), *shape, *values.shape[2:]) for values in track[:3])
    time = begin.t + np.arange(len(g) + 1) * dt
    held = columns.telemetry_of(rows) if len(rows) else {}
    return Driven(time, np.concatenate([begin.g[None], g]), np.concatenate([begin.xi[None], xi]), held)
