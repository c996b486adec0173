"""The runs of a sweep: which values each has, and in which order and parts they are done."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from nhtrack.arrays import Array
from nhtrack.config.scenario import Scenario
from nhtrack.config.sweep import Choices, Sample, Spread, Sweep
from nhtrack.config.sweep_trials import change_texts, ordered
from nhtrack.config.tree import parse_path
from nhtrack.recording.versions import versions

_KEY = 16  # letters of a run's hash: of ten million runs two have the same once in four hundred thousand sweeps
SIDE_BY_SIDE = ("start", "seed")  # keys in which runs of one batch may differ, beside numbers of a law


@dataclass(frozen=True)
class Plan:
    """All runs of a sweep, and its scenario.

    A run is a point and a repetition of it: run = point * repeats + repetition.

    Attributes:
        sweep: with full paths.
        base: its scenario, with what is the same in all runs.
        files: hashes of the laws, robots and tables that runs read, by their full paths.
    """

    sweep: Sweep
    base: Scenario
    files: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def tree(self) -> dict[str, Any]:
        """The scenario as a tree of plain values."""
        return self.base.model_dump(mode="json")

    @cached_property
    def at(self) -> Mapping[str, Array]:
        """Where every point lies, by axis: places among its values, or the numbers drawn, shape (points,)."""
        sweep = self.sweep
        if sweep.sample is None:
            shape = [len(sweep.values(key)) for key in sweep.axes]
            return dict(zip(sweep.axes, np.unravel_index(np.arange(sweep.points), shape), strict=True))
        drawn = drawn_shares(sweep.sample, len(sweep.axes)).T
        return {key: self._place(key, shares) for key, shares in zip(sweep.axes, drawn, strict=True)}

    def _place(self, key: str, shares: Array) -> Array:
        axis = self.sweep.axes[key]
        return axis.at(shares) if isinstance(axis, Spread) else (shares * len(self._choices[key])).astype(np.int64)

    @cached_property
    def _choices(self) -> Mapping[str, tuple[Any, ...]]:
        return {key: self.sweep.values(key) for key in self.sweep.axes}

    def values(self, point: int) -> dict[str, Any]:
        """Returns the values of a point, by axis."""
        return {
            key: self._choices[key][at[point]] if self._choices[key] else float(at[point])
            for key, at in self.at.items()
        }

    def changes(self, run: int) -> list[str]:
        """Returns what a run changes in the scenario, as on the command line."""
        point, repeat = divmod(run, self.sweep.repeats)
        seed = {"seed": self.base.seed + repeat} if self.sweep.repeats > 1 else {}
        return change_texts(self.values(point) | seed)

    @cached_property
    def identity(self) -> str:
        """What all runs depend on, whatever they change: scenario, files and versions, as a hash."""
        return _hash({"base": self.tree, "files": dict(self.files), "versions": dict(versions())})

    def key(self, run: int) -> str:
        """Returns a hash of all that a run depends on; runs that have the same one are the same."""
        return _hash([self.identity, self.changes(run)])[:_KEY]

    @property
    def order(self) -> list[str]:
        """The keys that runs change, in the order of their changes."""
        return ordered([*self.sweep.axes, *(["seed"] if self.sweep.repeats > 1 else [])])

    def labels(self, runs: Array) -> pd.DataFrame:
        """Returns the columns of the table that say what each of some runs is."""
        points, repeats = np.divmod(runs, self.sweep.repeats)
        columns: dict[str, Any] = {"run": runs, "point": points, "repeat": repeats, "seed": self.base.seed + repeats}
        columns["key"] = [self.key(run) for run in runs.tolist()]
        for key, at in self.at.items():
            drawn = isinstance(self.sweep.axes[key], Spread)
            columns[key] = at[points] if drawn else np.array(self.sweep.labels(key))[at[points]]
        return pd.DataFrame(columns)

    def parts(self, size: int) -> Iterator[Array]:
        """Yields the runs in parts of at most so many; runs that can go side by side are together."""
        apart = [at for key, at in self.at.items() if not self._goes_beside(key)]
        order = np.lexsort(apart[::-1]) if apart else np.arange(self.sweep.points)
        runs = (order[:, None] * self.sweep.repeats + np.arange(self.sweep.repeats)).reshape(-1)
        for first in range(0, len(runs), size):
            yield runs[first : first + size]

    def _goes_beside(self, key: str) -> bool:
        path, axis = parse_path(key), self.sweep.axes[key]
        gain = path[0] == "law" and len(path) > 1 and path[1] != "limits" and not isinstance(axis, Choices)
        return gain or any(step in SIDE_BY_SIDE for step in path)


def _hash(tree: Any) -> str:
    return hashlib.sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()


def drawn_shares(sample: Sample, axes: int) -> Array:
    """Returns points of the unit cube, shape (points, axes), the same whatever their scenario."""
    if sample.method == "random":
        return np.random.default_rng(sample.seed).random((sample.count, axes))
    if sample.method == "saltelli":
        return _saltelli(sample, axes)
    from scipy.stats import qmc  # only here: it takes a second to import

    engine = (qmc.Sobol if sample.method == "sobol" else qmc.LatinHypercube)(axes, rng=sample.seed)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The balance properties of Sobol")  # docs/sweep.md says so
        return np.asarray(engine.random(sample.count))


def _saltelli(sample: Sample, axes: int) -> Array:
    """Returns the points that Sobol indices are reckoned from, shape (count * (axes + 2), axes), group by group.

    A group is a point a, then for each axis a with this coordinate of b, then b (Saltelli et al., Comput. Phys. Commun.
    181, 2010).
    """
    from SALib.sample.sobol import sample as drawn  # only here: it takes a second to import

    cube = {"num_vars": axes, "names": [*map(str, range(axes))], "bounds": [[0.0, 1.0]] * axes}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*power of 2|The balance properties of Sobol")  # docs/sweep.md says so
        shares = drawn(cube, sample.count, calc_second_order=False, scramble=True, seed=sample.seed)
    return np.asarray(shares).clip(0.0, np.nextafter(1.0, 0.0))
