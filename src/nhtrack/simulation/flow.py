"""One control period of ideal robots, compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside, compiled_loop
from nhtrack.simulation.faults import COMMAND, is_lost
from nhtrack.simulation.integrator import advance
from nhtrack.simulation.motion import copy, fill
from nhtrack.simulation.plant import Floor, Plant, demand_of, predicted_utilisation, saturated
from nhtrack.simulation.track import Track, write_track


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
    """State of b simulations of n ideal robots; arrays as in `Motion` of wheels, `qpos` and `touch` empty."""

    g: np.ndarray
    xi: np.ndarray
    g_before: np.ndarray
    xi_before: np.ndarray
    u: np.ndarray
    qpos: np.ndarray
    telemetry: np.ndarray
    touch: np.ndarray
    fault: np.ndarray
    lost: np.ndarray
    reach: np.ndarray


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
    for i in range(u.shape[0]):
        copy(flow.u[b, i], u[i])
        copy(flow.g_before[b, i], flow.g[b, i])
        copy(flow.xi_before[b, i], flow.xi[b, i])
        advance(flow.g[b, i], flow.xi[b, i], u[i], integrator.dt)
    if is_lost(flow.g[b], flow.xi[b], flow.reach[b], flow.fault[b]):
        if not integrator.keep_going:
            return False
        _stop(flow, b)
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
    g, xi, u, rows = flow.g, flow.xi, flow.u, flow.telemetry  # single numbers are read: a view of a row costs more
    for i in range(integrator.first_body, g.shape[1]):
        u_x, u_theta = u[b, i, 0], u[b, i, 1]
        x, y, theta, v, omega = g[b, i, 0], g[b, i, 1], g[b, i, 2], xi[b, i, 0], xi[b, i, 2]
        x_0, y_0, theta_0 = flow.g_before[b, i, 0], flow.g_before[b, i, 1], flow.g_before[b, i, 2]
        v_0, omega_0 = flow.xi_before[b, i, 0], flow.xi_before[b, i, 2]
        first = demand_of(plant, floor, theta_0, v_0, omega_0, u_x, u_theta)
        last = demand_of(plant, floor, theta, v, omega, u_x, u_theta)
        used_0 = predicted_utilisation(plant, floor, x_0, y_0, theta_0, first.force, first.load)
        used = predicted_utilisation(plant, floor, x, y, theta, last.force, last.load)
        rows[b, i, 10] = rows[b, i, 11] = rows[b, i, 12] = rows[b, i, 17] = 0.0
        rows[b, i, 18] = rows[b, i, 19] = 0.0
        for wheel in range(2):
            speed = (v + (2 * wheel - 1) * plant.half_separation * omega) / plant.radius
            line, torque = speed / plant.no_load_speed, last.torque[wheel]
            held = saturated(torque, line, plant.stall_torque, plant.torque_limit, 0.0)
            rows[b, i, wheel] = rows[b, i, 2 + wheel] = torque
            rows[b, i, 4 + wheel] = 1.0 if held != torque else 0.0
            rows[b, i, 6 + wheel] = speed
            rows[b, i, 8 + wheel] = last.load[wheel]
            rows[b, i, 13 + wheel] = rows[b, i, 15 + wheel] = max(used_0[wheel], used[wheel])


@compiled_loop
def measure_flows(integrator: Integrator, flow: Flow) -> None:
    """Writes the telemetry of all simulations."""
    for b in range(flow.g.shape[0]):
        measure_flow(integrator, flow, b)


@compiled_loop
def drive_flows(integrator: Integrator, flow: Flow, u: np.ndarray, track: Track) -> None:
    """Drives all simulations by inputs known beforehand, shape (k, b, n, 2), until one goes wrong."""
    for b in range(flow.g.shape[0]):
        for k in range(u.shape[0]):
            if not step_flow(integrator, flow, b, u[k, b]):
                break
            write_track(track, k, b, flow)
