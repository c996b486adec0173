"""The reduced model and the ground as compiled scalar code, for what is asked every period of every robot.

The equations are those of `nhtrack.robots.diff_drive.DiffDrive` and `nhtrack.ground.Ground`, which speak of arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive


class Floor(NamedTuple):
    """What robots stand on.

    Attributes:
        friction: outside all patches [1].
        patches: a row (is a disc, x_min or x, x_max or y, y_min or r, y_max, friction) for each, shape (k, 6).
        along: gravity along the slope [m/s^2].
        uphill: direction in which it rises [rad].
        normal: gravity into the floor [m/s^2].
    """

    friction: float
    patches: np.ndarray
    along: float
    uphill: float
    normal: float


class Plant(NamedTuple):
    """The numbers of a `DiffDrive` that its motion's demands are made of; see there."""

    radius: float
    half_separation: float
    mass: float
    first_x: float
    first_y: float
    axle_inertia: float
    height: float
    tread_mass: float  # 2 I_w / r^2
    spin: float  # 2 (I_w - rotor) / r
    product_x: float
    product_y: float
    levelled: bool
    load_rows: tuple[float, float, float, float, float, float]  # of the left wheel, then of the right one
    torque_limit: float
    stall_torque: float
    no_load_speed: float
    lossy: bool
    damping: tuple[float, float]
    dry_friction: tuple[float, float]


class Demand(NamedTuple):
    """What a motion asks of the two wheels (left, right): torque [N m], load [N], horizontal force [N]."""

    torque: tuple[float, float]
    load: tuple[float, float]
    force: tuple[float, float]


def floor_of(ground: Ground) -> Floor:
    """Returns a ground for compiled code."""
    rows = [
        (1.0, *patch.disc, 0.0, patch.friction)
        if patch.disc is not None
        else (0.0, *(patch.rectangle or ()), patch.friction)
        for patch in ground.patches
    ]
    level = ground.slope == 0.0
    gravity = -ground.gravity[2]
    along = 0.0 if level else math.hypot(*ground.gravity[:2])
    return Floor(ground.friction, np.array(rows, dtype=float).reshape(-1, 6), along, ground.uphill, gravity)


def plant_of(drive: DiffDrive) -> Plant:
    """Returns a reduced model for compiled code."""
    r = drive.wheel_radius
    return Plant(
        radius=r,
        half_separation=drive.half_separation,
        mass=drive.mass,
        first_x=drive.first_moment[0],
        first_y=drive.first_moment[1],
        axle_inertia=drive.axle_inertia,
        height=drive.com[2],
        tread_mass=2 * drive.wheel_inertia / r**2,
        spin=2 * (drive.wheel_inertia - drive.reflected_inertia) / r,
        product_x=drive.products[0],
        product_y=drive.products[1],
        levelled=drive.levelled,
        load_rows=tuple(float(value) for value in drive.load_solution.ravel()),  # type: ignore[arg-type]
        torque_limit=drive.motor.torque_limit,
        stall_torque=drive.motor.stall_torque,
        no_load_speed=drive.motor.no_load_speed,
        lossy=bool(drive.losses),
        damping=drive.losses.damping,
        dry_friction=drive.losses.dry_friction,
    )


@compiled_inside
def length(x: float, y: float) -> float:
    """Returns the length of a vector; several times as quick as `hypot`, for what does not overflow when squared."""
    return math.sqrt(x * x + y * y)


@compiled_inside
def friction_at(floor: Floor, x: float, y: float) -> float:
    """Returns the friction coefficient at a point; where patches overlap the last one counts."""
    friction = floor.friction
    for k in range(floor.patches.shape[0]):
        patch = floor.patches[k]
        if patch[0] != 0.0:
            covered = math.hypot(x - patch[1], y - patch[2]) <= patch[3]
        else:
            covered = patch[1] <= x <= patch[2] and patch[3] <= y <= patch[4]
        if covered:
            friction = patch[5]
    return friction


@compiled_inside
def gravity_at(floor: Floor, theta: float) -> tuple[float, float]:
    """Returns gravity along the x and y axes of a robot with heading theta [m/s^2]."""
    if floor.along == 0.0:
        return 0.0, 0.0
    ahead = floor.uphill - theta
    return -floor.along * math.cos(ahead), -floor.along * math.sin(ahead)


@compiled_inside
def demand_of(plant: Plant, floor: Floor, theta: float, v: float, omega: float, u_x: float, u_theta: float) -> Demand:
    """Returns what a motion without slip asks for; see `DiffDrive.wheel_torques`, `wheel_loads`, `friction_demand`."""
    gravity_x, gravity_y = gravity_at(floor, theta)
    square, ahead, aside = omega * omega, u_x - gravity_x, omega * v - gravity_y
    f_x = plant.mass * ahead - plant.first_y * u_theta - plant.first_x * square
    f_y = plant.mass * aside + plant.first_x * u_theta - plant.first_y * square
    tau = plant.axle_inertia * u_theta - plant.first_y * ahead + plant.first_x * aside
    b = plant.half_separation
    driven = f_x + plant.tread_mass * u_x
    turned = (tau + plant.tread_mass * b * b * u_theta) / b
    half = plant.radius / 2
    moment = tau / b
    torque_left, torque_right = half * (driven - turned), half * (driven + turned)
    if plant.lossy:
        torque_left += loss_at(plant, 0, (v - b * omega) / plant.radius, u_x - b * u_theta)
        torque_right += loss_at(plant, 1, (v + b * omega) / plant.radius, u_x + b * u_theta)
    left, right = _loads(plant, floor.normal, f_x, f_y, omega * v, square, u_x, u_theta)
    return Demand(
        (torque_left, torque_right),
        (left, right),
        (length((f_x - moment) / 2, f_y / 2), length((f_x + moment) / 2, f_y / 2)),
    )


@compiled_inside
def loss_at(plant: Plant, wheel: int, speed: float, rate: float) -> float:
    """Returns what friction at the joint of a wheel takes [N m]; see `DiffDrive.wheel_losses`.

    Args:
        plant: the robot.
        wheel: 0 for the left one, 1 for the right one.
        speed: of the wheel [rad/s].
        rate: its acceleration, of which the sign counts.
    """
    loss = plant.damping[wheel] * speed
    forwards = rate if speed == 0.0 else speed
    if forwards > 0.0:
        loss += plant.dry_friction[wheel]
    elif forwards < 0.0:
        loss -= plant.dry_friction[wheel]
    return loss


@compiled_inside
def _loads(
    plant: Plant, normal: float, f_x: float, f_y: float, carried: float, square: float, u_x: float, u_theta: float
) -> tuple[float, float]:
    """Returns the normal forces of the two wheels [N]; see `DiffDrive.wheel_loads`."""
    weight = plant.mass * normal
    if plant.levelled:
        return weight / 2, weight / 2
    pitch = plant.first_x * normal - plant.height * f_x - plant.spin * u_x
    pitch -= plant.product_y * u_theta + plant.product_x * square
    roll = plant.first_y * normal - plant.height * f_y - plant.spin * carried
    roll += plant.product_x * u_theta - plant.product_y * square
    rows = plant.load_rows
    return (
        rows[0] * weight + rows[1] * pitch + rows[2] * roll,
        rows[3] * weight + rows[4] * pitch + rows[5] * roll,
    )


@compiled_inside
def wheel_utilisation(demand: float, limit: float) -> float:
    """Returns demand/limit; infinite where there is no limit but a force is asked for, zero where none is."""
    if limit > 0.0:
        return demand / limit
    return math.inf if demand > 0.0 else 0.0


@compiled_inside
def predicted_utilisation(
    plant: Plant, floor: Floor, x: float, y: float, theta: float, force: tuple[float, float], load: tuple[float, float]
) -> tuple[float, float]:
    """Returns what each wheel of a robot at a pose uses of its friction [1], with the force and load of `demand_of`."""
    if floor.patches.shape[0] == 0:
        left = right = floor.friction
    else:
        across_x, across_y = -plant.half_separation * math.sin(theta), plant.half_separation * math.cos(theta)
        left = friction_at(floor, x + across_x, y + across_y)
        right = friction_at(floor, x - across_x, y - across_y)
    return wheel_utilisation(force[0], left * load[0]), wheel_utilisation(force[1], right * load[1])


@compiled_inside
def saturated(torque: float, line: float, stall: float, limit: float, lag: float) -> float:
    """Returns the torque that a motor gives; see `Motor.saturate`.

    Args:
        torque: asked for [N m].
        line: wheel speed over the no-load speed [1].
        stall: torque at standstill [N m].
        limit: largest torque [N m].
        lag: how much the speed changes within the step [1].
    """
    upper = min(max(stall * (1 - line) / (1 + lag), -limit), limit)
    lower = min(max(-stall * (1 + line) / (1 + lag), -limit), limit)
    return min(max(torque, lower), upper)
