"""What a campaign shows: a table for each law, and the command that repeats its worst run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.presentation.shown import within
from nhtrack.settling import SettlingLimits
from nhtrack.studies.campaign.grids import by_reference
from nhtrack.terminal.screen import rich_table

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console

    from nhtrack.config.campaign import Campaign
    from nhtrack.studies.campaign.result import CampaignResults


def print_results(results: CampaignResults, console: Console) -> None:
    """Prints a table for each law, and the command that repeats its worst run."""
    _, cells = by_reference(results.runs, results.cells)
    for label in results.campaign.laws:
        console.print(rich_table(law_table(results.campaign, cells, label)))
    console.print("The worst run of each law again:", highlight=False)
    for path in results.worst.values():
        console.print(f"  nhtrack run {path}", highlight=False, soft_wrap=True, markup=False)


def law_table(campaign: Campaign, cells: pd.DataFrame, label: str) -> ResultTable:
    """Returns how a law did against each reference; of errors, the last time of arrival and the like the largest."""
    rows: list[dict[str, Any]] = cells[cells["law"] == label].to_dict("records")
    return ResultTable(
        f"{label}: {campaign.starts.count} starts against each reference",
        ("reference", "converged", "late", "heading", "settled", "at last", "friction", "switches"),
        tuple(TableRow(_cells(row, campaign.starts.count), "" if row["share"] == 1 else "caution") for row in rows),
        frozenset({"reference"}),
        notes=(f"converged, {settled_in(campaign)}",),
    )


def settled_in(campaign: Campaign) -> str:
    """Returns what *settled* means in a campaign, for the note of a table."""
    arrival = campaign.arrival
    near = within(SettlingLimits(arrival.position, arrival.heading))
    return f"settled: {near} of its place until the end, at least over the last {arrival.last:g} s"


def _cells(row: dict[str, Any], starts: int) -> tuple[str, ...]:
    return (
        row["family"],
        f"{row['converged']}" + ("" if row["starts"] == starts else f"/{row['starts']}"),
        cell(row["late_position_max"], "m"),
        cell(row["late_heading_max"], "rad"),
        cell(row["settling_median"], "s"),
        cell(row["settling_max"], "s"),
        cell(row["utilisation_max"], "%"),
        f"{row['switches_max']:g}",
    )
