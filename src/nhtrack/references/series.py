"""Numbers that carry their derivatives in time: what a formula is asked with for its derivatives.

A series is the beginning of a Taylor series, c_0 + c_1 s + c_2 s^2 + c_3 s^3 in the time s from the one asked at. Sums
and products are those of polynomials; a function f with f' = g is the integral of u' g(u) (Griewank and Walther,
Evaluating Derivatives, 2008, chapter 13).
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

ORDER = 3
_TERMS = range(ORDER + 1)
Number: TypeAlias = "float | Series"


@dataclass(frozen=True, eq=False)
class Series:
    """The beginning of a Taylor series; compares by its value.

    Attributes:
        terms: c_0 to c_3.
    """

    terms: tuple[float, ...]

    def __add__(self, other: Number) -> Series:
        if not isinstance(other, Series):
            return Series((self.terms[0] + other, *self.terms[1:]))
        return Series(tuple(map(operator.add, self.terms, other.terms)))

    def __sub__(self, other: Number) -> Series:
        return self + -series(other)

    def __mul__(self, other: Number) -> Series:
        if not isinstance(other, Series):
            return Series(tuple([term * other for term in self.terms]))
        a, b = self.terms, other.terms
        return Series(tuple(sum(a[j] * b[k - j] for j in range(k + 1)) for k in _TERMS))

    def __truediv__(self, other: Number) -> Series:
        a, b = self.terms, series(other).terms
        quotient: list[float] = []
        for k in _TERMS:
            quotient.append((a[k] - sum(b[j] * quotient[k - j] for j in range(1, k + 1))) / b[0])
        return Series(tuple(quotient))

    def __floordiv__(self, other: Number) -> Series:
        return series(self.terms[0] // float(other))

    def __mod__(self, other: Number) -> Series:
        return self - series(other) * (self // other)

    def __pow__(self, other: Number) -> Series:
        exponent = series(other)
        if any(exponent.terms[1:]):
            return exp(exponent * log(self))
        return _power(self, exponent.terms[0])

    def __radd__(self, other: float) -> Series:
        return self + other

    def __rsub__(self, other: float) -> Series:
        return series(other) - self

    def __rmul__(self, other: float) -> Series:
        return self * other

    def __rtruediv__(self, other: float) -> Series:
        return series(other) / self

    def __rfloordiv__(self, other: float) -> Series:
        return series(other) // self

    def __rmod__(self, other: float) -> Series:
        return series(other) % self

    def __rpow__(self, other: float) -> Series:
        return series(other) ** self

    def __neg__(self) -> Series:
        return Series(tuple(map(operator.neg, self.terms)))

    def __abs__(self) -> Series:
        return -self if self.terms[0] < 0 else self

    def __float__(self) -> float:
        return float(self.terms[0])

    def __bool__(self) -> bool:
        return self.terms[0] != 0

    def __eq__(self, other: object) -> bool:
        return float(self) == float(other)  # type: ignore[arg-type]

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __lt__(self, other: Number) -> bool:
        return float(self) < float(other)

    def __le__(self, other: Number) -> bool:
        return float(self) <= float(other)

    def __gt__(self, other: Number) -> bool:
        return float(self) > float(other)

    def __ge__(self, other: Number) -> bool:
        return float(self) >= float(other)


def series(value: Number) -> Series:
    """Returns a number as a series, which does not change in time unless it is one."""
    return value if isinstance(value, Series) else Series((float(value), *[0.0] * ORDER))


def moment(t: float) -> Series:
    """Returns the time itself, at t."""
    return Series((t, 1.0, *[0.0] * (ORDER - 1)))


def exp(value: Number) -> Series:
    """Returns e to the power of a number."""
    u = series(value).terms
    found = [math.exp(u[0])]
    for k in _TERMS[1:]:
        found.append(sum(j * u[j] * found[k - j] for j in range(1, k + 1)) / k)
    return Series(tuple(found))


def log(value: Number) -> Series:
    """Returns the natural logarithm of a number."""
    u = series(value)
    return _integral(math.log(u.terms[0]), u, 1.0 / u)


def _integral(value: float, u: Series, slope: Series) -> Series:
    """Returns f(u) from its value and the series of f' at u."""
    rate = [(k + 1) * u.terms[k + 1] for k in range(ORDER)]
    found = [sum(rate[j] * slope.terms[k - j] for j in range(k + 1)) / (k + 1) for k in range(ORDER)]
    return Series((value, *found))


def _power(u: Series, exponent: float) -> Series:
    """Returns u to a power that does not change; whole ones are products, so that u may be zero."""
    if 0 <= exponent <= ORDER + 1 and exponent == int(exponent):
        found = series(1.0)
        for _ in range(int(exponent)):
            found = found * u
        return found
    base, terms = u.terms, [u.terms[0] ** exponent]
    if base[0] == 0 and (exponent > ORDER or not any(base)):
        return series(terms[0])
    for k in _TERMS[1:]:
        total = sum((exponent * j - (k - j)) * base[j] * terms[k - j] for j in range(1, k + 1))
        terms.append(total / (k * base[0]))
    return Series(tuple(terms))


def _waves(value: Number, sine: Callable[[float], float], cosine: Callable[[float], float], sign: int) -> list[Series]:
    """Returns s(u) and c(u), where s' = c and c' = sign * s."""
    u = series(value).terms
    s, c = [sine(u[0])], [cosine(u[0])]
    for k in _TERMS[1:]:
        rise = fall = 0.0
        for j in range(1, k + 1):
            rise += j * u[j] * c[k - j]
            fall += j * u[j] * s[k - j]
        s.append(rise / k)
        c.append(sign * fall / k)
    return [Series(tuple(s)), Series(tuple(c))]


def _circular(value: Number) -> list[Series]:
    return _waves(value, math.sin, math.cos, -1)


def _hyperbolic(value: Number) -> list[Series]:
    return _waves(value, math.sinh, math.cosh, 1)


def _quotient(pair: list[Series]) -> Series:
    return pair[0] / pair[1]


def _arc(value: Number, of: Callable[[float], float], sign: float) -> Series:
    u = series(value)
    return _integral(of(u.terms[0]), u, sign / _power(1.0 - u * u, 0.5))


def _atan(value: Number) -> Series:
    u = series(value)
    return _integral(math.atan(u.terms[0]), u, 1.0 / (1.0 + u * u))


def _atan2(y: Number, x: Number) -> Series:
    above, along = series(y), series(x)
    nearly = _atan(above / along) if abs(along) >= abs(above) else -_atan(along / above)
    return Series((math.atan2(above.terms[0], along.terms[0]), *nearly.terms[1:]))


def _steps(of: Callable[[float], float]) -> Callable[[Number], Series]:
    """Returns a function that does not change but in jumps."""
    return lambda value: series(of(float(value)))


SERIES_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": lambda u: _circular(u)[0],
    "cos": lambda u: _circular(u)[1],
    "tan": lambda u: _quotient(_circular(u)),
    "sinh": lambda u: _hyperbolic(u)[0],
    "cosh": lambda u: _hyperbolic(u)[1],
    "tanh": lambda u: _quotient(_hyperbolic(u)),
    "asin": lambda u: _arc(u, math.asin, 1.0),
    "acos": lambda u: _arc(u, math.acos, -1.0),
    "atan": _atan,
    "atan2": _atan2,
    "exp": exp,
    "log": lambda u, *base: log(u) / log(*base) if base else log(u),
    "sqrt": lambda u: _power(series(u), 0.5),
    "floor": _steps(math.floor),
    "ceil": _steps(math.ceil),
    "sign": _steps(lambda value: float(value > 0) - float(value < 0)),
    "abs": abs,
    "min": min,
    "max": max,
}
