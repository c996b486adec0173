"""Motions without a law: inputs that use a robot to a stated share, and an independent integrator's answer to them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from nhtrack.arrays import Array
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.state import Simulation, State

# Accelerations (u_x, u_theta), shape (..., 2), at times of any shape (...).
InputSignal: TypeAlias = Callable[[Array], Array]

_FORWARD, _TURNING = 0.6, 0.4  # how straight driving and turning share the wheels' speed
_SLOWEST, _FASTEST = 0.05, 5.0  # of the rhythms tried [1/s]


def state_of(*robots: tuple[tuple[float, float, float], tuple[float, float]]) -> State:
    """Returns the state of robots given as (pose, (v, omega)), shape (n, 3)."""
    return State(
        0.0,
        np.array([pose for pose, _ in robots], float),
        np.array([(v, 0.0, omega) for _, (v, omega) in robots]),
    )


AT_REST = state_of(((0, 0, 0), (0, 0)))


@dataclass(frozen=True)
class Weave:
    """A drive from rest that speeds up, backs up and turns both ways.

        v = V sin(0.8 k t),  omega = W (0.6 sin(1.3 k t) + 0.4 (1 - cos(0.7 k t)))

    Attributes:
        speed: V [m/s].
        turn: W [rad/s].
        rhythm: k [1/s].
    """

    speed: float
    turn: float
    rhythm: float

    def __call__(self, t: Array) -> Array:
        """Returns the accelerations (u_x, u_theta) at times t [s], shape (..., 2)."""
        k = self.rhythm
        u_x = 0.8 * k * self.speed * np.cos(0.8 * k * t)
        u_theta = self.turn * k * (0.78 * np.cos(1.3 * k * t) + 0.28 * np.sin(0.7 * k * t))
        return np.stack([u_x, u_theta], axis=-1)

    def rates(self, t: Array) -> tuple[Array, Array, Array, Array]:
        """Returns v, omega, u_x, u_theta at times t [s]."""
        k, u = self.rhythm, self(t)
        v = self.speed * np.sin(0.8 * k * t)
        omega = self.turn * (0.6 * np.sin(1.3 * k * t) + 0.4 * (1 - np.cos(0.7 * k * t)))
        return v, omega, u[..., 0], u[..., 1]


def weave_within(drive: DiffDrive, share: float, friction: float = 1.0, duration: float = 10.0) -> Weave:
    """Returns the weave whose wheels use a share of what there is: of speed, and of torque or friction.

    Speed is used to the share, straight driving having 60 % and turning 40 % of it; the rhythm is the quickest at which
    torque and friction stay within the share too. Where turning at speed alone asks more of the floor, speed gives way.

    Args:
        drive: the robot's reduced model.
        share: of each limit that is used [1].
        friction: coefficient of wheels and floor.
        duration: [s].
    """
    t = np.linspace(0, duration, 4001)
    top = share * drive.top_speed

    def weave(rhythm: float, slower: float = 1.0) -> Weave:
        return Weave(slower * _FORWARD * top, slower * _TURNING * top / drive.half_separation / 1.4, rhythm)

    def excess(wanted: Weave) -> float:
        rates = wanted.rates(t)
        return float(max(torque_share(drive, rates), drive.friction_utilisation(*rates, friction).max()) - share)

    slower = 1.0
    while excess(weave(_SLOWEST, slower)) > 0:
        slower *= 0.9
    if excess(weave(_FASTEST, slower)) < 0:
        return weave(_FASTEST, slower)
    return weave(brentq(lambda rhythm: excess(weave(rhythm, slower)), _SLOWEST, _FASTEST, xtol=1e-3), slower)


def torque_share(drive: DiffDrive, rates: tuple[Array, Array, Array, Array]) -> float:
    """Returns the largest share that motions (v, omega, u_x, u_theta) use of the torque that losses leave."""
    lost = drive.wheel_losses(*rates)
    used = np.abs(drive.wheel_torques(*rates) - lost) / (drive.motor.torque_limit - np.abs(lost))
    return float(used.max())


@dataclass(frozen=True)
class Run:
    """What a simulation did: times (t,), poses and twists (t, ..., n, 3), telemetry after each period."""

    time: Array
    g: Array
    xi: Array
    telemetry: dict[str, Array] = field(default_factory=dict)


def drive_open_loop(
    simulation: Simulation, inputs: Array, start: State = AT_REST, telemetry: Sequence[str] = ()
) -> Run:
    """Returns the run of held accelerations, shape (periods, ..., n, 2)."""
    simulation.reset(start)
    driven = simulation.drive_by(inputs)
    return Run(driven.t, driven.g, driven.xi, {name: driven.telemetry[name] for name in telemetry})


def middles(duration: float, dt: float) -> Array:
    """Returns the middles of the control periods [s]: a smooth input held so is followed to dt^2."""
    return (np.arange(round(duration / dt)) + 0.5) * dt


def integrate(signal: InputSignal, time: Array, start: State = AT_REST) -> tuple[Array, Array]:
    """Returns poses and twists (t, n, 3) of the ideal robot under a smooth input, by DOP853 at a tolerance of 1e-12."""

    def rate(t: float, y: Array) -> Array:
        change, (theta, v, omega) = np.empty((len(start.g), 5)), y.reshape(-1, 5).T[2:]
        change[:, 0], change[:, 1], change[:, 2] = v * np.cos(theta), v * np.sin(theta), omega
        change[:, 3:] = signal(np.array(t))
        return change.ravel()

    y = np.concatenate([start.g, start.xi[:, (0, 2)]], axis=-1).ravel()
    found = solve_ivp(rate, (time[0], time[-1]), y, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=time)
    columns = found.y.T.reshape(len(time), len(start.g), 5)
    lateral = np.zeros_like(columns[..., :1])
    return columns[..., :3], np.concatenate([columns[..., 3:4], lateral, columns[..., 4:]], axis=-1)


@dataclass(frozen=True)
class PoseError:
    """Largest differences between two runs at the same times: position [m] and heading [rad]."""

    position: float
    heading: float


def difference(g: Array, h: Array) -> PoseError:
    """Returns the largest differences between two runs' poses, shape (..., 3)."""
    gap = g - h
    return PoseError(float(np.hypot(gap[..., 0], gap[..., 1]).max()), float(np.abs(gap[..., 2]).max()))


def open_loop_error(
    simulation: Simulation, signal: InputSignal, duration: float = 10.0, start: State = AT_REST
) -> PoseError:
    """Returns how far a simulation strays from the ideal robot under the same input, which all its robots get."""
    return open_loop_errors([simulation], signal, duration, start)[0]


def open_loop_errors(
    simulations: Iterable[Simulation], signal: InputSignal, duration: float = 10.0, start: State = AT_REST
) -> list[PoseError]:
    """Returns `open_loop_error` of each; the shortest of their control periods divides the others."""
    runs = []
    for simulation in simulations:
        t = middles(duration, simulation.dt)
        inputs = np.broadcast_to(signal(t)[:, None], (len(t), len(start.g), 2))
        runs.append(drive_open_loop(simulation, inputs, start))
    finest = max(runs, key=lambda run: len(run.time))
    ideal = integrate(signal, finest.time, start)[0]
    return [difference(run.g, ideal[:: (len(ideal) - 1) // (len(run.g) - 1)]) for run in runs]
