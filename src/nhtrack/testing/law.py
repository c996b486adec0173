"""What every tracking law keeps, and what most of them claim, as tests that an author inherits.

In a file `test_my_law.py` beside the law:

    from pathlib import Path
    from nhtrack.laws import law_in
    from nhtrack.testing import LawContract

    class TestMine(LawContract):
        law = law_in(Path(__file__).with_name("my_law.py"))(k_x=2.0)

and then `pytest test_my_law.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

import numpy as np

from nhtrack.laws.address import call_law, entry_of
from nhtrack.laws.contract import Follower, Leader, Limits, dimension
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.laws.law import Law
from nhtrack.testing.scenes import Walk, hard_walk, plain_walk

Walks = tuple[np.ndarray, np.ndarray]  # accelerations, shape (periods, k, 2), and memories, shape (periods, k, values)


class LawContract:
    """Tests of a law; those of a claim that is False are not made.

    Commands are asked for a few hundred pairs of follower and leader over some periods, so that memory counts.

    Attributes:
        law: with its gains in metres and seconds; with `limits=Limits(...)` if it is to be tested with limits.
        period: control period [s].
        tolerance: largest difference that counts as rounding, in shares of the largest command of the same law.
        compiles: it is compiled, and then commands what it commands as Python.
        translation: where follower and leader are in the world does not matter, only how they are to each other.
        rotation: nor where the world's axes point.
        turns: nor how many whole turns the heading of either has behind it.
        mirror: left and right exchanged, it commands the same to the other side.
        similarity: in other units of length and time, its gains in theirs, it commands the same.
    """

    law: ClassVar[Law]
    period: ClassVar[float] = 0.01
    tolerance: ClassVar[float] = 1e-9
    compiles: ClassVar[bool] = True
    translation: ClassVar[bool] = True
    rotation: ClassVar[bool] = True
    turns: ClassVar[bool] = True
    mirror: ClassVar[bool] = True
    similarity: ClassVar[bool] = True

    def test_commands_are_finite(self) -> None:
        """On the leader, a picometre from it, at and beyond pi, leaders that rest, drive and turn: all finite."""
        for walk in (hard_walk(), plain_walk()):
            self._require(walk, lambda u: np.isfinite(u).all(axis=-1), self._ask(walk)[0], "not finite")

    def test_same_in_same_out(self) -> None:
        """Nothing but its arguments counts: asked again, in another order and for others in between, the same bits."""
        walk = plain_walk()
        first = self._ask(walk)[0]
        backwards = self._ask(Walk(walk.follower[:, ::-1], walk.leader[:, ::-1]))[0][:, ::-1]
        self._require(walk, lambda u: (u == first).all(axis=-1), backwards, "not what it commanded before")

    def test_compiled_is_python(self) -> None:
        """Machine code and Python command the same, and remember the same."""
        if not self.compiles:
            return
        reason = entry_of(self.law.kind).interpreted
        if reason is not None:
            raise AssertionError(f"law {self.law.kind.name!r} cannot be compiled: {reason}")
        for walk in (hard_walk(), plain_walk()):
            u, memory = self._ask_python(walk)
            found, kept = self._ask(walk)
            self._require_same(walk, found, u, "as Python")
            self._require_same(walk, kept, memory, "remembered as Python")

    def test_place_in_the_world_does_not_matter(self) -> None:
        """Claim `translation`."""
        self._require_kept(self.translation, lambda walk: walk.moved(7.25, -3.5), "elsewhere")

    def test_axes_of_the_world_do_not_matter(self) -> None:
        """Claim `rotation`."""
        for angle in (0.7, -2.9):
            self._require_kept(self.rotation, lambda walk, angle=angle: walk.rotated(angle), "in turned axes")  # type: ignore[misc]

    def test_whole_turns_do_not_matter(self) -> None:
        """Claim `turns`."""
        for own, others in ((1, 0), (0, -1), (-3, 2)):
            self._require_kept(
                self.turns, lambda walk, own=own, others=others: walk.wound(own, others), f"{own} and {others} turns on"  # type: ignore[misc]
            )

    def test_left_is_as_right(self) -> None:
        """Claim `mirror`."""
        self._require_kept(self.mirror, Walk.mirrored, "mirrored", sides=-1.0)

    def test_units_do_not_matter(self) -> None:
        """Claim `similarity`."""
        for length, time in ((3.0, 0.5), (0.2, 7.0)):
            if not self.similarity:
                return
            walk = plain_walk()
            scaled = self._ask(walk.scaled(length, time), self._in_units(length, time), self.period * time)[0]
            scaled = scaled * np.array([time**2 / length, time**2])
            said = f"in units of {length:g} m and {time:g} s"
            self._require_same(walk, scaled, self._ask(walk)[0], said)

    def _in_units(self, length: float, time: float) -> Law:
        """Returns the law with gains and limits in other units."""
        units = {name: dimension(gain.unit) for name, gain in self.law.kind.described.items()}
        scaled = {
            name: type(gain)(gain * length ** units[name][0] * time ** units[name][1])
            for name, gain in self.law.gains._asdict().items()
        }
        speed, rate, acceleration, yaw = self.law.limits
        limits = Limits(speed * length / time, rate / time, acceleration * length / time**2, yaw / time**2)
        return replace(self.law, gains=self.law.kind.gains(**scaled), limits=limits)

    def _ask(self, walk: Walk, law: Law | None = None, period: float | None = None) -> Walks:
        """Returns what a law commands along a walk, and what it remembers."""
        law, period = law or self.law, period or self.period
        memory = first_memories(law, walk.follower[0], walk.leader[0], period)
        found, kept = [], []
        for follower, leader in zip(walk.follower, walk.leader, strict=True):
            u, memory = commands(law, follower, leader, memory, period)
            found.append(u)
            kept.append(memory)
        return np.array(found), np.array(kept)

    def _ask_python(self, walk: Walk) -> Walks:
        kind, context = self.law.kind, [self.period, *self.law.limits]
        gains, size = self.law.gain_rows[0], self.law.kind.memory_size
        u, kept = np.empty((*walk.follower.shape[:2], 2)), np.empty((*walk.follower.shape[:2], size))
        for k in range(walk.follower.shape[1]):
            memory = np.array(
                call_law(kind, "init", gains, context, walk.follower[0, k], walk.leader[0, k], np.zeros(size))[2:]
            )
            for i in range(len(walk.follower)):
                told = call_law(kind, "command", gains, context, walk.follower[i, k], walk.leader[i, k], memory)
                u[i, k], memory = told[:2], np.array(told[2:])
                kept[i, k] = memory
        return u, kept

    def _require_kept(self, claimed: bool, change: Callable[[Walk], Walk], said: str, sides: float = 1.0) -> None:
        if claimed:
            walk = plain_walk()
            changed = self._ask(change(walk))[0] * np.array([1.0, sides])
            self._require_same(walk, changed, self._ask(walk)[0], said)

    def _require_same(self, walk: Walk, found: np.ndarray, expected: np.ndarray, said: str) -> None:
        most = 1.0 + np.abs(expected).max(axis=-1, keepdims=True, initial=0.0)
        most = most * self.tolerance
        self._require(walk, lambda u: (np.abs(u - expected) <= most).all(axis=-1), found, f"other {said}", expected)

    @staticmethod
    def _require(
        walk: Walk, is_kept: Callable[[np.ndarray], np.ndarray], found: np.ndarray, said: str,
        expected: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        """Fails with the first follower and leader for which a condition is broken."""
        broken = np.argwhere(~is_kept(found))
        if len(broken):
            i, k = broken[0]
            wanted = "" if expected is None else f", expected {expected[i, k]}"
            raise AssertionError(
                f"{said}: got {found[i, k]}{wanted} in period {i} for\n"
                f"{Follower(*walk.follower[i, k].tolist())}\n{Leader(*walk.leader[i, k].tolist())}\n"
                f"({len(broken)} of {is_kept(found).size})"
            )
