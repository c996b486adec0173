"""What every simulation keeps, as tests that an author inherits.

In a file `test_my_simulation.py`:

    from nhtrack.testing import SimulationContract

    class TestMine(SimulationContract):
        def make(self):
            return MySimulation(self.names, self.dt)

and then `pytest test_my_simulation.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations
from typing import ClassVar, TypeVar

import numpy as np

from nhtrack.arrays import Array
from nhtrack.errors import SimulationDiverged
from nhtrack.recording import COMPONENTS, VARIABLES
from nhtrack.simulation.state import Simulation, State

Kind = TypeVar("Kind", bound=Exception)


class SimulationContract:
    """Tests of a simulation: shapes, clock, reset, determinism, no shared memory, and how it fails.

    Attributes:
        names: robots the simulation must have, root first.
        dt: control period it must have [s].
    """

    names: ClassVar[tuple[str, ...]] = ("leader", "first", "second")
    dt: ClassVar[float] = 0.01

    def make(self) -> Simulation:
        """Returns a new simulation of `names` with control period `dt`, not yet reset."""
        raise NotImplementedError

    @staticmethod
    def start(t: float = 0.0) -> State:
        """Returns three robots half a metre apart that drive, turn, and stand, one past a whole turn."""
        g = np.array([[0.0, 0.0, 0.0], [0.5, 0.25, 2.0], [-0.5, 0.5, -7.0]])
        xi = np.array([[0.2, 0.0, 0.5], [0.0, 0.0, -0.3], [0.0, 0.0, 0.0]])
        return State(t, g, xi)

    def input(self, k: int = 0) -> Array:
        """Returns gentle accelerations that differ from period to period, shape (3, 2)."""
        phase = 0.3 * k + np.arange(len(self.names))
        return np.stack([0.1 * np.cos(phase), 0.5 * np.sin(phase)], axis=-1)

    def run(self, simulation: Simulation, periods: int = 5) -> list[State]:
        """Returns the states of some periods from the start."""
        return [simulation.reset(self.start()), *(simulation.step(self.input(k)) for k in range(periods))]

    def test_names_and_period_are_the_ones_asked_for(self) -> None:
        """It has the robots and the control period that it was made with."""
        simulation = self.make()
        assert (simulation.names, simulation.dt) == (self.names, self.dt)

    def test_reset_returns_the_given_state(self) -> None:
        """To the last bit, the time as well."""
        self._require_same(self.make().reset(self.start(t=3.0)), self.start(t=3.0))

    def test_robots_move_the_way_they_point(self) -> None:
        """The second robot drives from rest along its heading; those without input stay."""
        simulation = self.make()
        simulation.reset(self.start()._replace(xi=np.zeros((3, 3))))
        u = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.0]])
        moved = [simulation.step(u) for _ in range(20)][-1].g - self.start().g
        assert np.hypot(*moved[1, :2]) > 0.9 * 0.25 * (20 * self.dt) ** 2
        assert abs(math.atan2(moved[1, 1], moved[1, 0]) - 2.0) < 0.01
        assert np.abs(moved[[0, 2]]).max() < 1e-6

    def test_states_have_the_shape_of_the_start(self) -> None:
        """Poses and twists are doubles, and headings stay unwrapped."""
        for state in self.run(self.make()):
            assert state.g.shape == state.xi.shape == (3, 3)
            assert state.g.dtype == state.xi.dtype == float
            assert abs(state.g[2, 2] + 7.0) < 0.1

    def test_time_counts_periods_without_drift(self) -> None:
        """The time is that of the start and so many periods, not a sum that rounds."""
        simulation = self.make()
        simulation.reset(self.start(t=3.0))
        times = [simulation.step(self.input(k)).t for k in range(30)]
        assert times == [3.0 + (k + 1) * self.dt for k in range(30)]

    def test_the_caller_owns_what_it_gave(self) -> None:
        """Start and inputs are left as they were, and changed after the call they change nothing."""
        expected = self.run(self.make())
        simulation, start, u = self.make(), self.start(), self.input()
        simulation.reset(start)
        self._require_same(start, self.start())
        start.g[:], start.xi[:] = np.nan, np.nan
        self._require_same(simulation.step(u), expected[1])
        assert np.array_equal(u, self.input())
        u[:] = np.nan
        self._require_same(simulation.step(self.input(1)), expected[2])

    def test_the_caller_owns_what_it_got(self) -> None:
        """Returned states and telemetry share no memory, and overwritten they change nothing."""
        expected = self.run(self.make())
        simulation = self.make()
        state = simulation.reset(self.start())
        held = [state.g, state.xi]
        for k in range(3):
            for values in (state.g, state.xi, *simulation.telemetry().values()):
                values[...] = np.nan
            state = simulation.step(self.input(k))
            self._require_same(state, expected[k + 1])
            held += [state.g, state.xi, *simulation.telemetry().values()]
        assert not any(np.shares_memory(one, other) for one, other in combinations(held, 2))

    def test_two_simulations_do_the_same_and_so_does_one_reset(self) -> None:
        """The same start and inputs give the same bits, whatever was before."""
        simulation = self.make()
        first = self.run(simulation)
        for other in (self.run(simulation), self.run(self.make())):
            for a, b in zip(first, other, strict=True):
                self._require_same(a, b)

    def test_telemetry_has_the_names_and_shapes_of_a_recording(self) -> None:
        """Before the first period and after it; after it all of it is finite."""
        simulation = self.make()
        simulation.reset(self.start())
        for step in range(2):
            telemetry = simulation.telemetry()
            assert set(telemetry) <= set(VARIABLES)
            for name, values in telemetry.items():
                sizes = [len(COMPONENTS[dim]) for dim in VARIABLES[name].dims]
                assert values.shape == (3, *sizes), name
                assert not step or np.isfinite(values).all(), name
            simulation.step(self.input())

    def test_states_that_no_robots_can_have_are_refused(self) -> None:
        """Lateral velocity, and arrays that do not match."""
        start = self.start()
        start.xi[1, 1] = 1e-9
        self._require_raised(ValueError, "v_y must be zero", lambda: self.make().reset(start))
        for shape in ((3,), (2, 3, 2), (2, 3)):
            bad = State(0.0, np.zeros(shape), np.zeros((3, 3)))
            self._require_raised(
                ValueError, "expected g and xi of shape (..., n, 3)", lambda bad=bad: self.make().reset(bad)  # type: ignore[misc]
            )

    def test_a_command_that_is_not_finite_names_robot_and_time(self) -> None:
        """The time is that at which the period would have begun."""
        for value in (math.nan, math.inf):
            simulation, u = self.make(), self.input()
            simulation.reset(self.start(t=1.0))
            simulation.step(u)
            u[1, 1] = value
            said = "command is not finite: robot 'first' at t = 1.010 s"
            error = self._require_raised(SimulationDiverged, said, lambda s=simulation, u=u: s.step(u))  # type: ignore[misc]
            assert (error.robot, error.batch, error.time) == ("first", 0, 1.0 + self.dt)

    @staticmethod
    def _require_same(a: State, b: State) -> None:
        if a.t != b.t or not np.array_equal(a.g, b.g) or not np.array_equal(a.xi, b.xi):
            raise AssertionError(f"got {a}, expected {b}")

    @staticmethod
    def _require_raised(kind: type[Kind], said: str, call: Callable[[], object]) -> Kind:
        try:
            call()
        except kind as error:
            if said not in str(error):
                raise AssertionError(f"expected an error that says {said!r}, got {error}") from error
            return error
        raise AssertionError(f"expected {kind.__name__}: {said}")
