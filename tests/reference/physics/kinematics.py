"""The ideal model without wheels, for batches, as arrays: kept as second implementation."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nhtrack.arrays import Array
from reference.physics.ideal import propagate, require_rolling
from reference.physics.state import State

# A robot this far away [m], this fast [m/s] or turned this far [rad] is out of its law's hands; sums and squares of it
# are still finite.
RUNAWAY = 1e12


class Kinematics:
    """Robots that follow their accelerations exactly, as in `IdealSimulation`, and leave no telemetry."""

    def __init__(self, names: tuple[str, ...], dt: float) -> None:
        self.names, self.dt = names, dt

    def reset(self, state: State) -> State:
        """Places the robots; see `Simulation.reset`."""
        require_rolling(state)
        self._state = State(state.t, np.array(state.g), np.array(state.xi))
        self._start, self._periods = state.t, 0
        self.lost = np.zeros(state.g.shape[:-2], dtype=bool)
        return self._copy()

    def step(self, u: Array) -> State:
        """Advances one period by the exact flow; see `Simulation.step`."""
        before = self._state
        g, xi = propagate(before.g, before.xi, np.asarray(u, dtype=float), self.dt)
        near = (np.abs(g) < RUNAWAY) & (np.abs(xi) < RUNAWAY)  # False for what is not a number
        self.lost = self.lost | ~near.all(axis=(-2, -1))
        if self.lost.any():
            stopped = self.lost[..., None, None]
            g, xi = np.where(stopped, before.g, g), np.where(stopped, 0.0, xi)
        self._periods += 1
        self._state = State(self._start + self._periods * self.dt, g, xi)
        return self._copy()

    def telemetry(self) -> Mapping[str, Array]:
        """Returns nothing: there are no wheels."""
        return {}

    def _copy(self) -> State:
        return State(self._state.t, self._state.g.copy(), self._state.xi.copy())
