"""What every simulation must keep, as a test class: a room's own class inherits it and says how to make one.

class TestIdealSimulation(SimulationContract):
    def make(self) -> Simulation:
        return IdealSimulation(self.names, drive, self.dt)
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from nhtrack.errors import SimulationDiverged
from nhtrack.recording import COMPONENTS, VARIABLES
from nhtrack.simulation.state import Simulation, State


class SimulationContract:
    """Shapes, reset, determinism, no shared memory, and how a simulation fails.

    Attributes:
        names: robots the simulation must have, root first.
        dt: control period it must have [s].
    """

    names = ("leader", "first", "second")
    dt = 0.01

    def make(self) -> Simulation:
        """Returns a new simulation of `names` with control period `dt`, not yet reset."""
        raise NotImplementedError

    def start(self, t: float = 0.0) -> State:
        """Three robots half a metre apart that drive, turn, and stand, one past a whole turn."""
        g = np.array([[0.0, 0.0, 0.0], [0.5, 0.25, 2.0], [-0.5, 0.5, -7.0]])
        xi = np.array([[0.2, 0.0, 0.5], [0.0, 0.0, -0.3], [0.0, 0.0, 0.0]])
        return State(t, g, xi)

    def input(self, k: int = 0) -> np.ndarray:
        """Gentle accelerations that differ from period to period."""
        phase = 0.3 * k + np.arange(len(self.names))
        return np.stack([0.1 * np.cos(phase), 0.5 * np.sin(phase)], axis=-1)

    def run(self, simulation: Simulation, periods: int = 5) -> list[State]:
        return [simulation.reset(self.start()), *(simulation.step(self.input(k)) for k in range(periods))]

    def test_names_and_period_are_the_ones_asked_for(self) -> None:
        simulation = self.make()
        assert simulation.names == self.names
        assert simulation.dt == self.dt

    def test_reset_returns_the_given_state(self) -> None:
        state = self.make().reset(self.start(t=3.0))
        assert state.t == 3.0
        np.testing.assert_array_equal(state.g, self.start().g)
        np.testing.assert_array_equal(state.xi, self.start().xi)

    def test_robots_move_the_way_they_point(self) -> None:
        """The first robot drives from rest along its heading, the one at rest without input stays."""
        simulation = self.make()
        simulation.reset(self.start()._replace(xi=np.zeros((3, 3))))
        u = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.0]])
        moved = [simulation.step(u) for _ in range(20)][-1].g - self.start().g
        assert np.hypot(*moved[1, :2]) > 0.5 * 0.5 * (20 * self.dt) ** 2 * 0.9
        assert math.atan2(moved[1, 1], moved[1, 0]) == pytest.approx(2.0, abs=0.01)
        assert np.abs(moved[[0, 2]]).max() < 1e-6

    def test_states_have_the_shape_of_the_start(self) -> None:
        for state in self.run(self.make()):
            assert state.g.shape == state.xi.shape == (3, 3)
            assert state.g.dtype == state.xi.dtype == float

    def test_time_counts_periods_without_drift(self) -> None:
        simulation = self.make()
        simulation.reset(self.start(t=3.0))
        times = [simulation.step(self.input(k)).t for k in range(30)]
        assert times == [3.0 + (k + 1) * self.dt for k in range(30)]

    def test_headings_stay_unwrapped(self) -> None:
        last = self.run(self.make())[-1]
        assert last.g[2, 2] == pytest.approx(-7.0, abs=0.1)

    def test_the_caller_owns_what_it_gave(self) -> None:
        """Changing the start or an input after the call changes nothing."""
        expected = self.run(self.make())
        simulation, start, u = self.make(), self.start(), self.input()
        simulation.reset(start)
        start.g[:], start.xi[:] = np.nan, np.nan
        state = simulation.step(u)
        u[:] = np.nan
        np.testing.assert_array_equal(state.g, expected[1].g)
        np.testing.assert_array_equal(simulation.step(self.input(1)).g, expected[2].g)

    def test_the_caller_owns_what_it_got(self) -> None:
        """Overwriting returned states and telemetry changes nothing."""
        expected = self.run(self.make())
        simulation = self.make()
        state = simulation.reset(self.start())
        for k in range(3):
            state.g[:], state.xi[:] = np.nan, np.nan
            for values in simulation.telemetry().values():
                values[...] = np.nan
            state = simulation.step(self.input(k))
            self.assert_same(state, expected[k + 1])

    def test_returned_arrays_share_no_memory(self) -> None:
        simulation = self.make()
        u, given = self.input(), self.start()
        state = simulation.reset(given)
        held = [u, given.g, given.xi, state.g, state.xi]
        for _ in range(2):
            state = simulation.step(u)
            held += [state.g, state.xi, *simulation.telemetry().values()]
        assert not [
            (i, j) for i, j in combinations(range(len(held)), 2) if np.shares_memory(held[i], held[j])
        ]

    def test_inputs_are_left_as_they_were(self) -> None:
        simulation, start, u = self.make(), self.start(), self.input()
        simulation.reset(start)
        simulation.step(u)
        np.testing.assert_array_equal(start.g, self.start().g)
        np.testing.assert_array_equal(start.xi, self.start().xi)
        np.testing.assert_array_equal(u, self.input())

    def test_two_simulations_do_the_same(self) -> None:
        for a, b in zip(self.run(self.make()), self.run(self.make()), strict=True):
            self.assert_same(a, b)

    def test_reset_forgets_what_was_before(self) -> None:
        simulation = self.make()
        first, again = self.run(simulation), self.run(simulation)
        for a, b in zip(first, again, strict=True):
            self.assert_same(a, b)

    def test_telemetry_has_the_names_and_shapes_of_a_recording(self) -> None:
        simulation = self.make()
        for step in range(2):
            _ = simulation.step(self.input()) if step else simulation.reset(self.start())
            telemetry = simulation.telemetry()
            assert set(telemetry) <= set(VARIABLES)
            for name, values in telemetry.items():
                sizes = [len(COMPONENTS[dim]) for dim in VARIABLES[name].dims]
                assert values.shape == (3, *sizes), name

    def test_telemetry_is_finite_after_a_step(self) -> None:
        simulation = self.make()
        simulation.reset(self.start())
        simulation.step(self.input())
        assert all(np.isfinite(values).all() for values in simulation.telemetry().values())

    def test_lateral_velocity_is_refused(self) -> None:
        start = self.start()
        start.xi[1, 1] = 1e-9
        with pytest.raises(ValueError, match="v_y must be zero"):
            self.make().reset(start)

    @pytest.mark.parametrize("shape", [(3,), (2, 3, 2), (2, 3)])
    def test_arrays_that_do_not_match_are_refused(self, shape: tuple[int, ...]) -> None:
        with pytest.raises(ValueError, match=r"expected g and xi of shape \(\.\.\., n, 3\)"):
            self.make().reset(State(0.0, np.zeros(shape), np.zeros((3, 3))))

    @pytest.mark.parametrize("value", [math.nan, math.inf])
    def test_a_command_that_is_not_finite_names_robot_and_time(self, value: float) -> None:
        simulation, u = self.make(), self.input()
        simulation.reset(self.start(t=1.0))
        simulation.step(u)
        u[1, 1] = value
        with pytest.raises(SimulationDiverged) as caught:
            simulation.step(u)
        assert (caught.value.robot, caught.value.batch) == ("first", 0)
        assert caught.value.time == 1.0 + self.dt  # when the period would have begun
        assert "command is not finite: robot 'first' at t = 1.010 s" in str(caught.value)

    @staticmethod
    def assert_same(a: State, b: State) -> None:
        assert a.t == b.t
        np.testing.assert_array_equal(a.g, b.g)
        np.testing.assert_array_equal(a.xi, b.xi)
