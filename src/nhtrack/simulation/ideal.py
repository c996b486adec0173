"""The ideal integrator: nonholonomic robots that follow their accelerations exactly."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.motor import Motor
from nhtrack.simulation import columns, flow
from nhtrack.simulation.faults import failure_in, reach_of
from nhtrack.simulation.integrator import advance_all
from nhtrack.simulation.plant import floor_of, plant_of
from nhtrack.simulation.state import Driven, State, require_rolling
from nhtrack.simulation.touch import NOTED, SLOTS
from nhtrack.simulation.track import Track, driven, make_track

# Stands for wheels that nobody asks about.
_NO_WHEELS = DiffDrive(1.0, 1.0, 1.0, 1.0, 0.0, (0.0, 0.0, 1.0), ((-1.0, 0.0),), Motor(1.0, 1.0, 1.0))


def propagate(g: Array, xi: Array, u: Array, dt: float) -> tuple[Array, Array]:
    """Returns poses and twists after dt under constant accelerations; see `nhtrack.simulation.integrator`.

    Args:
        g: poses, shape (..., 3).
        xi: body twists with v_y = 0, shape (..., 3).
        u: accelerations (u_x, u_theta) held over dt, shape (..., 2).
        dt: time [s].
    """
    shape = np.broadcast_shapes(np.shape(g)[:-1], np.shape(xi)[:-1], np.shape(u)[:-1])
    poses, twists = (np.array(np.broadcast_to(x, (*shape, 3)), dtype=float).reshape(-1, 3) for x in (g, xi))
    inputs = np.array(np.broadcast_to(u, (*shape, 2)), dtype=float).reshape(-1, 2)
    advance_all(poses, twists, inputs, float(dt))
    return poses.reshape(*shape, 3), twists.reshape(*shape, 3)


class IdealSimulation:
    """Robots that obey the ideal model; what the wheels would do comes from the reduced model.

    Args:
        names: the robots' names, root first.
        drive: the robots' reduced model, for telemetry; None leaves no telemetry.
        dt: control period [s].
        ground: what the wheels would stand on.
        virtual_root: whether the root has no wheels, of which there would be telemetry.
        keep_going: let a simulation of a batch that is lost stop where it is, so that the others can go on; else it
            raises SimulationDiverged.
        size: of the scenario [m]; see `nhtrack.simulation.faults`.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        drive: DiffDrive | None,
        dt: float,
        ground: Ground | None = None,
        *,
        virtual_root: bool = False,
        keep_going: bool = False,
        size: float = 1.0,
    ) -> None:
        self._size = size
        self.names, self.drive, self.dt, self.ground, self.keep_going = names, drive, dt, ground or Ground(), keep_going
        self.integrator = flow.Integrator(
            dt=float(dt),
            plant=plant_of(drive or _NO_WHEELS),
            floor=floor_of(self.ground),
            measured=drive is not None,
            first_body=int(virtual_root),
            keep_going=keep_going,
        )

    def reset(self, state: State) -> State:
        """Places the robots; see `Simulation.reset`."""
        require_rolling(state)
        self._shape = np.shape(state.g)[:-2]
        g = np.array(state.g, dtype=float, order="C").reshape(-1, *np.shape(state.g)[-2:])
        xi = np.array(state.xi, dtype=float, order="C").reshape(g.shape)
        count, robots = g.shape[:2]
        self.motion = flow.Flow(
            g=g,
            xi=xi,
            g_before=g.copy(),
            xi_before=xi.copy(),
            u=np.zeros((count, robots, 2)),
            qpos=np.zeros((count, 0, 0)),
            telemetry=np.zeros((count, robots, columns.WIDTH)),
            touch=np.zeros((count, 0, SLOTS, NOTED)),
            fault=np.zeros((count, 3), dtype=np.int64),
            lost=np.zeros(count, dtype=np.bool_),
            reach=reach_of(g, self._size),
        )
        self.start_time, self._periods = state.t, 0
        if self.integrator.measured:
            flow.measure_flows(self.integrator, self.motion)
        return self._state()

    def step(self, u: Array) -> State:
        """Advances one period by the exact flow; see `Simulation.step`."""
        self._drive(np.array(u, dtype=float, order="C")[None], make_track(0, self.motion, telemetry=False))
        self._periods += 1
        failure = self.failure()
        if failure is not None:
            raise failure
        return self._state()

    def drive_by(self, u: Array) -> Driven:
        """Drives the robots by inputs known beforehand; see `Simulation.drive_by`."""
        begin = self._state()
        track = make_track(len(u), self.motion, telemetry=self.measured)
        self._drive(np.array(u, dtype=float, order="C"), track)
        self._periods += int(track.written.min(initial=len(u)))
        failure = self.failure(self._periods + 1)
        if failure is not None:
            raise failure
        return driven(begin, self.dt, track, self._shape)

    def _drive(self, u: Array, track: Track) -> None:
        flow.drive_flows(self.integrator, self.motion, u.reshape(len(u), *self.motion.u.shape), track)

    def failure(self, periods: int | None = None, simulation: int | None = None) -> SimulationDiverged | None:
        """Returns why a simulation cannot go on, or None; see `MujocoSimulation.failure`."""
        done = self._periods if periods is None else periods
        return failure_in(self.motion, self.names, self.start_time, self.dt, done, simulation)

    @property
    def measured(self) -> bool:
        """Whether there is telemetry."""
        return bool(self.integrator.measured)

    @property
    def lost(self) -> Array:
        """Which simulations have run away and stand still, shape () or (b,)."""
        return self.motion.lost.reshape(self._shape).copy()

    @property
    def time(self) -> float:
        """Time on the robots' clock [s]."""
        return self.start_time + self._periods * self.dt

    def telemetry(self) -> Mapping[str, Array]:
        """Returns what wheels would have to do for the motion at the end of the period; see `Simulation.telemetry`."""
        if not self.integrator.measured:
            return {}
        return columns.telemetry_of(self._shaped(self.motion.telemetry))

    def _shaped(self, values: Array) -> Array:
        return values.reshape(*self._shape, *values.shape[1:]).copy()

    def _state(self) -> State:
        return State(self.time, self._shaped(self.motion.g), self._shaped(self.motion.xi))
