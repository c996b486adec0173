"""The leader's input: formulas against numpy, pieces, tables, and what is not a formula."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tolerances as tol
from nhtrack.references import (
    Expression,
    Reference,
    ReferenceInputError,
    Segments,
    Table,
    TableInput,
    make_segments,
    make_signal,
)

TIMES = np.linspace(0.0, 10.0, 101)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10", np.full(101, 10.0)),
        ("0.15*cos(0.4*t)", 0.15 * np.cos(0.4 * TIMES)),
        ("-t**2/3 + 2*t % 3", -(TIMES**2) / 3 + (2 * TIMES) % 3),
        ("where(t < 2, 0.5, -0.5)", np.where(TIMES < 2, 0.5, -0.5)),
        ("0.5 if 1 <= t < 3 else 0", np.where((TIMES >= 1) & (TIMES < 3), 0.5, 0.0)),
        ("where(t > 0, sin(t)/t, 1)", np.sinc(TIMES / np.pi)),
        ("(t > 4) * 2 - (t >= 8 or t < 1)", 2.0 * (TIMES > 4) - ((TIMES >= 8) | (TIMES < 1))),
        ("0.5*sign(sin(2*pi*t/20))", 0.5 * np.sign(np.sin(2 * np.pi * TIMES / 20))),
        ("e**(-t) - exp(-t)", np.zeros(101)),
        ("min(t, 3) + max(t, 5, 7) + abs(-t)", np.minimum(TIMES, 3) + np.maximum(TIMES, 7) + TIMES),
        ("atan2(sin(t), cos(t)) + floor(t) - ceil(t)", np.arctan2(np.sin(TIMES), np.cos(TIMES)) - (TIMES % 1 > 0)),
        ("t // 3 + sqrt(t) + log(t + 1) + tanh(t)", TIMES // 3 + np.sqrt(TIMES) + np.log1p(TIMES) + np.tanh(TIMES)),
    ],
)
def test_a_formula_is_what_numpy_makes_of_it(text: str, expected: np.ndarray) -> None:
    np.testing.assert_allclose(Expression(text)(TIMES), expected, rtol=tol.HAND, atol=tol.HAND)


numbers = st.floats(-3, 3).map(lambda x: f"({x!r})")
formulas = st.recursive(
    numbers | st.just("t"),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda part: f"({part[0]} {part[1]} {part[2]})"),
        st.tuples(st.sampled_from(["sin", "cos", "tanh", "abs"]), inner).map(lambda part: f"{part[0]}({part[1]})"),
        st.tuples(inner, inner, inner).map(lambda part: f"where({part[0]} < {part[1]}, {part[1]}, {part[2]})"),
    ),
    max_leaves=8,
)
PYTHON = {name: getattr(math, name) for name in ("sin", "cos", "tanh")} | {"abs": abs}


@pytest.mark.slow
@given(formulas)
def test_any_formula_is_bit_for_bit_what_python_makes_of_it(text: str) -> None:
    names = PYTHON | {"where": lambda condition, a, b: a if condition else b}
    expected = [eval(text, names | {"t": t}) for t in TIMES.tolist()]
    if all(map(math.isfinite, expected)):
        assert Expression(text)(TIMES).tolist() == expected
    else:
        with pytest.raises(ReferenceInputError, match="not a finite number"):
            Expression(text)(TIMES)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the expression is empty"),
        ("0.2*cos(t", "is not a formula"),
        ("2 t", "is not a formula"),
        ("t^2", "write powers as a**b"),
        ("sim(t)", "unknown function 'sim'; did you mean 'sin'?"),
        ("2*tt", "unknown name 'tt'"),
        ("cos", "'cos' is a function: write cos(...)"),
        ("where(t < 1, 2)", "takes three arguments, got 2"),
        ("'text'", "only numbers"),
        ("t.real", "'t.real' is not part of a formula"),
        ("[t for x in t]", "is not part of a formula"),
        ("lambda: t", "is not part of a formula"),
        ("().__class__.__bases__[0]", "is not part of a formula"),
        ("(t := 3)", "is not part of a formula"),
        ("sin(x=t)", "is not part of a formula"),
        ("__import__('os')", "unknown function '__import__'"),
        ("_float(t)", "unknown function '_float'"),
        ("__builtins__", "unknown name '__builtins__'"),
        ("max(*t)", "'*t' is not part of a formula"),
        ("f'{t}'", "is not part of a formula"),
        ("t" + "+t" * 1000, "may have 1000 characters"),
        ("1" * 400, "too large"),
        ("-" * 990 + "t", "may be nested 200 deep"),
    ],
)
def test_what_is_not_a_formula_is_refused_when_it_is_written(text: str, message: str) -> None:
    with pytest.raises(ReferenceInputError) as caught:
        Expression(text)
    assert message in str(caught.value)
    assert caught.value.t is None


@pytest.mark.parametrize(
    ("text", "t", "message"),
    [
        ("1/(t - 5)", 5.0, "division by zero"),
        ("((t == t) + (not 0))**((t == t) + (not 0))**9**9**9", 0.0, "too large a number"),
        ("sqrt(4.95 - t)", 5.0, "math domain error"),
        ("(4.95 - t)**0.5", 5.0, "not a finite number"),
        ("exp(200*t)", 0.2, "2.35385e+17 at t = 0.2, above 1e+12 in magnitude"),
        ("exp(9000*t)", 0.1, "too large a number"),
        ("9**9**9**9", 0.0, ""),
        ("sin(1, 2)", 0.0, "exactly one argument"),
    ],
)
def test_a_formula_without_a_value_names_the_first_time(text: str, t: float, message: str) -> None:
    with pytest.raises(ReferenceInputError) as caught:
        Expression(text)(TIMES)
    assert message in str(caught.value)
    assert caught.value.t == pytest.approx(t, abs=tol.HAND)


def test_where_asks_one_branch_only() -> None:
    np.testing.assert_array_equal(Expression("where(t == 0, 1, 0/t)")(np.array([0.0, 2.0])), [1.0, 0.0])


def test_segments_hold_up_to_their_end_and_nothing_after() -> None:
    signal = make_segments([(1.0, 2.0), (2.5, "t"), (4.0, -2)])
    times = np.array([0.0, 0.999, 1.0, 2.4, 2.5, 3.999, 4.0, 100.0])
    np.testing.assert_array_equal(signal(times), [2.0, 2.0, 1.0, 2.4, -2.0, -2.0, 0.0, 0.0])


def test_a_last_segment_without_end_holds_for_ever() -> None:
    np.testing.assert_array_equal(make_segments([(1.0, 2.0), (None, 3.0)])(np.array([0.5, 1e9])), [2.0, 3.0])


@pytest.mark.slow
@given(st.integers(1, 50), st.sampled_from([0.01, 0.0025, 0.1, 1 / 300, 0.007]))
def test_equal_pieces_last_equally_many_periods(count: int, step: float) -> None:
    """Ends and rows that are control instants up to rounding: speeding up and braking cancel exactly."""
    end = count * step
    instants = np.concatenate([[0.0], np.cumsum(np.full(3 * count - 1, step))])  # each sum rounds
    expected = [1.0] * count + [-1.0] * count + [0.0] * count
    assert make_segments([(end, 1.0), (2 * end, -1.0)])(instants).tolist() == expected
    assert Table((0.0, end, 2 * end), (1.0, -1.0, 0.0), "previous")(instants).tolist() == expected


@pytest.mark.parametrize("ends", [(2.0, 1.0), (1.0, 1.0), (0.0,), (-1.0, 1.0), (math.nan,)])
def test_segments_end_later_and_later(ends: tuple[float, ...]) -> None:
    with pytest.raises(ReferenceInputError, match="increasing times"):
        Segments(ends, tuple(make_signal(0) for _ in ends))


def test_only_the_last_segment_goes_without_an_end() -> None:
    with pytest.raises(ReferenceInputError, match="only the last segment"):
        make_segments([(None, 1.0), (2.0, 1.0)])


def reference_of(interpolation: str) -> Reference:
    table = {"t": [0.0, 1.0, 2.0], "u_x": [0.0, 10.0, 20.0], "u_theta": [1.0, 1.0, -1.0]}
    return TableInput.model_validate({"table": table, "interpolation": interpolation}).reference()


def test_a_table_holds_or_joins() -> None:
    reference = reference_of("previous")
    np.testing.assert_array_equal(reference.sample(np.array([0.5, 1.0, 5.0])), [[0, 1], [10, 1], [20, -1]])
    joined = reference_of("linear")
    np.testing.assert_allclose(
        joined.sample(np.array([0.5, 1.5, 5.0])), [[5, 1], [15, 0], [0, 0]], rtol=tol.HAND, atol=tol.HAND
    )


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ((), (), "as many times as values"),
        ((0.0, 1.0), (1.0,), "as many times as values"),
        ((0.0, 2.0, 1.0), (0.0, 0.0, 0.0), "must increase, got 2 before 1"),
        ((0.0, 1.0), (0.0, math.nan), "finite"),
    ],
)
def test_a_table_of_another_kind_is_refused(times: tuple[float, ...], values: tuple[float, ...], message: str) -> None:
    with pytest.raises(ReferenceInputError, match=message):
        Table(times, values)


def test_a_reference_pairs_two_signals() -> None:
    sampled = Reference(make_signal(10), make_signal("0.15*cos(0.4*t)")).sample(TIMES)
    assert sampled.shape == (101, 2)
    np.testing.assert_allclose(sampled, np.stack([np.full(101, 10.0), 0.15 * np.cos(0.4 * TIMES)], -1), rtol=tol.HAND)
    assert Reference(make_signal(0), make_signal("t")).sample(np.empty(0)).shape == (0, 2)
