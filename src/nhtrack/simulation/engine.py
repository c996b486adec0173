"""One control period on wheels, compiled: commands taken, every unit stepped, states and telemetry read.

What is computed, and why it is second order in the physics step, says `nhtrack.simulation.mujoco`;
`nhtrack.simulation.unit` steps the physics.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside, compiled_loop
from nhtrack.simulation.attitude import heading_of, tilt_of
from nhtrack.simulation.faults import COMMAND, FINE, TIPPED_OVER, is_lost
from nhtrack.simulation.integrator import advance
from nhtrack.simulation.motion import Motion, Place, Wheels, blame, copy, fill
from nhtrack.simulation.telemetry import write_telemetry
from nhtrack.simulation.track import Track, write_track
from nhtrack.simulation.unit import roll

# A robot leaning this far has tipped: its wheels no longer roll on their treads.
TIPPED = math.radians(30.0)


@compiled_inside
def step_simulation(wheels: Wheels, place: Place, motion: Motion, b: int, u: np.ndarray) -> bool:
    """Drives the robots of one simulation through a control period; returns whether all went well.

    Args:
        wheels: what does not change.
        place: of the thread.
        motion: of all simulations; changed.
        b: which of them.
        u: accelerations commanded, shape (n, 2).
    """
    if not begin(motion, b, u):
        return False
    for unit in range(motion.qpos.shape[1] // wheels.tyres.shape[0]):
        roll(wheels, place, motion, b, unit)
    return finish(wheels, motion, b)


@compiled_inside
def begin(motion: Motion, b: int, u: np.ndarray) -> bool:
    """Takes a command; returns whether it is finite."""
    for i in range(u.shape[0]):
        if not (math.isfinite(u[i, 0]) and math.isfinite(u[i, 1])):
            blame(motion, b, COMMAND, i, 0)
            return False
    for i in range(u.shape[0]):
        copy(motion.u_before[b, i], motion.u[b, i])
        copy(motion.u[b, i], u[i])
    return True


@compiled_inside
def finish(wheels: Wheels, motion: Motion, b: int) -> bool:
    """Reads the state at the end of a period and what the wheels did; returns whether all went well."""
    for i in range(motion.g.shape[1]):
        copy(motion.g_before[b, i], motion.g[b, i])
        copy(motion.xi_before[b, i], motion.xi[b, i])
    for robot in range(motion.qpos.shape[1]):
        _read_state(wheels, motion, b, robot)
    if wheels.first_body:
        advance(motion.g[b, 0], motion.xi[b, 0], motion.u[b, 0], wheels.dt)
    write_telemetry(wheels, motion, b, False)
    return _is_well(wheels, motion, b)


@compiled_inside
def _read_state(wheels: Wheels, motion: Motion, b: int, robot: int) -> None:
    """Unwraps the heading and carries velocities to the positions' time by the acceleration measured last."""
    qpos, n = motion.qpos[b, robot], robot + wheels.first_body
    now, earlier = motion.velocity[b, robot], motion.velocity_before[b, robot]
    g, xi = motion.g[b, n], motion.xi[b, n]
    omega = now[2] + (now[2] - earlier[2]) / 2
    yaw, expected = heading_of(wheels.planar, qpos), g[2] + wheels.dt * omega
    g[0] = qpos[0]
    g[1] = qpos[1]
    g[2] = yaw + 2 * math.pi * np.rint((expected - yaw) / (2 * math.pi))
    xi[0] = now[0] + (now[0] - earlier[0]) / 2
    xi[1] = now[1] + (now[1] - earlier[1]) / 2
    xi[2] = omega


@compiled_inside
def _is_well(wheels: Wheels, motion: Motion, b: int) -> bool:
    if is_lost(motion.g[b], motion.xi[b], motion.reach[b], motion.fault[b]) or motion.fault[b, 0] != FINE:
        return False
    for robot in range(motion.qpos.shape[1]):
        if tilt_of(wheels.planar, motion.qpos[b, robot]) > TIPPED:
            blame(motion, b, TIPPED_OVER, robot + wheels.first_body, 0)
            return False
    return True


@compiled_inside
def lose(motion: Motion, b: int) -> None:
    """Lets a simulation stand still for the rest of the run, where it was before something went wrong."""
    motion.lost[b] = True
    for i in range(motion.g.shape[1]):
        if motion.fault[b, 0] != COMMAND:
            copy(motion.g[b, i], motion.g_before[b, i])
        fill(motion.xi[b, i], 0.0)
        fill(motion.telemetry[b, i], math.nan)
    for robot in range(motion.qvel.shape[1]):
        fill(motion.qvel[b, robot], 0.0)
        fill(motion.velocity[b, robot], 0.0)
        fill(motion.velocity_before[b, robot], 0.0)


@compiled_loop
def roll_units(wheels: Wheels, place: Place, motion: Motion, b: int, first: int, last: int) -> None:
    """Steps the units [first, last) of one simulation through a control period that has begun."""
    for unit in range(first, last):
        roll(wheels, place, motion, b, unit)


@compiled_loop
def measure_all(wheels: Wheels, motion: Motion) -> None:
    """Writes the telemetry of all simulations before their first step."""
    for b in range(motion.g.shape[0]):
        write_telemetry(wheels, motion, b, True)


@compiled_loop
def drive_simulations(
    wheels: Wheels, place: Place, motion: Motion, first: int, last: int, u: np.ndarray, track: Track, keep_going: bool
) -> None:
    """Drives the simulations [first, last) by inputs known beforehand, shape (k, b, n, 2), until one goes wrong."""
    for b in range(first, last):
        for k in range(u.shape[0]):
            if not motion.lost[b] and not step_simulation(wheels, place, motion, b, u[k, b]):
                if not keep_going:
                    break
                lose(motion, b)
            write_track(track, k, b, motion)
