"""One control period of ideal robots, compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled, compiled_inside
from nhtrack.simulation.engine import COMMAND, FINE, STATE, Track, copy, fill, write_track
from nhtrack.simulation.integrator import advance
from nhtrack.simulation.plant import Floor, Plant, demand_of, predicted_utilisation, saturated

# A robot this far away [m], this fast [m/s] or turned this far [rad] is out of its law's hands; sums and squares of it
# are still finite.
RUNAWAY = 1e12


class Integrator(NamedTuple):
    """What does not change while ideal robots drive.

    Attributes:
        dt: control period [s].
        plant: reduced model of what the wheels would be.
        floor: what they would stand on.
        measured: whether telemetry is written.
        first_body: 1 where the root is virtual and has no wheels, else 0.
        keep_going: whether a simulation that runs away may be lost.
    """

    dt: float
    plant: Plant
    floor: Floor
    measured: bool
    first_body: int
    keep_going: bool


class Flow(NamedTuple):
    """State of b simulations of n ideal robots; arrays as in `nhtrack.simulation.engine.Motion`."""

    g: np.ndarray
    xi: np.ndarray
    g_before: np.ndarray
    xi_before: np.ndarray
    u: np.ndarray
    telemetry: np.ndarray
    fault: np.ndarray
    lost: np.ndarray


@compiled_inside
def step_flow(integrator: Integrator, flow: Flow, b: int, u: np.ndarray) -> bool:
    """Advances one simulation by the exact flow; returns whether it can go on.

    Args:
        integrator: what does not change.
        flow: of all simulations; changed.
        b: which of them.
        u: accelerations commanded, shape (n, 2).
    """
    if flow.lost[b]:
        return True
    for i in range(u.shape[0]):
        if not integrator.keep_going and not (math.isfinite(u[i, 0]) and math.isfinite(u[i, 1])):
            flow.fault[b, 0], flow.fault[b, 1] = COMMAND, i
            return False
    near = True
    for i in range(u.shape[0]):
        copy(flow.u[b, i], u[i])
        copy(flow.g_before[b, i], flow.g[b, i])
        copy(flow.xi_before[b, i], flow.xi[b, i])
        advance(flow.g[b, i], flow.xi[b, i], u[i], integrator.dt)
        for c in range(3):
            x, v = flow.g[b, i, c], flow.xi[b, i, c]
            if not (math.isfinite(x) and math.isfinite(v)) and flow.fault[b, 0] == FINE:
                flow.fault[b, 0], flow.fault[b, 1] = STATE, i
            near = near and abs(x) < RUNAWAY and abs(v) < RUNAWAY
    if integrator.keep_going:
        if not near:
            _stop(flow, b)
    elif flow.fault[b, 0] != FINE:
        return False
    if integrator.measured and not flow.lost[b]:
        measure_flow(integrator, flow, b)
    return True


@compiled_inside
def _stop(flow: Flow, b: int) -> None:
    """Lets a simulation that has run away stand where it was."""
    flow.lost[b] = True
    for i in range(flow.g.shape[1]):
        copy(flow.g[b, i], flow.g_before[b, i])
        fill(flow.xi[b, i], 0.0)
        fill(flow.telemetry[b, i], math.nan)


@compiled_inside
def measure_flow(integrator: Integrator, flow: Flow, b: int) -> None:
    """Writes what wheels would have to do for the motion at the end of the period."""
    plant, floor = integrator.plant, integrator.floor
    if integrator.first_body:
        fill(flow.telemetry[b, 0], math.nan)
    for i in range(integrator.first_body, flow.g.shape[1]):
        row, g, xi, u = flow.telemetry[b, i], flow.g[b, i], flow.xi[b, i], flow.u[b, i]
        g_0, xi_0 = flow.g_before[b, i], flow.xi_before[b, i]
        first = demand_of(plant, floor, g_0[2], xi_0[0], xi_0[2], u[0], u[1])
        last = demand_of(plant, floor, g[2], xi[0], xi[2], u[0], u[1])
        used_0 = predicted_utilisation(plant, floor, g_0[0], g_0[1], g_0[2], first.force, first.load)
        used = predicted_utilisation(plant, floor, g[0], g[1], g[2], last.force, last.load)
        fill(row, 0.0)
        for wheel in range(2):
            speed = (xi[0] + (2 * wheel - 1) * plant.half_separation * xi[2]) / plant.radius
            line, torque = speed / plant.no_load_speed, last.torque[wheel]
            held = saturated(torque, line, plant.stall_torque, plant.torque_limit, 0.0)
            row[wheel] = row[2 + wheel] = torque
            row[4 + wheel] = 1.0 if held != torque else 0.0
            row[6 + wheel] = speed
            row[8 + wheel] = last.load[wheel]
            row[13 + wheel] = row[15 + wheel] = max(used_0[wheel], used[wheel])


@compiled
def step_flows(integrator: Integrator, flow: Flow, u: np.ndarray) -> None:
    """Advances all simulations by the exact flow; u of shape (b, n, 2)."""
    for b in range(flow.g.shape[0]):
        step_flow(integrator, flow, b, u[b])


@compiled
def measure_flows(integrator: Integrator, flow: Flow) -> None:
    """Writes the telemetry of all simulations."""
    for b in range(flow.g.shape[0]):
        measure_flow(integrator, flow, b)


@compiled
def drive_flows(integrator: Integrator, flow: Flow, u: np.ndarray, track: Track) -> None:
    """Drives all simulations by inputs known beforehand, shape (k, b, n, 2), until one goes wrong."""
    for b in range(flow.g.shape[0]):
        for k in range(u.shape[0]):
            if not step_flow(integrator, flow, b, u[k, b]):
                break
            write_track(track, k, b, flow.g[b], flow.xi[b], flow.telemetry[b])
