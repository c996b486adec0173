"""A physics model through one control period, compiled: MuJoCo's own step, called by its address.

A *unit* is what is stepped as one model: a single robot where robots cannot touch each other, else the whole scene. A
thread owns one copy of the model and its data; the state of every robot lives in arrays, from which a unit is loaded
for a period.
"""

from __future__ import annotations

import math

import numpy as np

from nhtrack.compiled import compiled_inside, float64_at, int32_at, put_float64, put_int32
from nhtrack.simulation.attitude import heading_of
from nhtrack.simulation.faults import FINE, WARNED
from nhtrack.simulation.forces import note_forces, read_forces
from nhtrack.simulation.motion import Motion, Place, Wheels, blame, copy, fill
from nhtrack.simulation.plant import friction_at, gravity_at, loss_at, saturated
from nhtrack.simulation.sliding import step_physics

_WARNINGS = 7  # kinds of warnings that MuJoCo counts


@compiled_inside
def roll(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int) -> None:
    """Steps one unit through a control period."""
    load_unit(wheels, place, motion, b, unit)
    for k in range(wheels.substeps):
        drive_unit(wheels, place, motion, b, unit, k == 0)
        step_physics(wheels, place, motion, b, unit * wheels.tyres.shape[0])
        read_unit(wheels, place, motion, b, unit)
    store_unit(wheels, place, motion, b, unit)


@compiled_inside
def load_unit(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int) -> None:
    """Writes the state of a unit into the thread's data, and begins its sums of a period."""
    size_q, size_v, count = 8 * motion.qpos.shape[2], 8 * motion.qvel.shape[2], wheels.tyres.shape[0]
    for i in range(count):
        robot = unit * count + i
        _put_row(place.qpos + i * size_q, motion.qpos[b, robot])
        _put_row(place.qvel + i * size_v, motion.qvel[b, robot])
        _put_row(place.warmstart + i * size_v, motion.warmstart[b, robot])
        _put_row(place.unheld + i * size_v, motion.unheld[b, robot])
        for wheel in range(2):
            fill(motion.rolled[b, robot, wheel], 0.0)


@compiled_inside
def drive_unit(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int, first: bool) -> None:
    """Writes what the robots of a unit do in a physics step; `first` of the period."""
    for i in range(wheels.tyres.shape[0]):
        _drive(wheels, place, motion, b, unit * wheels.tyres.shape[0] + i, i, first)


@compiled_inside
def read_unit(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int) -> None:
    """Reads what a physics step made of the robots of a unit."""
    size_q, size_v, count = 8 * motion.qpos.shape[2], 8 * motion.qvel.shape[2], wheels.tyres.shape[0]
    read_forces(wheels, place, motion, b, unit * count)
    for i in range(count):
        robot = unit * count + i
        _take_row(place.qpos + i * size_q, motion.qpos[b, robot])
        _take_row(place.qvel + i * size_v, motion.qvel[b, robot])
        note_forces(motion, b, robot)
        _read_velocity(wheels, motion, b, robot)


@compiled_inside
def store_unit(wheels: Wheels, place: Place, motion: Motion, b: int, unit: int) -> None:
    """Keeps what only MuJoCo needs again, and looks for its warnings."""
    size_v, count = 8 * motion.qvel.shape[2], wheels.tyres.shape[0]
    for i in range(count):
        _take_row(place.warmstart + i * size_v, motion.warmstart[b, unit * count + i])
        _take_row(place.unheld + i * size_v, motion.unheld[b, unit * count + i])
    _take_warnings(wheels, place, motion, b)


@compiled_inside
def _put_row(address: int, row: np.ndarray) -> None:
    for c in range(row.shape[0]):
        put_float64(address + 8 * c, row[c])


@compiled_inside
def _take_row(address: int, row: np.ndarray) -> None:
    for c in range(row.shape[0]):
        row[c] = float64_at(address + 8 * c)


@compiled_inside
def _drive(wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, first: bool) -> None:
    """Sets the torques of a robot for one step, and the surface velocity and friction of its tyres.

    The axle midpoint's velocity turns from half a step before t_k to half a step after. Seen in the heading of t_k, in
    which MuJoCo takes masses and contacts, it goes from v e^(-i h omega/2) to v_after e^(i h omega_after/2). The
    difference of the two over h is the acceleration that torques are for and that contacts have to bring about.
    """
    h, n, qpos = wheels.h, robot + wheels.first_body, motion.qpos[b, robot]
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
    across = wheels.plant.half_separation * u_theta
    extra_left = _torque(wheels, place, motion, b, robot, i, 0, terms, u_x - across)
    extra_right = _torque(wheels, place, motion, b, robot, i, 1, terms, u_x + across)
    if wheels.corrected:
        gain, side = wheels.torque_gain, wheels.side_map
        real_x = u_x + extra_left * gain[0, 0] + extra_right * gain[1, 0]
        real_theta = u_theta + extra_left * gain[0, 1] + extra_right * gain[1, 1]
        after_y = (v + h * real_x) * math.sin(0.5 * h * (omega + h * real_theta))
        force = ahead * side[0] + u_theta * side[1] + square * side[2] + aside * side[3]
        force += gravity_x * side[4] + gravity_y * side[5]
        surface = wheels.before_share * before_y + wheels.after_share * after_y + wheels.force_share * (force / 2)
        for wheel in range(2):
            put_float64(place.surface + 48 * wheels.tyres[i, wheel] + 8, surface)
    if wheels.floor.patches.shape[0] > 0:
        across_x = -wheels.plant.half_separation * math.sin(heading)
        across_y = wheels.plant.half_separation * math.cos(heading)
        _lay(wheels, place, motion, b, robot, i, 0, qpos[0] + across_x, qpos[1] + across_y)
        _lay(wheels, place, motion, b, robot, i, 1, qpos[0] - across_x, qpos[1] - across_y)


@compiled_inside
def _torque(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, wheel: int,
    terms: tuple[float, float, float, float, float, float], rate: float,
) -> float:  # fmt: skip
    """Sets the torque of one motor, and returns how much more it is than what was asked for [N m].

    `rate` is the acceleration that is wanted of the wheel over the floor [m/s^2].
    """
    row = wheels.torque_map
    asked = terms[0] * row[0, wheel] + terms[1] * row[1, wheel] + terms[2] * row[2, wheel]
    asked += terms[3] * row[3, wheel] + terms[4] * row[4, wheel] + terms[5] * row[5, wheel]
    plant, slides = wheels.plant, motion.sliding[b, robot, wheel]
    speed = motion.qvel[b, robot, wheels.wheel_dofs[wheel]]
    if plant.lossy:
        asked += _loss_over(wheels, wheel, speed, rate)
        if slides:
            speed -= wheels.mobility[wheel] * loss_at(plant, wheel, speed, 0.0)
    line = speed / plant.no_load_speed
    given = saturated(asked, line, plant.stall_torque, plant.torque_limit, wheels.lag[wheel] if slides else 0.0)
    put_float64(place.ctrl + 8 * wheels.motors[i, wheel], given)
    noted = motion.rolled[b, robot, wheel]
    noted[0] += given
    if abs(asked) > abs(noted[1]):
        noted[1] = asked
    if given != asked:
        noted[2] += 1.0
    return float(given - asked)


@compiled_inside
def _loss_over(wheels: Wheels, wheel: int, speed: float, rate: float) -> float:
    """Returns what friction at a wheel's joint takes in a step [N m], where the motor does as it is told.

    Viscous friction acts by the mean of the speeds before and after the step, dry friction by the one after it.
    MuJoCo's gives way a little before it lets go; what it gives there is `FrictionRow`'s equation solved for the force.
    """
    plant = wheels.plant
    after = speed + wheels.h * rate / plant.radius
    dry = plant.dry_friction[wheel]
    slipped = wheels.grip[wheel] * (after - wheels.kept[wheel] * speed)
    return plant.damping[wheel] * (speed + after) / 2 + min(max(slipped, -dry), dry)


@compiled_inside
def _lay(
    wheels: Wheels, place: Place, motion: Motion, b: int, robot: int, i: int, wheel: int, x: float, y: float
) -> None:
    """Gives a tyre the friction of the place where it stands."""
    friction = friction_at(wheels.floor, x, y)
    motion.friction[b, robot, wheel] = friction
    put_float64(place.friction + 24 * wheels.tyres[i, wheel], friction)


@compiled_inside
def _read_velocity(wheels: Wheels, motion: Motion, b: int, robot: int) -> None:
    """Resolves the velocities in the headings of their own time, half a step before the positions'."""
    qpos, qvel, velocity = motion.qpos[b, robot], motion.qvel[b, robot], motion.velocity[b, robot]
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
    layout = wheels.layout
    at, size, number = place.data + layout.warning, layout.warning_size, layout.warning_number
    for kind in range(_WARNINGS):
        if int32_at(at + kind * size + number) > 0:
            put_int32(at + kind * size + number, 0)
            if motion.fault[b, 0] == FINE:
                blame(motion, b, WARNED, 0, kind)
