"""Quantities as people read them: three digits, the unit that reads best."""

from __future__ import annotations

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def quantity(value: float | None, unit: str) -> str:
    """Returns a number to three digits with an SI prefix: `2.83 m`, `0.612 µm`; `unknown` where there is none."""
    if value is None:
        return "unknown"
    size = abs(value)
    if size == 0.0 or size < 1e-12:
        return f"0 {unit}"
    factor, prefix = next(((f, p) for f, p in _PREFIXES if size >= 0.9995 * f), _PREFIXES[-1])
    return f"{value / factor:.3g} {prefix}{unit}" if size < 1e4 else f"{value:.3g} {unit}"


def seconds(value: float) -> str:
    """Returns a time in seconds to three digits, more where it is a hundred seconds or longer."""
    return f"{value:.1f} s" if value >= 100 else f"{value:.3g} s"


def share(value: float) -> str:
    """Returns a share in per cent."""
    return f"{100 * value:.3g} %"


def listed(names: list[str], most: int = 5) -> str:
    """Returns names in a row, the last after `and`; beyond so many, how many more there are."""
    if len(names) > most:
        names = [*names[: most - 1], f"{len(names) - most + 1} others"]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def grouped(number: int) -> str:
    """Returns a whole number, in groups of three digits from ten thousand on."""
    return f"{number:,}".replace(",", "\N{NO-BREAK SPACE}") if number >= 10_000 else str(number)
