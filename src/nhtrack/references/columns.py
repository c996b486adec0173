"""Columns of numbers from a text file, each number with its line and column: what all files of inputs are read by."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from nhtrack.files.carried import read_at
from nhtrack.files.text import TextError, read_text
from nhtrack.references.samples import increasing_faults
from nhtrack.section import LARGEST

Cell: TypeAlias = tuple[int, str]  # where it begins in its line, from one, and its text

_MOST_FAULTS = 10  # of one file that are told
_MOST_BYTES = 100 * 10**6  # of a file
_CSV_CELL = re.compile(r'\s*("(?:[^"]|"")*"[^,]*|[^,]*)(?:,|$)')
_WORD = re.compile(r"\S+")


class FileFaults(ValueError):
    """What is wrong with a file, one text a fault, each with file, line and column.

    Attributes:
        faults: the texts.
    """

    def __init__(self, faults: Iterable[str]) -> None:
        found = list(faults)
        rest = len(found) - _MOST_FAULTS
        self.faults = (*found[:_MOST_FAULTS], *([f"and {rest} more faults like these"] if rest > 0 else []))
        super().__init__("\n".join(self.faults))


@dataclass(frozen=True)
class Columns:
    """Columns of a file and where each number of them stands.

    Attributes:
        file: name of the file.
        values: the columns by their names, all of one length.
        places: line and column of each number, from one.
    """

    file: str
    values: Mapping[str, list[float]]
    places: Mapping[str, list[tuple[int, int]]] = field(repr=False)

    def fault(self, row: int, name: str, message: str) -> str:
        """Returns what is wrong with a number as a text with its place."""
        line, column = self.places[name][row]
        return f"{self.file}:{line}:{column}: {message}"


def read_csv(path: Path, names: Sequence[str]) -> Columns:
    """Returns columns of a CSV file whose first line names them; others are passed over.

    Args:
        path: of the file.
        names: of the columns.

    Raises:
        FileFaults: no such file, not text, a column missing or there twice, no rows, a cell that is no finite number.
    """
    lines = text_lines(path)
    header = _header(lines)
    missing = [name for name in names if name not in header]
    twice = [name for name in names if header.count(name) > 1]
    if missing or twice:
        got = ", ".join(header) or "nothing"
        commas = "; separate them by commas" if len(header) == 1 and re.search(r"\w[;\t |]+\w", got) else ""
        wrong = f"expected the columns {', '.join(names)}, got {got}{commas}"
        twofold = f"the column {twice[0]} is there twice" if twice else ""
        raise FileFaults([f"{path.name}:1:1: {wrong if missing else twofold}"])
    where = [header.index(name) for name in names]
    rows = [(number, _csv_cells(line)) for number, line in enumerate(lines[1:], start=2) if line.strip(", \t")]
    return _columns(path, names, where, rows, "no rows under the header", len(header))


def header_of(path: Path) -> list[str]:
    """Returns the names of the columns of a CSV file; raises as `text_lines`."""
    return _header(text_lines(path))


def _header(lines: Sequence[str]) -> list[str]:
    return [cell.strip(' "') for _, cell in _csv_cells(lines[0])] if lines[0] else []


def read_words(path: Path, names: Sequence[str]) -> Columns:
    """Returns columns of a file of numbers with blanks between them, in this order; `#` begins a comment.

    Raises:
        FileFaults: see `read_csv`.
    """
    rows = []
    for number, line in enumerate(text_lines(path), start=1):
        cells = [(found.start() + 1, found.group()) for found in _WORD.finditer(line.partition("#")[0])]
        if cells:
            rows.append((number, cells))
    return _columns(path, names, range(len(names)), rows, f"no rows of {' '.join(names)}")


def text_lines(path: Path) -> list[str]:
    """Returns the lines of a text file.

    Raises:
        FileFaults: it cannot be read, or is not UTF-8 text.
    """
    try:
        text = read_text(read_at(path), _MOST_BYTES)
        return text.removesuffix("\n").split("\n")  # form feeds do not end a line for editors
    except TextError as error:
        place = f"{path.name}{error.place}" if error.line else str(path)
        raise FileFaults([f"{place}: {error.reason}"]) from None


def _csv_cells(line: str) -> list[Cell]:
    """Returns the cells of a line, which may stand in quotation marks."""
    cells: list[Cell] = []
    end = 0
    while end <= len(line) and (found := _CSV_CELL.match(line, end)):
        cells.append((found.start(1) + 1, found.group(1).strip()))
        if not found.group().endswith(","):
            break
        end = found.end()
    return cells


def _columns(
    path: Path,
    names: Sequence[str],
    where: Sequence[int],
    rows: Sequence[tuple[int, Sequence[Cell]]],
    none: str,
    most: float = math.inf,
) -> Columns:
    """Returns columns of rows, of which none may have more than so many cells; the first is of times that increase."""
    values: dict[str, list[float]] = {name: [] for name in names}
    places: dict[str, list[tuple[int, int]]] = {name: [] for name in names}
    faults: list[tuple[int, int, str]] = [] if rows else [(1, 1, none)]
    for line, cells in rows:
        if len(cells) > most:
            faults.append((line, cells[int(most)][0], f"{len(cells)} values under {most} columns"))
        for name, index in zip(names, where, strict=True):
            if index >= len(cells):
                column = cells[-1][0] + len(cells[-1][1]) if cells else 1
                faults.append((line, column, f"no value for {name}"))
                continue
            column, text = cells[index]
            number = _number(text)
            if abs(number) <= LARGEST:
                values[name].append(number)
                places[name].append((line, column))
            else:
                kind = f"{LARGEST:g} in magnitude at most" if math.isfinite(number) else "a finite number"
                faults.append((line, column, f"{name} must be {kind}, got {text!r}"))
    for row, name, message in increasing_faults(values[names[0]], names[0]):
        faults.append((*places[name][row], message))
    if faults:
        raise FileFaults(f"{path.name}:{line}:{column}: {message}" for line, column, message in sorted(faults))
    return Columns(path.name, values, places)


def _number(text: str) -> float:
    quoted = len(text) > 1 and text[0] == text[-1] == '"'
    try:
        return float(text[1:-1] if quoted else text)
    except ValueError:
        return math.nan
