"""The leader's input u0(t): what the root of the network is commanded over time.

A signal is a scalar function of time; a reference is a pair of them, (u_x [m/s^2], u_theta [rad/s^2]) in
whatever units its time is in. Nothing here knows of files or of scales: `nhtrack.similarity` maps times and
inputs to the robot.
"""

from __future__ import annotations

import ast
import cmath
import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from simpleeval import InvalidExpression, SimpleEval, safe_mult, safe_power

from nhtrack.errors import NhtrackError, did_you_mean

Interpolation: TypeAlias = Literal["previous", "linear"]

LONGEST_EXPRESSION = 1000  # characters; keeps a hostile text from exhausting Python's parser


class ReferenceInputError(NhtrackError):
    """An input that cannot be understood or has no finite value at some time.

    Attributes:
        t: the time it happened at, or None where the fault is in the text itself.
    """

    def __init__(self, message: str, t: float | None = None) -> None:
        self.t = t
        super().__init__(message)


class Signal(Protocol):
    """A scalar function of time, sampled on a grid."""

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        ...


FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")},
    **{name: getattr(math, name) for name in ("sinh", "cosh", "tanh", "exp", "log", "sqrt", "floor", "ceil")},
    "abs": abs,
    "min": min,
    "max": max,
    "sign": lambda value: float(value > 0) - float(value < 0),
}
CONSTANTS: dict[str, float] = {"pi": math.pi, "e": math.e}
VOCABULARY: tuple[str, ...] = ("t", *CONSTANTS, *FUNCTIONS, "where")

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: safe_mult,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: safe_power,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_GRAMMAR: tuple[type[ast.AST], ...] = (
    *_OPERATORS, ast.Expression, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.And, ast.Or, ast.Compare, ast.IfExp,
    ast.Call, ast.Name, ast.Load, ast.Constant,
)  # fmt: skip


class _Normalise(ast.NodeTransformer):
    """Turns `where(c, a, b)` into `a if c else b`, which asks one branch only, and integers into floats."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id == "where":
            if len(node.args) != 3:
                raise ReferenceInputError(
                    f"where(condition, a, b) takes three arguments, got {len(node.args)}"
                )
            condition, chosen, otherwise = node.args
            return ast.copy_location(ast.IfExp(condition, chosen, otherwise), node)
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if not isinstance(node.value, (int, float)):  # a bool is an int and fine: `t > 3 or True`
            raise ReferenceInputError(f"only numbers may be written in an expression, got {node.value!r}")
        return ast.copy_location(ast.Constant(_as_float(node.value)), node)


def _as_float(value: float) -> float:
    """Returns `value` as a float; float powers overflow where integer powers fill the memory."""
    try:
        return float(value)
    except OverflowError:
        raise ReferenceInputError("a number in the expression is too large") from None


def _parse(text: str) -> ast.Expression:
    """Returns the syntax tree of an expression in t, with every name and construct in it known."""
    if len(text) > LONGEST_EXPRESSION:
        raise ReferenceInputError(
            f"an expression may have {LONGEST_EXPRESSION} characters, this has {len(text)}"
        )
    if not text.strip():
        raise ReferenceInputError("the expression is empty; write a number or a formula in t")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        detail = getattr(error, "msg", None) or "cannot be parsed"
        raise ReferenceInputError(f"{text!r} is not a formula: {detail}") from None
    for node in ast.walk(tree):
        if isinstance(node, ast.BitXor):
            raise ReferenceInputError(f"{text!r}: write powers as a**b, not a^b")
        if not isinstance(node, _GRAMMAR) or (isinstance(node, ast.Call) and node.keywords):
            part = ast.unparse(node) if isinstance(node, ast.expr) else type(node).__name__
            raise ReferenceInputError(f"{text!r}: {part!r} is not part of a formula in t")
    _require_known_names(tree)
    normal: ast.Expression = ast.fix_missing_locations(_Normalise().visit(tree))
    return normal


def _require_known_names(tree: ast.Expression) -> None:
    """Raises ReferenceInputError unless functions are called, values are not, and all of them exist."""
    functions = {*FUNCTIONS, "where"}
    called = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    for node in called:
        if not isinstance(node, ast.Name):
            raise ReferenceInputError("only functions can be called in an expression")
        if node.id not in functions:
            raise ReferenceInputError(
                f"unknown function {node.id!r}; {did_you_mean(node.id, sorted(functions))}"
            )
    for name in (node for node in ast.walk(tree) if isinstance(node, ast.Name) and node not in called):
        if name.id in functions:
            raise ReferenceInputError(f"{name.id!r} is a function: write {name.id}(...)")
        if name.id != "t" and name.id not in CONSTANTS:
            raise ReferenceInputError(f"unknown name {name.id!r}; {did_you_mean(name.id, VOCABULARY)}")


@dataclass(frozen=True)
class Expression:
    """A formula in the time t, such as `0.15*cos(0.4*t)` or `where(t < 2, 0.5, 0)`.

    The text is parsed once and never handed to Python's `eval`; only arithmetic, comparisons, `a if c else b`
    and the names of `VOCABULARY` exist in it. A comparison counts 1 where it holds and 0 elsewhere.

    Attributes:
        text: the formula.

    Raises:
        ReferenceInputError: not a formula, or a name that does not exist.
    """

    text: str
    _tree: ast.Expression = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_tree", _parse(self.text))

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,).

        Raises:
            ReferenceInputError: the value at some time is not a finite real number; it names the first such
            time.
        """
        times = np.asarray(t, dtype=np.float64)
        constant = not any(isinstance(node, ast.Name) and node.id == "t" for node in ast.walk(self._tree))
        names: dict[str, float] = dict(CONSTANTS)
        evaluator = SimpleEval(operators=_OPERATORS, functions=FUNCTIONS, names=names)
        if constant and times.size:
            return np.full(times.shape, self._value(evaluator, names, float(times[0])))
        return np.array(
            [self._value(evaluator, names, float(instant)) for instant in times], dtype=np.float64
        )

    def _value(self, evaluator: SimpleEval, names: dict[str, float], t: float) -> float:
        names["t"] = t
        try:
            value = evaluator.eval(self.text, previously_parsed=self._tree.body)
        except (ArithmeticError, ValueError, TypeError, InvalidExpression) as error:
            raise ReferenceInputError(f"{self.text!r} has no value at t = {t:.6g}: {error}", t) from None
        if isinstance(value, complex) or not cmath.isfinite(value):
            raise ReferenceInputError(f"{self.text!r} is {value} at t = {t:.6g}, not a finite number", t)
        return float(value)


def make_signal(value: float | str) -> Expression:
    """Returns the signal of a number or of a formula in t."""
    return Expression(value if isinstance(value, str) else repr(float(value)))


@dataclass(frozen=True)
class Segments:
    """Signals one after the other: `signals[i]` on [ends[i-1], ends[i]), and 0 after the last end.

    Attributes:
        ends: strictly increasing positive times, the last may be infinite, shape n.
        signals: what holds before each end, shape n.

    Raises:
        ReferenceInputError: ends that do not increase, or not as many ends as signals.
    """

    ends: tuple[float, ...]
    signals: tuple[Signal, ...]

    def __post_init__(self) -> None:
        if len(self.ends) != len(self.signals):
            raise ReferenceInputError(f"{len(self.ends)} ends for {len(self.signals)} segments")
        if any(not end > start for start, end in zip((0.0, *self.ends), self.ends, strict=False)):
            raise ReferenceInputError(f"segments must end at increasing times after 0, got {list(self.ends)}")

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,); a formula is asked in its segment only."""
        times = np.asarray(t, dtype=np.float64)
        # A control instant that rounding left just short of an end belongs to the next segment: pieces meant
        # to cancel (speed up for 1 s, brake for 1 s) then hold for equally many periods and stop the leader
        # exactly.
        ends = np.array(self.ends) * (1.0 - 1e-12)
        index = np.searchsorted(ends, times, side="right")
        values = np.zeros(times.shape)
        for i, signal in enumerate(self.signals):
            inside = index == i
            values[inside] = signal(times[inside])
        return values


@dataclass(frozen=True)
class Table:
    """Samples of a signal, held or joined by lines; constant before the first and after the last.

    Attributes:
        times: strictly increasing times, shape (n,).
        values: values at them, shape (n,).
        interpolation: `previous` holds each sample until the next, `linear` joins them.

    Raises:
        ReferenceInputError: no rows, times that do not increase, or a number that is not finite.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]
    interpolation: Interpolation = "previous"

    def __post_init__(self) -> None:
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.size == 0 or times.shape != values.shape:
            raise ReferenceInputError(
                f"a table needs as many times as values, got {times.size} and {values.size}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise ReferenceInputError("a table may hold finite numbers only")
        if times.size > 1 and (late := np.flatnonzero(np.diff(times) <= 0)).size:
            row = int(late[0])
            raise ReferenceInputError(
                f"the times of a table must increase, got {times[row]:g} before {times[row + 1]:g}"
            )

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Returns the values at the times `t`, both of shape (T,)."""
        times, values = np.asarray(self.times), np.asarray(self.values)
        if self.interpolation == "linear":
            return np.asarray(np.interp(t, times, values), dtype=np.float64)
        starts = times - 1e-12 * np.abs(
            times
        )  # as in `Segments`: an instant a rounding early counts as on time
        index = np.searchsorted(starts, t, side="right") - 1
        return np.asarray(values[np.clip(index, 0, None)], dtype=np.float64)


@dataclass(frozen=True)
class Reference:
    """The root's commanded accelerations over time.

    Attributes:
        u_x: forward acceleration [length/time^2].
        u_theta: angular acceleration [rad/time^2].
    """

    u_x: Signal
    u_theta: Signal

    def sample(self, t: np.ndarray) -> np.ndarray:
        """Returns (u_x, u_theta) at the times `t` of shape (T,), shape (T, 2).

        Raises:
            ReferenceInputError: no finite value at some time.
        """
        times = np.asarray(t, dtype=np.float64)
        return np.stack([self.u_x(times), self.u_theta(times)], axis=-1)

    @classmethod
    def from_expressions(cls, u_x: float | str, u_theta: float | str) -> Reference:
        """Returns the reference of two numbers or formulas in t."""
        return cls(make_signal(u_x), make_signal(u_theta))

    @classmethod
    def from_table(
        cls,
        t: Sequence[float],
        u_x: Sequence[float],
        u_theta: Sequence[float],
        interpolation: Interpolation = "previous",
    ) -> Reference:
        """Returns the reference of sampled accelerations, all three of length n."""
        times = tuple(t)
        return cls(Table(times, tuple(u_x), interpolation), Table(times, tuple(u_theta), interpolation))


def make_segments(segments: Sequence[tuple[float | None, float | str]]) -> Segments:
    """Returns the signal of (end, number or formula) pairs; the last end may be None, for ever."""
    if any(end is None for end, _ in segments[:-1]):
        raise ReferenceInputError("only the last segment may go without an end")
    ends = tuple(math.inf if end is None else float(end) for end, _ in segments)
    return Segments(ends, tuple(make_signal(value) for _, value in segments))
