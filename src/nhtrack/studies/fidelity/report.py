"""The page of the fidelity suite: every figure beside the budget it has to keep to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from nhtrack.presentation.numbers import listed, share
from nhtrack.report.page import Page, write_page

FindingRow = Mapping[str, Any]  # of a finding, as plain values


def write_fidelity_page(findings: Sequence[FindingRow], command: str, versions: Mapping[str, str], path: Path) -> Path:
    """Writes the page of the fidelity suite; the file appears under its name only once it is whole.

    Args:
        findings: rows with `robot`, `group`, `check`, `value` (None where it is not finite), `unit`, `budget`, `sense`,
            `cause`, `ok` and `explained`.
        command: what measures them again.
        versions: of what measured them.
        path: file to write.
    """
    return write_page(fidelity_page(findings, command, versions), path)


def fidelity_page(findings: Sequence[FindingRow], command: str, versions: Mapping[str, str]) -> Page:
    """Returns what the page of the fidelity suite shows. Arguments as `write_fidelity_page`."""
    robots = list(dict.fromkeys(row["robot"] for row in findings))
    groups = list(dict.fromkeys(row["group"] for row in findings))
    broken = [row for row in findings if not row["ok"] and not row["explained"]]
    return Page(
        "fidelity.html.j2",
        "Wheels against mechanics and the ideal robot",
        {"checks": "Checks"},
        fidelity_verdicts(findings),
        [("With the same versions, this measures the same:", command)],
        versions,
        tiles=_tiles(findings, robots),
        alarm=f"{_budgets(len(broken))} broken, and nothing explains it." if broken else "",
        scripts=("fidelity.js",),
        plots=False,
        contents={
            "robots": robots,
            "groups": [(name, [_row(row) for row in findings if row["group"] == name]) for name in groups],
        },
    )


def used(row: FindingRow) -> float | None:
    """Returns which share of its budget a figure uses, more than 1 where it is broken; None beyond all bounds."""
    value, budget = row["value"], row["budget"]
    if value is None:
        return None
    part, whole = (value, budget) if row["sense"] == "at most" else (budget, value)
    if whole:
        return float(part / whole)
    return 0.0 if part <= 0 else None


# In words -------------------------------------------------------------------------------------------------------------


def fidelity_verdicts(findings: Sequence[FindingRow]) -> list[str]:
    """Returns sentences on how many budgets are kept, which are not, and which is nearest to being broken."""
    return [*_kept(findings), *(_broken(row) for row in findings if not row["ok"]), *_nearest(findings)]


def _kept(findings: Sequence[FindingRow]) -> Iterator[str]:
    robots = list(dict.fromkeys(row["robot"] for row in findings))
    kept = sum(row["ok"] for row in findings)
    who = f"robot {robots[0]}" if len(robots) == 1 else f"{len(robots)} robots, {listed(robots, most=len(robots))}"
    if kept == len(findings):
        yield f"All {kept} budgets are kept by {who}." if kept > 1 else f"The one budget is kept by {who}."
        return
    explained = sum(row["explained"] for row in findings if not row["ok"])
    yield f"{kept} of {len(findings)} budgets are kept by {who}."
    if explained:
        yield f"{_budgets(explained)} broken for a reason that docs/fidelity.md gives."


def _budgets(count: int) -> str:
    return "One budget is" if count == 1 else f"{count} budgets are"


def _broken(row: FindingRow) -> str:
    value = "no finite number" if row["value"] is None else _figure(row["value"], row)
    least = f"{row['sense']} {_figure(row['budget'], row)}"
    return f"{row['robot']}, {row['check']}: {value} where the budget is {least}; {row['cause']}."


def _nearest(findings: Sequence[FindingRow]) -> Iterator[str]:
    kept = [(share_used, row) for row in findings if row["ok"] and (share_used := used(row)) is not None]
    if kept:
        most, row = max(kept, key=lambda item: item[0])
        yield f"Of those kept, {row['check']} of {row['robot']} is nearest to its budget and uses {share(most)} of it."


# Figures --------------------------------------------------------------------------------------------------------------


def _tiles(findings: Sequence[FindingRow], robots: Sequence[str]) -> list[tuple[str, str]]:
    kept = sum(row["ok"] for row in findings)
    return [("budgets kept", f"{kept} of {len(findings)}"), ("robots measured", str(len(robots)))]


def _figure(value: float, row: FindingRow) -> str:
    return f"{value:.2g}" + (f" {row['unit']}" if row["unit"] != "1" else "")


def _row(row: FindingRow) -> dict[str, Any]:
    part = used(row)
    verdict = "kept" if row["ok"] else "explained" if row["explained"] else "broken"
    return {
        "robot": row["robot"],
        "check": row["check"],
        "measured": "-" if row["value"] is None else _figure(row["value"], row),
        "budget": f"{'≤' if row['sense'] == 'at most' else '≥'} {_figure(row['budget'], row)}",
        "used": _share(part),
        "bar": 1.0 if part is None else min(max(part, 0.0), 1.0),
        "verdict": verdict,
        "cause": row["cause"],
    }


def _share(part: float | None) -> str:
    if part is None:
        return "beyond"
    return share(part) if part < 10 else f"{part:.3g} times"
