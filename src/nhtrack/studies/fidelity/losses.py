"""What friction at the wheel joints takes: a robot whose motors are off coasts down as the reduced model says."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_ivp

from nhtrack.arrays import Array
from nhtrack.effects.motors import Motors
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import drive_open_loop, state_of

NO_TORQUE = 1e-12  # [N m] limit of motors that are switched off
_BUDGET, _LONGEST = 1e-3, 3.0  # of the speed, of the time; [s]
_SPEED, _FRICTION = 0.2, 0.5  # of the top speed, and of the friction that losses may use


def coasting_down(bench: Bench) -> Iterator[Finding]:
    """Yields how far wheel speeds are from the reduced model's while a robot with losses coasts until a wheel stops.

    In shares of the speed it starts with, straight ahead and on the spot; and of the time until the first wheel stops,
    where dry friction stops it. A robot is placed with the twist that it would have had half a step before at constant
    speed; it is followed from its first step on. On the spot casters that swivel turn sideways: robots with such are
    not asked.
    """
    if not bench.drive.losses:
        return
    ways = (("straight ahead", 1.0, 0.0), ("on the spot", 0.0, 1.0))
    for name, straight, turning in ways[: 1 if bench.swivels else 2]:
        speed, stop = _coasted(bench, straight, turning)
        cause = "where the centre of mass is off the axle, MuJoCo's centripetal force is half a step late"
        yield bench.find(f"coasting down {name}", speed, "1", _BUDGET, cause)
        if stop is not None:
            cause = "the last step of a wheel that stops is shorter than a time step"
            yield bench.find(f"coasting down {name}: time to a wheel's stop", stop, "1", _BUDGET, cause)


def coast(drive: DiffDrive, begin: Array, time: Array) -> tuple[Array, float | None]:
    """Returns wheel speeds, shape (k, 2), at times [s] until a wheel stops, and when one does, by DOP853 at 1e-10.

    With the losses of both wheels together d and c, `m_eff r^2 v' = -d v - c r` straight ahead; and on the spot, where
    the centre of mass is on the axle, `J_eff (r/b)^2 omega' = -d omega - c r/b`.

    Args:
        drive: the robot's reduced model.
        begin: its (v, omega) at the first of the times.
        time: when to tell.
    """
    none = np.zeros(2)

    def rate(_: float, y: Array) -> Array:
        return drive.acceleration(y[0], y[1], none)

    def stopped(_: float, y: Array) -> float:
        speed = drive.wheel_speeds(y[0], y[1])
        return float((speed * np.sign(drive.wheel_speeds(begin[0], begin[1]))).min())

    stopped.terminal = True  # type: ignore[attr-defined]
    events = stopped if any(drive.losses.dry_friction) else None
    span = float(time[0]), float(time[-1])
    found = solve_ivp(rate, span, begin, method="DOP853", rtol=1e-10, atol=1e-12, t_eval=time, events=events)
    stop = float(found.t_events[0][0]) if events is not None and found.t_events[0].size else None
    return drive.wheel_speeds(*found.y), stop


def _coasted(bench: Bench, straight: float, turning: float) -> tuple[float, float | None]:
    """Returns the largest error of wheel speeds, in shares of those at the start, and that of the time to a stop."""
    drive, v = bench.drive, _start_speed(bench.drive, straight, turning)
    simulation = bench.simulation(effects=(Motors(torque_limit=NO_TORQUE),))
    start = state_of(((0, 0, 0), (straight * v, turning * v / drive.half_separation)))
    run = drive_open_loop(simulation, np.zeros((round(_LONGEST / simulation.dt), 1, 2)), start)
    time, motion = run.time[1:], run.xi[1:, 0, ::2]
    expected, stop = coast(drive, motion[0], time)
    found = drive.wheel_speeds(*motion.T)
    size = np.abs(found[0]).max()
    rows = len(expected) - 1 if stop is not None else len(expected)  # the last one may be of a wheel that has stopped
    error = float(np.abs(found[:rows] - expected[:rows]).max() / size)
    if stop is None:
        return error, None
    wheel = int(np.abs(expected[-1]).argmin())
    last, before = found[rows - 1, wheel], found[rows - 2, wheel]
    stopped = time[rows - 1] + simulation.dt * last / (before - last)
    return error, float(abs(stopped / stop - 1))


def _start_speed(drive: DiffDrive, straight: float, turning: float) -> float:
    """Returns a speed of the wheels over the floor [m/s] from which losses do not make them slide."""
    v = _SPEED * drive.top_speed
    while True:
        at = np.asarray(straight * v), np.asarray(turning * v / drive.half_separation)
        u_x, u_theta = drive.acceleration(*at, np.zeros(2))
        if drive.friction_utilisation(*at, u_x, u_theta, 1.0).max() <= _FRICTION:
            return v
        v *= 0.8
