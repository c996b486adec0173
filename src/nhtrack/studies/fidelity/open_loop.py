"""MuJoCo's robot against the ideal one under the same input: error and its order, with and without rate correction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nhtrack.arrays import Array
from nhtrack.effects.planar_base import PlanarBase
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import PoseError, Weave, middles, open_loop_error, open_loop_errors, weave_within

TIMESTEPS = (0.004, 0.002, 0.001, 0.0005)  # [s]
SHARE, DURATION = 0.5, 10.0  # of the motors' limits; [s]

_POSITION, _HEADING = 5e-6, 2e-5  # at 1 ms, with rate correction: of the path; [rad]
_SECOND_ORDER, _FIRST_ORDER = 1.9, 0.9
_UNCORRECTED = 0.02  # of the path


def open_loop(bench: Bench) -> Iterator[Finding]:
    """Yields error and order of a drive at half the motors' limits for 10 s, see `weave_within`.

    Of robots whose casters swivel `swivel_casters` does.
    """
    if bench.swivels:
        return
    weave = weave_within(bench.drive, SHARE, duration=DURATION)
    corrected, plain = (step_errors(bench, weave, rate_correction) for rate_correction in (True, False))
    at_1_ms, path = TIMESTEPS.index(0.001), path_length(weave)
    leapfrog = "leapfrog: poses move by the velocity at the middle of a step, an error of h^2 times curvature and rate"
    slip = "no rate correction: wheels slide sideways at v omega h while they turn"
    yield bench.find("position after 10 s", corrected[at_1_ms].position / path, "1", _POSITION, leapfrog)
    yield bench.find("heading after 10 s", corrected[at_1_ms].heading, "rad", _HEADING, leapfrog)
    for quantity in ("position", "heading"):
        order = _order([getattr(error, quantity) for error in corrected])
        yield bench.find(f"order in the step, {quantity}", order, "1", _SECOND_ORDER, leapfrog, sense="at least")
    yield bench.find("position after 10 s, uncorrected", plain[at_1_ms].position / path, "1", _UNCORRECTED, slip)
    order = _order([error.position for error in plain])
    yield bench.find("order in the step, uncorrected", order, "1", _FIRST_ORDER, slip, sense="at least")


def planar_base(bench: Bench) -> Iterator[Finding]:
    """Yields the error of the same drive on a planar base."""
    weave = weave_within(bench.drive, SHARE, duration=DURATION)
    error = open_loop_error(bench.simulation(effects=(PlanarBase(),)), weave, DURATION)
    cause = "leapfrog, as with the free base"
    yield bench.find("planar base: position after 10 s", error.position / path_length(weave), "1", _POSITION, cause)
    yield bench.find("planar base: heading after 10 s", error.heading, "rad", _HEADING, cause)


def step_errors(bench: Bench, weave: Weave, rate_correction: bool) -> list[PoseError]:
    """Returns the errors of a drive at each of `TIMESTEPS`."""
    simulations = (bench.simulation(timestep=h, rate_correction=rate_correction) for h in TIMESTEPS)
    return open_loop_errors(simulations, weave, DURATION)


def path_length(weave: Weave) -> float:
    """Returns the length of a drive's path [m]."""
    v: Array = weave.rates(middles(DURATION, 0.001))[0]
    return float(np.abs(v).mean() * DURATION)


def _order(found: list[float]) -> float:
    """Returns p of errors that fall like h^p over `TIMESTEPS`, a least-squares fit."""
    return float(np.polyfit(np.log(TIMESTEPS), np.log(np.maximum(found, 1e-300)), 1)[0])
