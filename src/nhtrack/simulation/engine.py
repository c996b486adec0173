"""One control period on wheels, compiled: MuJoCo's own step, called by its address, and all that goes around it.

What is computed, and why it is second order in the physics step, says `nhtrack.simulation.mujoco`. A *unit* is what is
stepped as one model: a single robot where robots cannot touch each other, else the whole scene. A thread owns one copy
of the model and its data; the state of every robot lives in arrays, from which a unit is loaded for a period.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nhtrack.compiled import call_2, compiled, compiled_inside, doubles, int32_at, int64_at, put_int32
from nhtrack.simulation.integrator import advance
from nhtrack.simulation.plant import (
    Floor,
    Plant,
    demand_of,
    friction_at,
    gravity_at,
    length,
    predicted_utilisation,
    saturated,
    utilisation,
)

# A robot leaning this far has tipped: its wheels no longer roll on their treads.
TIPPED = math.radians(30.0)
# Share of the friction limit from which a wheel counts as sliding within a physics step.
SLIDING = 1 - 1e-6
_WARNINGS = 7  # kinds of warnings that MuJoCo counts

# Why a simulation cannot go on.
FINE, COMMAND, STATE, WARNED, TIPPED_OVER, LAW = range(6)


class Wheels(NamedTuple):
    """What does not change while robots of one kind drive; p robots in units of k.

    Attributes:
        dt: control period [s].
        h: physics step [s].
        substeps: physics steps in a period.
        planar: whether the base is held level.
        corrected: whether tyres get a surface velocity along the axle.
        before_share: of the lateral velocity before a step, in that surface velocity [1].
        after_share: of the one wanted after it [1].
        force_share: of the side force [m/s/N].
        straddling: share of the old command in the first step of a period, which begins half a step before it [1].
        lag: of a motor whose wheel slides; see `Motor.saturate` [1].
        torque_map: from the terms of `DiffDrive.ground_map` to wheel torques, shape (6, 2).
        side_map: from the same to the side force, shape (6,).
        torque_gain: from wheel torques to accelerations, shape (2, 2).
        plant: the robots as they are.
        floor: what they stand on.
        known: what the compensation knows of it.
        radius_factors: radii of the tyres over the nominal radius.
        wheel_dofs: places of the wheels among a robot's velocities.
        motors: of a unit's robots among its actuators, shape (k, 2).
        tyres: of a unit's robots among its geoms, shape (k, 2).
        roles: of a unit's geoms: 2 i + wheel for tyres, -2 for the floor, -1 for all others.
        first_body: 1 where the root is virtual, else 0.
        layout: `nhtrack.simulation.memory.Layout` as integers.
    """

    dt: float
    h: float
    substeps: int
    planar: bool
    corrected: bool
    before_share: float
    after_share: float
    force_share: float
    straddling: float
    lag: float
    torque_map: np.ndarray
    side_map: np.ndarray
    torque_gain: np.ndarray
    plant: Plant
    floor: Floor
    known: Floor
    radius_factors: tuple[float, float]
    wheel_dofs: tuple[int, int]
    motors: np.ndarray
    tyres: np.ndarray
    roles: np.ndarray
    first_body: int
    layout: tuple[int, ...]


class Place(NamedTuple):
    """Addresses of what one thread steps: MuJoCo's function, its model and data, and their arrays."""

    step: int
    model: int
    data: int
    qpos: int
    qvel: int
    warmstart: int
    ctrl: int
    surface: int
    friction: int


class Motion(NamedTuple):
    """State of b simulations of n robots, p of them with wheels.

    Attributes:
        g: poses, shape (b, n, 3).
        xi: body twists, shape (b, n, 3).
        g_before: poses a period ago.
        xi_before: twists a period ago.
        u: accelerations commanded last, shape (b, n, 2).
        u_before: those commanded before, shape (b, n, 2).
        qpos: MuJoCo's coordinates, shape (b, p, coordinates of a robot).
        qvel: its velocities, half a step earlier.
        warmstart: its accelerations of the last step.
        velocity: (v_x, v_y, omega) half a step before the positions' time, shape (b, p, 3).
        velocity_before: the same a step earlier.
        friction: coefficients under the tyres, shape (b, p, 2).
        force: of the floor on the tyres in the last step, world frame [N], shape (b, p, 2, 3).
        rolled: sums and extremes of a period, see `_note`, shape (b, p, 2, 5).
        telemetry: see `nhtrack.simulation.columns`, shape (b, n, 18).
        fault: why a simulation stopped, which robot, which warning; shape (b, 3).
        lost: whether it has, shape (b,).
    """

    g: np.ndarray
    xi: np.ndarray
    g_before: np.ndarray
    xi_before: np.ndarray
    u: np.ndarray
    u_before: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    warmstart: np.ndarray
    velocity: np.ndarray
    velocity_before: np.ndarray
    friction: np.ndarray
    force: np.ndarray
    rolled: np.ndarray
    telemetry: np.ndarray
    fault: np.ndarray
    lost: np.ndarray


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
            _blame(motion, b, COMMAND, i, 0)
            return False
    for i in range(u.shape[0]):
        copy(motion.u_before[b, i], motion.u[b, i])
        copy(motion.u[b, i], u[i])
    return True


@compiled_inside
def copy(target: np.ndarray, source: np.ndarray) -> None:
    """Copies numbers one by one: an assignment of whole rows takes the compiler seconds."""
    for i in range(target.shape[0]):
        target[i] = source[i]


@compiled_inside
def fill(target: np.ndarray, value: float) -> None:
    """Sets all of a row to a number."""
    for i in range(target.shape[0]):
        target[i] = value


@compiled_inside
def _blame(motion: Motion, b: int, code: int, robot: int, detail: int) -> None:
    motion.fault[b, 0] = code
    motion.fault[b, 1] = robot
    motion.fault[b, 2] = detail


@compiled_inside
def roll(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int) -> None:
    """Steps one unit through a control period."""
    count, first = wheels.tyres.shape[0], unit * wheels.tyres.shape[0]
    size_q, size_v = motion.qpos.shape[2], motion.qvel.shape[2]
    qpos = doubles(place.qpos, count * size_q).reshape((count, size_q))
    qvel = doubles(place.qvel, count * size_v).reshape((count, size_v))
    warmstart = doubles(place.warmstart, count * size_v).reshape((count, size_v))
    for i in range(count):
        copy(qpos[i], motion.qpos[b, first + i])
        copy(qvel[i], motion.qvel[b, first + i])
        copy(warmstart[i], motion.warmstart[b, first + i])
        for wheel in range(2):
            fill(motion.rolled[b, first + i, wheel], 0.0)
    for k in range(wheels.substeps):
        for i in range(count):
            _drive(wheels, place, motion, b, first + i, i, k == 0, qpos[i], qvel[i])
        call_2(place.step, place.model, place.data)
        _read_forces(wheels, place, motion.force[b], first)
        for i in range(count):
            _note_forces(wheels, motion, b, first + i)
            _read_velocity(wheels, motion, b, first + i, qpos[i], qvel[i])
    for i in range(count):
        copy(motion.qpos[b, first + i], qpos[i])
        copy(motion.qvel[b, first + i], qvel[i])
        copy(motion.warmstart[b, first + i], warmstart[i])
    _take_warnings(wheels, place, motion, b)


@compiled_inside
def heading_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the heading of a robot, on a free base the swing-twist rotation about the vertical [rad]."""
    return qpos[3] if planar else 2 * math.atan2(qpos[6], qpos[3])


@compiled_inside
def _drive(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, first: bool, qpos: np.ndarray,
    qvel: np.ndarray,
) -> None:  # fmt: skip
    """Sets the torques of a robot for one step, and the surface velocity and friction of its tyres.

    The axle midpoint's velocity turns from half a step before t_k to half a step after. Seen in the heading of t_k, in
    which MuJoCo takes masses and contacts, it goes from v e^(-i h omega/2) to v_after e^(i h omega_after/2). The
    difference of the two over h is the acceleration that torques are for and that contacts have to bring about.
    """
    h, n = wheels.h, robot + wheels.first_body
    u_x, u_theta = motion.u[b, n, 0], motion.u[b, n, 1]
    if first:
        u_x += wheels.straddling * (motion.u_before[b, n, 0] - u_x)
        u_theta += wheels.straddling * (motion.u_before[b, n, 1] - u_theta)
    v, omega = motion.velocity[b, robot, 0], motion.velocity[b, robot, 2]
    before_x, before_y = v * math.cos(0.5 * h * omega), -v * math.sin(0.5 * h * omega)
    v_after, turn = v + h * u_x, 0.5 * h * (omega + h * u_theta)
    heading = 0.0
    if wheels.known.along != 0.0 or wheels.floor.patches.shape[0] > 0:
        heading = heading_of(wheels.planar, qpos)
    gravity_x, gravity_y = gravity_at(wheels.known, heading)
    ahead, aside = (v_after * math.cos(turn) - before_x) / h, (v_after * math.sin(turn) - before_y) / h
    square = omega * omega  # MuJoCo takes the centripetal force from its own velocities
    terms = (ahead, u_theta, square, aside, gravity_x, gravity_y)
    extra_left = _torque(wheels, place, motion, b, robot, i, 0, terms, qvel)
    extra_right = _torque(wheels, place, motion, b, robot, i, 1, terms, qvel)
    if wheels.corrected:
        gain, side = wheels.torque_gain, wheels.side_map
        real_x = u_x + extra_left * gain[0, 0] + extra_right * gain[1, 0]
        real_theta = u_theta + extra_left * gain[0, 1] + extra_right * gain[1, 1]
        after_y = (v + h * real_x) * math.sin(0.5 * h * (omega + h * real_theta))
        force = ahead * side[0] + u_theta * side[1] + square * side[2] + aside * side[3]
        force += gravity_x * side[4] + gravity_y * side[5]
        surface = wheels.before_share * before_y + wheels.after_share * after_y + wheels.force_share * (force / 2)
        doubles(place.surface + 48 * wheels.tyres[i, 0], 2)[1] = surface
        doubles(place.surface + 48 * wheels.tyres[i, 1], 2)[1] = surface
    if wheels.floor.patches.shape[0] > 0:
        across_x = -wheels.plant.half_separation * math.sin(heading)
        across_y = wheels.plant.half_separation * math.cos(heading)
        _lay(wheels, place, motion, b, robot, i, 0, qpos[0] + across_x, qpos[1] + across_y)
        _lay(wheels, place, motion, b, robot, i, 1, qpos[0] - across_x, qpos[1] - across_y)


@compiled_inside
def _torque(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, wheel: int,
    terms: tuple[float, float, float, float, float, float], qvel: np.ndarray,
) -> float:  # fmt: skip
    """Sets the torque of one motor, and returns how much more it is than what was asked for [N m]."""
    row = wheels.torque_map
    asked = terms[0] * row[0, wheel] + terms[1] * row[1, wheel] + terms[2] * row[2, wheel]
    asked += terms[3] * row[3, wheel] + terms[4] * row[4, wheel] + terms[5] * row[5, wheel]
    force = motion.force[b, robot, wheel]
    slides = length(force[0], force[1]) >= SLIDING * motion.friction[b, robot, wheel] * force[2]
    plant = wheels.plant
    line = qvel[wheels.wheel_dofs[wheel]] / plant.no_load_speed
    given = saturated(asked, line, plant.stall_torque, plant.torque_limit, wheels.lag if slides else 0.0)
    doubles(place.ctrl + 8 * wheels.motors[i, wheel], 1)[0] = given
    noted = motion.rolled[b, robot, wheel]
    noted[0] += given
    if abs(asked) > abs(noted[1]):
        noted[1] = asked
    if given != asked:
        noted[2] += 1.0
    return float(given - asked)


@compiled_inside
def _lay(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, wheel: int, x: float, y: float
) -> None:
    """Gives a tyre the friction of the place where it stands."""
    friction = friction_at(wheels.floor, x, y)
    motion.friction[b, robot, wheel] = friction
    doubles(place.friction + 24 * wheels.tyres[i, wheel], 1)[0] = friction


@compiled_inside
def _read_forces(wheels: Wheels, place: Place, force: np.ndarray, first: int) -> None:
    """Reads the forces of the floor on the tyres of a unit from the list of contacts, in the world frame."""
    ncon, contact, efc_force, _, _, _, size, frame, geom, efc_address = wheels.layout
    for i in range(wheels.tyres.shape[0]):
        for wheel in range(2):
            fill(force[first + i, wheel], 0.0)
    at = int64_at(place.data + contact)
    forces = int64_at(place.data + efc_force)
    for _ in range(int32_at(place.data + ncon)):
        row = int32_at(at + efc_address)
        role, other = wheels.roles[int32_at(at + geom)], wheels.roles[int32_at(at + geom + 4)]
        # The normal points from the first geom to the second, which the force pushes along it.
        if row >= 0 and ((role == -2 and other >= 0) or (other == -2 and role >= 0)):
            tyre, sign = (other, 1.0) if role == -2 else (role, -1.0)
            axes, parts = doubles(at + frame, 9), doubles(forces + 8 * row, 3)
            on_tyre = force[first + tyre // 2, tyre % 2]
            for axis in range(3):
                on_tyre[axis] += sign * (axes[axis] * parts[0] + axes[3 + axis] * parts[1] + axes[6 + axis] * parts[2])
        at += size


@compiled_inside
def _note_forces(wheels: Wheels, motion: Motion, b: int, robot: int) -> None:
    for wheel in range(2):
        force, noted = motion.force[b, robot, wheel], motion.rolled[b, robot, wheel]
        noted[3] += force[2]
        limit = motion.friction[b, robot, wheel] * max(force[2], 0.0)
        noted[4] = max(noted[4], utilisation(length(force[0], force[1]), limit))


@compiled_inside
def _read_velocity(
    wheels: Wheels, motion: Motion, b: int, robot: int, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """Resolves the velocities in the headings of their own time, half a step before the positions'."""
    velocity = motion.velocity[b, robot]
    copy(motion.velocity_before[b, robot], velocity)
    omega = qvel[3] if wheels.planar else qvel[5]
    angle = heading_of(wheels.planar, qpos) - wheels.h / 2 * omega
    cosine, sine = math.cos(angle), math.sin(angle)
    velocity[0] = qvel[0] * cosine + qvel[1] * sine
    velocity[1] = qvel[1] * cosine - qvel[0] * sine
    velocity[2] = omega


@compiled_inside
def _take_warnings(wheels: Wheels, place: Place, motion: Motion, b: int) -> None:
    """Notes the first kind of warning that MuJoCo counted, and sets the counts to zero."""
    at, size, number = place.data + wheels.layout[3], wheels.layout[4], wheels.layout[5]
    for kind in range(_WARNINGS):
        if int32_at(at + kind * size + number) > 0:
            put_int32(at + kind * size + number, 0)
            if motion.fault[b, 0] == FINE:
                _blame(motion, b, WARNED, 0, kind)


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
    measure(wheels, motion, b, False)
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
def tilt_of(planar: bool, qpos: np.ndarray) -> float:
    """Returns the angle between a robot's vertical axis and the floor's normal [rad]."""
    return 0.0 if planar else 2 * math.asin(min(math.hypot(qpos[4], qpos[5]), 1.0))


@compiled_inside
def _is_well(wheels: Wheels, motion: Motion, b: int) -> bool:
    for i in range(motion.g.shape[1]):
        for c in range(3):
            if not (math.isfinite(motion.g[b, i, c]) and math.isfinite(motion.xi[b, i, c])):
                _blame(motion, b, STATE, i, 0)
                return False
    if motion.fault[b, 0] != FINE:
        return False
    for robot in range(motion.qpos.shape[1]):
        if tilt_of(wheels.planar, motion.qpos[b, robot]) > TIPPED:
            _blame(motion, b, TIPPED_OVER, robot + wheels.first_body, 0)
            return False
    return True


@compiled_inside
def measure(wheels: Wheels, motion: Motion, b: int, unknown: bool) -> None:
    """Writes the telemetry of a period; `unknown` before the first one, when nothing is known of forces."""
    if wheels.first_body:
        fill(motion.telemetry[b, 0], math.nan)
    for robot in range(motion.qpos.shape[1]):
        row, rolled = motion.telemetry[b, robot + wheels.first_body], motion.rolled[b, robot]
        now, steps, plant = motion.velocity[b, robot], float(wheels.substeps), wheels.plant
        for wheel in range(2):
            row[wheel] = rolled[wheel, 0] / steps
            row[2 + wheel] = rolled[wheel, 1]
            row[4 + wheel] = rolled[wheel, 2] / steps
            row[8 + wheel] = rolled[wheel, 3] / steps
            row[13 + wheel] = rolled[wheel, 4]
            speed = motion.qvel[b, robot, wheels.wheel_dofs[wheel]]
            across = plant.half_separation * now[2] * (2 * wheel - 1)
            row[6 + wheel] = speed
            row[10 + wheel] = plant.radius * ((now[0] + across) / plant.radius - speed * wheels.radius_factors[wheel])
            if unknown:
                row[wheel] = row[2 + wheel] = row[8 + wheel] = math.nan
        row[12] = now[1]
        _predict(wheels, motion, b, robot + wheels.first_body, row)
        row[17] = tilt_of(wheels.planar, motion.qpos[b, robot])


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


@compiled
def roll_units(wheels: Wheels, place: Place, motion: Motion, b: int, first: int, last: int) -> None:
    """Steps the units [first, last) of one simulation through a control period that has begun."""
    for unit in range(first, last):
        roll(wheels, place, motion, b, unit)


@compiled
def step_simulations(
    wheels: Wheels, place: Place, motion: Motion, first: int, last: int, u: np.ndarray, keep_going: bool
) -> None:
    """Drives the simulations [first, last) through a control period; u of shape (b, n, 2)."""
    for b in range(first, last):
        if not motion.lost[b] and not step_simulation(wheels, place, motion, b, u[b]) and keep_going:
            lose(motion, b)


@compiled
def measure_all(wheels: Wheels, motion: Motion) -> None:
    """Writes the telemetry of all simulations before their first step."""
    for b in range(motion.g.shape[0]):
        measure(wheels, motion, b, True)


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


@compiled
def drive_simulations(
    wheels: Wheels, place: Place, motion: Motion, first: int, last: int, u: np.ndarray, track: Track
) -> None:
    """Drives the simulations [first, last) by inputs known beforehand, shape (k, b, n, 2), until one goes wrong."""
    for b in range(first, last):
        for k in range(u.shape[0]):
            if not step_simulation(wheels, place, motion, b, u[k, b]):
                break
            write_track(track, k, b, motion.g[b], motion.xi[b], motion.telemetry[b])


@compiled_inside
def write_track(track: Track, k: int, b: int, g: np.ndarray, xi: np.ndarray, telemetry: np.ndarray) -> None:
    """Writes a period of a simulation."""
    for i in range(g.shape[0]):
        copy(track.g[k, b, i], g[i])
        copy(track.xi[k, b, i], xi[i])
        if track.telemetry.shape[0] > 0:
            copy(track.telemetry[k, b, i], telemetry[i])
    track.written[b] = k + 1
