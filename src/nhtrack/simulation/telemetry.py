"""What the wheels did in a control period, and what the reduced model says they had to, written as telemetry."""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.simulation.attitude import clearances_of, tilt_of
from nhtrack.simulation.motion import Motion, Wheels, fill
from nhtrack.simulation.plant import demand_of, predicted_utilisation
from nhtrack.simulation.sliding import rolling_slip


@compiled_inside
def write_telemetry(wheels: Wheels, motion: Motion, b: int, unknown: bool) -> None:
    """Writes the telemetry of a period; `unknown` before the first one, when nothing is known of forces."""
    if wheels.first_body:
        fill(motion.telemetry[b, 0], math.nan)
    for robot in range(motion.qpos.shape[1]):
        row, rolled = motion.telemetry[b, robot + wheels.first_body], motion.rolled[b, robot]
        steps = float(wheels.substeps)
        for wheel in range(2):
            row[wheel] = rolled[wheel, 0] / steps
            row[2 + wheel] = rolled[wheel, 1]
            row[4 + wheel] = rolled[wheel, 2] / steps
            row[8 + wheel] = rolled[wheel, 3] / steps
            row[13 + wheel] = rolled[wheel, 4]
            row[6 + wheel] = motion.qvel[b, robot, wheels.wheel_dofs[wheel]]
            row[10 + wheel] = rolling_slip(wheels, motion, b, robot, wheel)
            if unknown:
                row[wheel] = row[2 + wheel] = row[8 + wheel] = math.nan
        row[12] = motion.velocity[b, robot, 1]
        _predict(wheels, motion, b, robot + wheels.first_body, row)
        row[17] = tilt_of(wheels.planar, motion.qpos[b, robot])
        row[18], row[19] = clearances_of(wheels, motion.qpos[b, robot])


@compiled_inside
def _predict(wheels: Wheels, motion: Motion, b: int, n: int, row: np.ndarray) -> None:
    """Writes the larger predicted utilisation of each wheel at the two ends of a period."""
    share = wheels.straddling
    u, before = motion.u[b, n], motion.u_before[b, n]
    u_x, u_theta = u[0] + share * (before[0] - u[0]), u[1] + share * (before[1] - u[1])
    left, right = 0.0, 0.0
    for end in range(2):
        g, xi = (motion.g_before[b, n], motion.xi_before[b, n]) if end == 0 else (motion.g[b, n], motion.xi[b, n])
        if end == 1:
            u_x, u_theta = u[0], u[1]
        asked = demand_of(wheels.plant, wheels.floor, g[2], xi[0], xi[2], u_x, u_theta)
        used = predicted_utilisation(wheels.plant, wheels.floor, g[0], g[1], g[2], asked.force, asked.load)
        left, right = max(left, used[0]), max(right, used[1])
    row[15] = left
    row[16] = right
