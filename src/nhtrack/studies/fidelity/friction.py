"""Where friction lets go: break-away in every direction, and how far a robot with locked wheels slides."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from nhtrack.arrays import Array
from nhtrack.ground import GRAVITY
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.state import State
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import drive_open_loop, state_of, torque_share

_BUDGET, _STOPPING = 0.01, 1e-3
_TRIED = 1 + np.linspace(-0.02, 0.02, 41)  # parameters tried side by side, in shares of the predicted limit
_SLIDING = 1 - 1e-4  # utilisation from which a wheel counts as broken away
_TORQUE_SHARE = 0.4  # of the motors' torque, less losses, that friction may ask for: they must not be what limits
_FASTEST_WHEEL = 0.8  # of the top speed, for the same reason
_SPEED_SHARE = 0.3  # of the top speed that manoeuvres start with

Motion = tuple[float, float, float, float]  # v, omega, u_x, u_theta


@dataclass(frozen=True)
class Manoeuvre:
    """A motion that asks for more friction the larger its parameter s, and how long it is held [s]."""

    name: str
    motion: Callable[[float], Motion]
    duration: float


def manoeuvres(drive: DiffDrive) -> tuple[Manoeuvre, ...]:
    """Returns the directions in which a robot's friction is tried."""
    v = _SPEED_SHARE * drive.top_speed
    return (
        Manoeuvre("speeding up", lambda s: (0.0, 0.0, s, 0.0), 0.03),
        Manoeuvre("braking", lambda s: (v, 0.0, -s, 0.0), 0.03),
        Manoeuvre("turning", lambda s: (v, s, 0.0, 0.0), 0.2),
        Manoeuvre("spinning up", lambda s: (0.0, 0.0, 0.0, s), 0.01),
    )


def friction_limits(bench: Bench) -> Iterator[Finding]:
    """Yields how far from its prediction a wheel breaks away in each direction, with load transfer to the caster.

    Not while turning where casters swivel: their side force and the loads change until they have turned round.
    """
    cause = "contacts take a few steps to load up; the limit is found among parameters 0.1 % apart"
    for manoeuvre in manoeuvres(bench.drive):
        if bench.swivels and manoeuvre.name == "turning":
            continue
        friction = _friction_for(bench.drive, manoeuvre)
        limit = _limit(bench.drive, manoeuvre, friction)
        error = abs(_break_away(bench, manoeuvre, friction, limit) / limit - 1)
        yield bench.find(f"friction limit, {manoeuvre.name}", error, "1", _BUDGET, cause)


def stopping_distance(bench: Bench) -> Iterator[Finding]:
    """Yields how far the slide of a robot with locked wheels is from v^2 / (2 a).

    a = mu N / m with the wheels' load N, to which braking adds what it takes off the caster.
    """
    # Wheels that are locked do not spin down, so that nothing but the CoM's inertia transfers load.
    locked = replace(bench.drive, wheel_inertia=bench.drive.reflected_inertia)
    friction, zero = 0.1, np.zeros(())
    v = 0.8 * locked.wheel_radius * locked.motor.no_load_speed

    def residual(a: float) -> float:
        return locked.mass * a - friction * float(locked.wheel_loads(zero, zero, np.array(-a), zero).sum())

    a = brentq(residual, 0.0, 2 * friction * GRAVITY)
    # The velocity that a robot is placed with is that of half a step before, when it slid already.
    distance = (v - a * bench.spec().timestep / 2) ** 2 / (2 * a)
    error = abs(_slide(bench, friction, v, 1.1 * v / a) / distance - 1)
    budget, cause = _STOPPING, "wheels that slide bear what statics gives, and friction is mu times that"
    if bench.swivels:
        budget, cause = _BUDGET, "the inertia of a caster's wheel, which rolls on and is not reckoned with"
    yield bench.find("stopping distance with locked wheels", error, "1", budget, cause)


def _friction_for(drive: DiffDrive, manoeuvre: Manoeuvre) -> float:
    """Returns a friction coefficient small enough for the motors to reach its limit, at most 0.3."""
    friction = 0.3
    while True:
        motion = _arrays(manoeuvre.motion(_limit(drive, manoeuvre, friction)))
        speed = np.abs(drive.wheel_speeds(motion[0], motion[1])).max() * drive.wheel_radius / drive.top_speed
        if torque_share(drive, motion) <= _TORQUE_SHARE and speed <= _FASTEST_WHEEL:
            return friction
        friction *= 0.8


def _limit(drive: DiffDrive, manoeuvre: Manoeuvre, friction: float) -> float:
    """Returns the smallest parameter at which the reduced model has a wheel use all of its friction."""

    def excess(s: float) -> float:
        demand = drive.friction_demand(*_arrays(manoeuvre.motion(s)))
        return float((demand - friction * drive.wheel_loads(*_arrays(manoeuvre.motion(s)))).max())

    largest = 1.0
    while excess(largest) < 0:
        largest *= 2
    return float(brentq(excess, 0.0, largest, xtol=1e-12))


def _arrays(motion: Motion) -> tuple[Array, Array, Array, Array]:
    v, omega, u_x, u_theta = (np.asarray(value) for value in motion)
    return v, omega, u_x, u_theta


def _break_away(bench: Bench, manoeuvre: Manoeuvre, friction: float, limit: float) -> float:
    """Returns the smallest of the parameters tried side by side at which MuJoCo's wheels slide, infinite for none."""
    v, omega, u_x, u_theta = (np.array(column) for column in zip(*map(manoeuvre.motion, limit * _TRIED), strict=True))
    xi = np.stack([v, np.zeros_like(v), omega], axis=-1)[:, None]
    u = np.stack([u_x, u_theta], axis=-1)[:, None]
    simulation = bench.simulation(dt=0.01, batch=(len(_TRIED),), friction=friction)
    periods = round(manoeuvre.duration / simulation.dt)
    inputs = np.broadcast_to(u, (periods, *u.shape))
    run = drive_open_loop(simulation, inputs, State(0.0, np.zeros_like(xi), xi), ("friction_utilisation",))
    sliding = run.telemetry["friction_utilisation"][-1, :, 0].max(axis=-1) >= _SLIDING
    return float(limit * _TRIED[sliding.argmax()]) if sliding.any() and not sliding.all() else np.inf


def _slide(bench: Bench, friction: float, v: float, longest: float) -> float:
    """Returns how far a robot that slides on locked wheels at speed v comes, in a time that suffices [m]."""
    scene = bench.scene(friction=friction)
    model, wheels = scene.model, scene.addresses.wheel_qvel
    model.dof_frictionloss[wheels] = 10 * friction * scene.drive.mass * GRAVITY * scene.drive.wheel_radius
    model.dof_solref[wheels] = 2 * model.opt.timestep, 1  # as stiff as the contacts: the default gives way
    model.dof_solimp[wheels, :3] = 0.9999, 0.9999, 0.001
    simulation = bench.simulation(dt=0.01, scene=scene)
    simulation.reset(state_of(((0, 0, 0), (v, 0))))
    simulation.motion.qvel[..., simulation.wheels.wheel_dofs], simulation.motion.sliding[:] = 0.0, True
    return float(simulation.drive_by(np.zeros((round(longest / simulation.dt), 1, 2))).g[-1, 0, 0])
