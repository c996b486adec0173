"""A formula in the time as a signal, read by a parser of its own: nothing is handed to Python's `eval`."""

from __future__ import annotations

import ast
import cmath
import math
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from simpleeval import InvalidExpression, SimpleEval

from nhtrack.errors import did_you_mean
from nhtrack.references.contract import ReferenceInputError
from nhtrack.references.series import ORDER, SERIES_FUNCTIONS, moment, series

_KEPT, _LONGEST_KEPT = 32, 20_000  # samplings that are kept, and values of each at most
LONGEST_EXPRESSION = 1000  # characters; keeps a hostile text from exhausting Python's parser
DEEPEST_EXPRESSION = 200  # operations within operations; keeps it from exhausting Python's stack


def _as_floats(of: Callable[..., Any]) -> Callable[..., float]:
    """Returns a function with its values as floats: whole numbers of Python grow until they fill the memory."""
    return lambda *values: float(of(*values))


FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")},
    **{name: getattr(math, name) for name in ("sinh", "cosh", "tanh", "exp", "log", "sqrt")},
    **{name: _as_floats(getattr(math, name)) for name in ("floor", "ceil")},
    "abs": abs,
    "min": min,
    "max": max,
    "sign": lambda value: float(value > 0) - float(value < 0),
}
CONSTANTS: dict[str, float] = {"pi": math.pi, "e": math.e}
_FACTORIALS = np.array([math.factorial(k) for k in range(ORDER + 1)])
VOCABULARY: tuple[str, ...] = ("t", *CONSTANTS, *FUNCTIONS, "where")

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Not: _as_floats(operator.not_),
    ast.Eq: _as_floats(operator.eq),
    ast.NotEq: _as_floats(operator.ne),
    ast.Lt: _as_floats(operator.lt),
    ast.LtE: _as_floats(operator.le),
    ast.Gt: _as_floats(operator.gt),
    ast.GtE: _as_floats(operator.ge),
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
    if _depth(tree) > DEEPEST_EXPRESSION:
        raise ReferenceInputError(f"an expression may be nested {DEEPEST_EXPRESSION} deep, this is {_depth(tree)}")
    for node in ast.walk(tree):
        if isinstance(node, ast.BitXor):
            raise ReferenceInputError(f"{text!r}: write powers as a**b, not a^b")
        if not isinstance(node, _GRAMMAR) or (isinstance(node, ast.Call) and node.keywords):
            part = ast.unparse(node) if isinstance(node, ast.expr) else type(node).__name__
            raise ReferenceInputError(f"{text!r}: {part!r} is not part of a formula in t")
    _require_known_names(tree)
    normal: ast.Expression = ast.fix_missing_locations(_Normalise().visit(tree))
    return normal


def _depth(tree: ast.AST) -> int:
    """Returns how many nodes are within each other."""
    depth, nodes = 0, [tree]
    while nodes:
        depth, nodes = depth + 1, [child for node in nodes for child in ast.iter_child_nodes(node)]
    return depth


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
        if self.is_constant and times.size:
            return np.full(times.shape, self._sample(times[:1])[0])
        if times.size > _LONGEST_KEPT:
            return self._sample(times)
        return _kept_sample(self, times.tobytes()).copy()

    def _sample(self, times: np.ndarray) -> np.ndarray:
        names: dict[str, Any] = dict(CONSTANTS)
        evaluator = SimpleEval(operators=_OPERATORS, functions=FUNCTIONS, names=names)
        return np.array([self._value(evaluator, names, float(instant)) for instant in times], dtype=np.float64)

    @property
    def is_constant(self) -> bool:
        """Whether the formula does not speak of the time."""
        return not any(isinstance(node, ast.Name) and node.id == "t" for node in ast.walk(self._tree))

    def derivatives(self, t: np.ndarray) -> np.ndarray:
        """Returns value, first, second and third derivative at the times `t` of shape (T,), shape (T, 4).

        At a corner, such as where `abs` or `where` change over, they are those of the branch that holds there.

        Raises:
            ReferenceInputError: one of them is not a finite real number at some time.
        """
        names: dict[str, Any] = dict(CONSTANTS)
        evaluator = SimpleEval(operators=_OPERATORS, functions=SERIES_FUNCTIONS, names=names)
        rows = [self._terms(evaluator, names, float(instant)) for instant in t]
        return np.asarray(np.array(rows, dtype=np.float64).reshape(-1, ORDER + 1) * _FACTORIALS)

    def _terms(self, evaluator: SimpleEval, names: dict[str, Any], t: float) -> tuple[float, ...]:
        names["t"] = moment(t)
        terms = series(self._evaluated(evaluator, t)).terms
        if any(isinstance(term, complex) or not math.isfinite(term) for term in terms):
            raise ReferenceInputError(f"{self.text!r} has no finite derivatives at t = {t:.6g}", t)
        return terms

    def _value(self, evaluator: SimpleEval, names: dict[str, Any], t: float) -> float:
        names["t"] = t
        value = self._evaluated(evaluator, t)
        if isinstance(value, complex) or not cmath.isfinite(value):
            raise ReferenceInputError(f"{self.text!r} is {value} at t = {t:.6g}, not a finite number", t)
        return float(value)

    def _evaluated(self, evaluator: SimpleEval, t: float) -> Any:
        try:
            return evaluator.eval(self.text, previously_parsed=self._tree.body)
        except (ArithmeticError, ValueError, TypeError, InvalidExpression) as error:
            raise ReferenceInputError(f"{self.text!r} has no value at t = {t:.6g}: {error}", t) from None


@lru_cache(_KEPT)
def _kept_sample(expression: Expression, times: bytes) -> np.ndarray:
    """Returns values at times: a scenario is judged, built and told of with the same ones, and a study's are alike."""
    return expression._sample(np.frombuffer(times))


def number_of(text: str) -> float | None:
    """Returns the number that a formula without the time is, such as `6*pi`; None where it is none."""
    try:
        formula = Expression(text)
        return float(formula(np.zeros(1))[0]) if formula.is_constant else None
    except ReferenceInputError:
        return None


def make_signal(value: float | str) -> Expression:
    """Returns the signal of a number or of a formula in t."""
    return Expression(value if isinstance(value, str) else repr(float(value)))
