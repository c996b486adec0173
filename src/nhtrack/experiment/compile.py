"""Compiles all of the package's compiled code, once: at installation, or as the first stage of the first run.

`python -m nhtrack.experiment.compile` does it with a line on the screen for each part.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nhtrack.compiled import cache_folder, is_complete, mark_complete
from nhtrack.execution import Processes
from nhtrack.experiment.kernels import CompiledSimulation
from nhtrack.experiment.loop import rollout, run_loop
from nhtrack.experiment.run_statistics import RunStatistics
from nhtrack.laws import Law, LawKind, laws
from nhtrack.laws.evaluate import first_memories
from nhtrack.network import Network
from nhtrack.settling import settling_limits
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import SceneSpec, make_scene, stepped_scene
from nhtrack.simulation.state import State

_NAMES = ("leader", "follower")
_DT = 0.01


def compile_all(report: Callable[[int, int], None] | None = None) -> None:
    """Compiles the loop on both models and the package's own laws, into the cache.

    Args:
        report: called with the parts done and their number.
    """
    for done, part in enumerate(_PARTS):
        if report is not None:
            report(done, len(_PARTS))
        part()
    if report is not None:
        report(len(_PARTS), len(_PARTS))
    mark_complete()


def compile_once(stage: Callable[[str], Callable[[int, int], None]] | None) -> None:
    """Compiles everything if the cache does not hold it yet, as a stage of its own.

    Where no cache can be written nothing is done: what a run needs is compiled when it is needed.
    """
    if not is_complete():
        compile_all(None if stage is None else stage("compiling, once"))


def _ideal() -> None:
    _run(IdealSimulation(_NAMES, make_scene(SceneSpec(_NAMES)).drive, _DT))


def _wheels() -> None:
    _run(MujocoSimulation(make_scene(SceneSpec(_NAMES, timestep=0.002)), _DT))


def _fleet() -> None:
    spec = SceneSpec(_NAMES, timestep=0.002)
    rollout(MujocoSimulation(stepped_scene(spec), _DT, threads=2, spec=spec), *_pair())


def _laws() -> None:
    for kind in _own_laws():
        first_memories(_plain(kind), np.zeros((1, 6)), np.zeros((1, 9)))


_PARTS: tuple[Callable[[], None], ...] = (_wheels, _ideal, _fleet, _laws)


def _own_laws() -> tuple[LawKind, ...]:
    return tuple(kind for kind in laws().values() if kind.built_in)


def _run(simulation: CompiledSimulation) -> None:
    """Runs two robots for two periods in every way that compiled code is called."""
    rollout(simulation, *_pair())
    run_loop(simulation, *_pair(), RunStatistics(settling_limits(1.0), 0, ()))
    simulation.step(np.zeros((2, 2)))
    simulation.drive_by(np.zeros((1, 2, 2)))


def _pair() -> tuple[Law, Network, np.ndarray, State]:
    """Returns the law of two robots, who tracks whom, inputs for two periods, and where they start."""
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    start = State(0.0, np.array([[0.0, 0.0, 0.0], [-0.5, 0.2, 0.0]]), np.zeros((2, 3)))
    return _plain(_own_laws()[0]), network, np.zeros((2, 2)), start


def _plain(kind: LawKind) -> Law:
    """Returns a law with its defaults, and 1 for what has none."""
    gains = {name: kind.gains._field_defaults.get(name, 1.0) for name in kind.gains._fields}
    return kind(**gains)


def _do(part: int) -> None:
    _PARTS[part]()


def _main() -> None:
    where = cache_folder()
    if is_complete() and where is not None:
        return
    print("compiling laws and the control period, once" + ("" if where else " (no folder to keep it in)"), flush=True)
    for _ in Processes()(range(len(_PARTS)), _do):
        pass
    mark_complete()


if __name__ == "__main__":
    _main()
