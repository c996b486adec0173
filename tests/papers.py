"""What a robot's README says in tables, and the statics of parts: shared by the tests of the bundled robots."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

MODELS = Path(__file__).resolve().parents[1] / "models"


def readme_table(name: str, heading: str, nth: int = 0) -> list[list[str]]:
    """Cells of the rows of a table under a heading of a robot's README, without its head."""
    section = (MODELS / name / "README.md").read_text().split(f"## {heading}\n")[1].split("\n## ")[0]
    table = re.findall(r"^\|.+(?:\n\|.+)*", section, flags=re.MULTILINE)[nth]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table.split("\n")[2:]]


def readme_quantity(cell: str) -> tuple[float, float]:
    """The number that a cell begins with, in SI units, and half a unit of its last digit."""
    found = re.match(r"(-?\d+)(?:\.(\d+))?(?:e(-?\d+))? (mm|m|kg m\^2|kg|N m s/rad|N m|rad/s)(?![\w/])", cell)
    assert found, cell
    whole, decimals, exponent, unit = found.groups(default="")
    scale = 10.0 ** int(exponent or 0) * (1e-3 if unit == "mm" else 1.0)
    return float(f"{whole}.{decimals or 0}") * scale, 0.5 * 10.0 ** -len(decimals) * scale


def numbers(cell: str) -> list[float]:
    """All numbers of a cell, in the order in which they stand."""
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", cell)]


def of_boxes(mass: np.ndarray, at: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass and inertia about it of uniform boxes: shapes (k,), (k, 3), (k, 3) -> (3,), (3, 3)."""
    own = [m / 12 * (s @ s * np.eye(3) - np.diag(s**2)) for m, s in zip(mass, size, strict=True)]
    return of_parts(mass, at, np.array(own))


def of_parts(mass: np.ndarray, at: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass and inertia about it of parts with their own inertias, by Steiner."""
    com = mass @ at / mass.sum()
    moved = [m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(mass, at - com, strict=True)]
    return com, own.sum(axis=0) + np.sum(moved, axis=0)
