"""A formula in the time as a signal: arithmetic, of which every construct and name is known before it is compiled."""

from __future__ import annotations

import ast
import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from types import CodeType
from typing import Any

import numpy as np

from nhtrack.errors import did_you_mean
from nhtrack.references.contract import ReferenceInputError
from nhtrack.references.series import ORDER, SERIES_FUNCTIONS, moment, series
from nhtrack.section import LARGEST

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

_GRAMMAR: tuple[type[ast.AST], ...] = (
    ast.Expression, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.Name, ast.Load,
    ast.Constant, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow, ast.USub, ast.UAdd, ast.Not,
    ast.And, ast.Or, ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE,
)  # fmt: skip
_FLOAT = "_float"  # no name that a formula may have


class _Normalise(ast.NodeTransformer):
    """Turns `where(c, a, b)` into `a if c else b`, which asks one branch only; whole numbers and truths into floats."""

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

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        return _in_floats(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        return _in_floats(node) if isinstance(node.op, ast.Not) else node


def _in_floats(node: ast.expr) -> ast.AST:
    return ast.copy_location(ast.Call(ast.Name(_FLOAT, ast.Load()), [node], []), node)


def _as_float(value: float) -> float:
    """Returns `value` as a float; float powers overflow where integer powers fill the memory."""
    try:
        return float(value)
    except OverflowError:
        raise ReferenceInputError("a number in the expression is too large") from None


@lru_cache(_KEPT)
def _compiled(text: str, names: frozenset[str] = frozenset()) -> tuple[CodeType, bool]:
    """Returns the code that makes a function of t from an expression in t and further names, and whether it has t."""
    tree = _parse(text, names)
    timed = any(isinstance(node, ast.Name) and node.id == "t" for node in ast.walk(tree))
    given = ast.arguments(posonlyargs=[], args=[ast.arg("t")], kwonlyargs=[], kw_defaults=[], defaults=[])
    function = ast.fix_missing_locations(ast.Expression(ast.Lambda(given, tree.body)))
    return compile(function, "<formula>", "eval"), timed


def _parse(text: str, names: frozenset[str]) -> ast.Expression:
    """Returns the syntax tree of an expression in t and further names, with every name and construct in it known."""
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
    _require_known_names(tree, names)
    normal: ast.Expression = ast.fix_missing_locations(_Normalise().visit(tree))
    return normal


def _depth(tree: ast.AST) -> int:
    """Returns how many nodes are within each other."""
    depth, nodes = 0, [tree]
    while nodes:
        depth, nodes = depth + 1, [child for node in nodes for child in ast.iter_child_nodes(node)]
    return depth


def _require_known_names(tree: ast.Expression, names: frozenset[str]) -> None:
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
        if name.id != "t" and name.id not in CONSTANTS and name.id not in names:
            raise ReferenceInputError(f"unknown name {name.id!r}; {did_you_mean(name.id, VOCABULARY)}")


@dataclass(frozen=True)
class Expression:
    """A formula in the time t, such as `0.15*cos(0.4*t)` or `where(t < 2, 0.5, 0)`.

    The text is parsed, and compiled once it is known to hold arithmetic, comparisons, `a if c else b` and the names
    of `VOCABULARY` only. A comparison counts 1 where it holds and 0 elsewhere.

    Attributes:
        text: the formula.
        is_constant: whether it does not speak of the time.

    Raises:
        ReferenceInputError: not a formula, or a name that does not exist.
    """

    text: str
    is_constant: bool = field(init=False, repr=False, compare=False)
    _code: CodeType = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        code, timed = _compiled(self.text)
        object.__setattr__(self, "is_constant", not timed)
        object.__setattr__(self, "_code", code)

    def __reduce__(self) -> tuple[type[Expression], tuple[str]]:
        """Returns how another process makes the same: compiled code cannot be sent."""
        return Expression, (self.text,)

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
        of = self._function(FUNCTIONS)
        try:
            values = np.fromiter(map(of, times.tolist()), np.float64, times.size)
        except (ArithmeticError, ValueError, TypeError):
            values = np.full(times.shape, math.nan)
        if (np.abs(values) <= LARGEST).all():
            return values
        return np.array([self._value(of, instant) for instant in times.tolist()])  # which tells where it has none

    def derivatives(self, t: np.ndarray) -> np.ndarray:
        """Returns value, first, second and third derivative at the times `t` of shape (T,), shape (T, 4).

        At a corner, such as where `abs` or `where` change over, they are those of the branch that holds there.

        Raises:
            ReferenceInputError: one of them is not a finite real number at some time.
        """
        of = self._function(SERIES_FUNCTIONS)
        rows = [self._terms(of, instant) for instant in np.asarray(t, dtype=np.float64).tolist()]
        return np.asarray(np.array(rows, dtype=np.float64).reshape(-1, ORDER + 1) * _FACTORIALS)

    def _function(self, functions: Mapping[str, Callable[..., Any]]) -> Callable[[Any], Any]:
        """Returns the formula as a function of the time, which sees the given functions and the constants only."""
        function: Callable[[Any], Any] = eval(self._code, _names(functions))  # `_parse` knows everything in it
        return function

    def _terms(self, of: Callable[[Any], Any], t: float) -> tuple[float, ...]:
        terms = series(self._evaluated(of, moment(t), t)).terms
        if any(isinstance(term, complex) or not math.isfinite(term) for term in terms):
            raise ReferenceInputError(f"{self.text!r} has no finite derivatives at t = {t:.6g}", t)
        return terms

    def _value(self, of: Callable[[Any], Any], t: float) -> float:
        value = self._evaluated(of, t, t)
        if isinstance(value, complex) or not cmath.isfinite(value):
            raise ReferenceInputError(f"{self.text!r} is {value} at t = {t:.6g}, not a finite number", t)
        if abs(value) > LARGEST:
            raise ReferenceInputError(f"{self.text!r} is {value:g} at t = {t:.6g}, above {LARGEST:g} in magnitude", t)
        return float(value)

    def _evaluated(self, of: Callable[[Any], Any], at: Any, t: float) -> Any:
        try:
            return of(at)
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ReferenceInputError(f"{self.text!r} has no value at t = {t:.6g}: {_reason(error)}", t) from None


def _names(more: Mapping[str, Any]) -> dict[str, Any]:
    """Returns all that a formula sees beside the time."""
    return {"__builtins__": {}, _FLOAT: float, **CONSTANTS, **more}


@lru_cache(_KEPT)
def _kept_sample(expression: Expression, times: bytes) -> np.ndarray:
    """Returns values at times: a scenario is judged, built and told of with the same ones, and a study's are alike."""
    return expression._sample(np.frombuffer(times))


def _reason(error: Exception) -> str:
    """Returns why something cannot be computed; Python has numbers or other words for it."""
    kinds = ((OverflowError, "too large a number"), (ZeroDivisionError, "division by zero"))
    return next((words for kind, words in kinds if isinstance(error, kind)), str(error))


def number_of(text: str) -> float:
    """Returns the number that a formula without the time is, such as `6*pi`.

    Raises:
        ReferenceInputError: no formula, one of the time, or one without a value.
    """
    formula = Expression(text)
    if not formula.is_constant:
        raise ReferenceInputError(f"{text!r} depends on the time t")
    return float(formula(np.zeros(1))[0])


def value_of(formula: str, at: Mapping[str, float]) -> float:
    """Returns the value of a formula in names, at numbers that stand for them.

    Raises:
        ReferenceInputError: no formula, one with other names, or one without a finite real value there.
    """
    code, _ = _compiled(formula, frozenset(at))
    try:
        value = eval(code, _names({**FUNCTIONS, **at}))(math.nan)
    except (ArithmeticError, ValueError, TypeError) as error:
        raise ReferenceInputError(f"{formula!r} has no value: {_reason(error)}") from None
    if isinstance(value, complex) or not cmath.isfinite(value):
        raise ReferenceInputError(f"{formula!r} is {value}, not a finite number")
    return float(value)


def make_signal(value: float | str) -> Expression:
    """Returns the signal of a number or of a formula in t."""
    return Expression(value if isinstance(value, str) else repr(float(value)))
