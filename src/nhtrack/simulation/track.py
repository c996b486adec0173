"""What open-loop inputs make of simulations, written period by period."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.simulation import columns
from nhtrack.simulation.motion import copy
from nhtrack.simulation.state import Driven, State


class Track(NamedTuple):
    """Where simulations write what open-loop inputs make of them, for k periods.

    Attributes:
        g: poses at the end of each period, shape (k, b, n, 3).
        xi: twists, likewise.
        telemetry: shape (k, b, n, 18), or no periods where nobody asks.
        written: periods finished, shape (b,).
    """

    g: np.ndarray
    xi: np.ndarray
    telemetry: np.ndarray
    written: np.ndarray


def make_track(periods: int, g: np.ndarray, telemetry: np.ndarray, measured: bool) -> Track:
    """Returns room for so many periods of simulations with poses `g` and a row `telemetry` for each robot."""
    return Track(
        np.empty((periods, *g.shape)),
        np.empty((periods, *g.shape)),
        np.empty((periods if measured else 0, *telemetry.shape)),
        np.zeros(len(g), dtype=np.int64),
    )


@compiled_inside
def write_track(track: Track, k: int, b: int, g: np.ndarray, xi: np.ndarray, telemetry: np.ndarray) -> None:
    """Writes a period of a simulation."""
    for i in range(g.shape[0]):
        copy(track.g[k, b, i], g[i])
        copy(track.xi[k, b, i], xi[i])
        if track.telemetry.shape[0] > 0:
            copy(track.telemetry[k, b, i], telemetry[i])
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
    held = columns.named(rows) if len(rows) else {}
    return Driven(time, np.concatenate([begin.g[None], g]), np.concatenate([begin.xi[None], xi]), held)
