"""What the compiled control period on wheels reads and changes, and why it may stop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nhtrack.compiled import compiled_inside
from nhtrack.simulation.memory import Layout
from nhtrack.simulation.plant import Floor, Plant


class Wheels(NamedTuple):
    """What does not change while robots of one kind drive; p robots in units of k.

    Attributes:
        dt: control period [s].
        h: physics step [s].
        substeps: physics steps in a period.
        planar: whether the base is held level.
        corrected: whether tyres get a surface velocity along the axle.
        told_of_slip: whether tyres that slide are kept from being lifted, see `nhtrack.simulation.sliding`.
        compliance: of the tyres of a robot, see `nhtrack.simulation.contact.tyre_compliance`, shape (6, 6).
        before_share: of the lateral velocity before a step, in that surface velocity [1].
        after_share: of the one wanted after it [1].
        force_share: of the side force [m/s/N].
        straddling: share of the old command in the first step of a period, which begins half a step before it [1].
        lag: of a motor whose wheel slides; see `Motor.saturate` [1].
        mobility: how much a torque changes the speed of a wheel that slides within a step [rad/s/(N m)].
        grip: of MuJoCo's row of a wheel's dry friction, its torque over the speed that it does not hold [N m s/rad].
        kept: share of a wheel's speed that this row means to leave after a step [1].
        torque_map: from the terms of `DiffDrive.ground_map` to wheel torques, shape (6, 2).
        side_map: from the same to the side force, shape (6,).
        torque_gain: from wheel torques to mean accelerations of a step, shape (2, 2).
        plant: the robots as they are.
        floor: what they stand on.
        known: what the compensation knows of it.
        radius_factors: radii of the tyres over the nominal radius.
        flatness: of their shape, 1 - (half width/radius)^2 [1].
        wheel_dofs: places of the wheels among a robot's velocities.
        motors: of a unit's robots among its actuators, shape (k, 2).
        tyres: of a unit's robots among its geoms, shape (k, 2).
        roles: of a unit's geoms: 2 i + wheel for tyres, -2 for the floor, -1 for all others.
        owners: which of a unit's robots each of its geoms belongs to, -1 for none.
        first_body: 1 where the root is virtual, else 0.
        layout: where MuJoCo keeps what is read and changed.
    """

    dt: float
    h: float
    substeps: int
    planar: bool
    corrected: bool
    told_of_slip: bool
    compliance: np.ndarray
    before_share: float
    after_share: float
    force_share: float
    straddling: float
    lag: tuple[float, float]
    mobility: tuple[float, float]
    grip: tuple[float, float]
    kept: tuple[float, float]
    torque_map: np.ndarray
    side_map: np.ndarray
    torque_gain: np.ndarray
    plant: Plant
    floor: Floor
    known: Floor
    radius_factors: tuple[float, float]
    flatness: float
    wheel_dofs: tuple[int, int]
    motors: np.ndarray
    tyres: np.ndarray
    roles: np.ndarray
    owners: np.ndarray
    first_body: int
    layout: Layout


class Place(NamedTuple):
    """Addresses of what one thread steps: MuJoCo's functions, its model and data, and their arrays.

    `step` is `step_1`, up to what constraints ask for, and `step_2`, which begins with `actuate` and `accelerate`: what
    robots do without contacts. `to_rows` takes accelerations of joints to those of constraints.
    """

    step: int
    step_1: int
    step_2: int
    actuate: int
    accelerate: int
    to_rows: int
    model: int
    data: int
    qpos: int
    qvel: int
    warmstart: int
    unheld: int
    scratch: int
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
        unheld: those that it would have had without contacts.
        velocity: (v_x, v_y, omega) half a step before the positions' time, shape (b, p, 3).
        velocity_before: the same a step earlier.
        friction: coefficients under the tyres, shape (b, p, 2).
        force: of the floor on the tyres in the last step, world frame [N], shape (b, p, 2, 3).
        contact: addresses of the tyres' contacts with the floor in this step, 0 for none, shape (b, p, 2).
        sliding: whether a tyre used up its friction in the last step, or bore nothing, shape (b, p, 2).
        rolled: sums and extremes of a period, shape (b, p, 2, 5): torque given, largest torque asked for, steps in
            which the motor gave another one, load, largest friction utilisation.
        telemetry: see `nhtrack.simulation.columns`, shape (b, n, WIDTH).
        touch: what robots have touched since the last row, see `nhtrack.simulation.touch`, shape (b, n, SLOTS, NOTED);
            (b, 0, SLOTS, NOTED) where they cannot.
        fault: why a simulation stopped, which robot, which warning; shape (b, 3).
        lost: whether it has, shape (b,).
        reach: how far from the leader a robot has run away [m], shape (b,).
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
    unheld: np.ndarray
    velocity: np.ndarray
    velocity_before: np.ndarray
    friction: np.ndarray
    force: np.ndarray
    contact: np.ndarray
    sliding: np.ndarray
    rolled: np.ndarray
    telemetry: np.ndarray
    touch: np.ndarray
    fault: np.ndarray
    lost: np.ndarray
    reach: np.ndarray


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
def blame(motion: Motion, b: int, code: int, robot: int, detail: int) -> None:
    """Notes what went wrong in a simulation; see `nhtrack.simulation.faults`."""
    motion.fault[b, 0] = code
    motion.fault[b, 1] = robot
    motion.fault[b, 2] = detail
