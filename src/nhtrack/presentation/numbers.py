"""Numbers as people read them, on the screen, in figures and on pages: three digits, the unit that reads best."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from nhtrack.arrays import Array

_PREFIXES = ((1.0, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n"), (1e12, "p"))
_FEWEST = 1e-12  # sizes below are rounding


def prefix_of(size: float) -> tuple[float, str]:
    """Returns the factor and the SI prefix with which a size reads as 1 to 1000; none for zero and for large ones."""
    if size < _FEWEST:
        return _PREFIXES[0]
    return next(((f, prefix) for f, prefix in _PREFIXES if f * size >= 0.9995), _PREFIXES[-1])


def common_prefix(values: Array) -> tuple[float, str]:
    """Returns the factor and the SI prefix with which the largest of values reads as 1 to 1000; NaN are unknown."""
    return prefix_of(float(np.abs(values[np.isfinite(values)]).max(initial=0.0)))


def quantity(value: float | None, unit: str) -> str:
    """Returns a number to three digits with an SI prefix: `2.83 m`, `612 nm`; `unknown` where there is none.

    A unit of `1` has no prefix and is not written; one that has a prefix, as `kg m²`, gets no other. `m/s^2` is m/s².
    """
    if value is None:
        return "unknown"
    unit = unit.replace("^2", "²")
    if unit == "1":
        return f"{value:.3g}"
    if unit.startswith("kg"):
        return f"{value:.3g} {unit}"
    if abs(value) < _FEWEST:
        return f"0 {unit}"
    factor, prefix = prefix_of(abs(value))
    return f"{factor * value:.3g} {prefix}{unit}" if abs(value) < 1e4 else f"{value:.3g} {unit}"


def seconds(value: float) -> str:
    """Returns a time in seconds to three digits, more where it is a hundred seconds or longer."""
    return f"{value:.1f} s" if value >= 100 else f"{value:.3g} s"


def degrees(value: float) -> str:
    """Returns an angle [rad] in degrees."""
    return f"{math.degrees(value):.3g}°"


def share(value: float) -> str:
    """Returns a share in per cent; of what rounding leaves none."""
    return f"{100 * value:.3g} %" if abs(value) >= _FEWEST else "0 %"


def percent(share: float) -> str:
    """Returns a share of many in per cent, without the sign, with as many digits as tell it from none and from all.

    0 and 100 mean exactly none and all: 9999 of 10 000 are 99.99.
    """
    rest = 100 * min(share, 1 - share)
    if rest < 1e-9:  # nothing but rounding: a share of a hundred thousand million runs
        return "100" if share > 0.5 else "0"
    digits = max(1, math.ceil(-math.log10(rest)))
    return f"{100 * share:.{digits}f}".rstrip("0").rstrip(".")


def cell(value: float | None, unit: str) -> str:
    """Returns a figure for a table, `-` where there is none or it is NaN.

    Args:
        value: the figure, in its unit; a share for `%`.
        unit: `%`, `s`, `1`, or what takes an SI prefix.
    """
    if value is None or math.isnan(value):
        return "-"
    if unit == "%":
        return share(value)
    return seconds(value) if unit == "s" else quantity(value, unit)


def row_of(figures: Mapping[str, float | None], units: Mapping[str, str]) -> tuple[str, ...]:
    """Returns the cells of some figures, in the order of their names in `units`; see `cell`."""
    return tuple(cell(figures[name], unit) for name, unit in units.items())


def listed(names: list[str], most: int = 5) -> str:
    """Returns names in a row, the last after `and`; beyond so many, how many more there are."""
    if len(names) > most:
        names = [*names[: most - 1], f"{len(names) - most + 1} others"]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def grouped(number: int) -> str:
    """Returns a whole number, in groups of three digits from ten thousand on."""
    return f"{number:,}".replace(",", "\N{NO-BREAK SPACE}") if number >= 10_000 else str(number)


def counted(number: int, noun: str) -> str:
    """Returns how many of something there are: `1 law`, `2 laws`."""
    return f"{grouped(number)} {noun}{'' if number == 1 else 's'}"
