"""What a notebook shows of a campaign."""

from __future__ import annotations

from typing import Any

import pandas as pd

from nhtrack.presentation.notebook import NotebookView, drawing, html_of
from nhtrack.presentation.numbers import cell, counted, grouped, percent
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.studies.campaign.grids import by_reference
from nhtrack.studies.campaign.plots import share_map
from nhtrack.studies.campaign.result import CampaignResults
from nhtrack.studies.campaign.screen import settled_in


def campaign_html(results: CampaignResults) -> str:
    """Returns what a notebook shows of a campaign: shares with intervals for each law and reference, and their map."""
    campaign, (runs, cells) = results.campaign, by_reference(results.runs, results.cells)
    shares = runs.groupby("law", sort=False)["converged"].agg(["sum", "count"])
    laws, families = counted(len(campaign.laws), "law"), counted(len(campaign.family_names), "reference")
    lead = f"{laws} against {families}, {counted(campaign.starts.count, 'random start')} each"
    view = NotebookView(
        f"{campaign.name}: {grouped(len(runs))} runs",
        lead=f"{lead}, {campaign.backend} backend; {results.folder}",
        tiles=[(f"of starts, {law}", f"{percent(row['sum'] / row['count'])} %") for law, row in shares.iterrows()],
        figures=[drawing(share_map(cells), f"{campaign.name}: shares of starts that arrive", scale=1.0)],
        tables=[_table(cells, settled_in(campaign))],
        folded=[("The worst run of each law again", [f"nhtrack run {path}" for path in results.worst.values()])],
    )
    return html_of(view)


def _table(cells: pd.DataFrame, settled: str) -> ResultTable:
    """Returns the shares that arrive, with their Wilson intervals at 95 %, by law and reference."""
    rows, law = list[TableRow](), ""
    records: list[dict[str, Any]] = cells.to_dict("records")
    for row in records:
        shown = (
            "" if row["law"] == law else row["law"],
            row["family"],
            f"{row['converged']} of {row['starts']}",
            f"{percent(row['share'])} %",
            f"{percent(row['share_low'])} to {percent(row['share_high'])} %",
            cell(row["settling_median"], "s"),
            cell(row["utilisation_max"], "%"),
        )
        rows.append(TableRow(shown, "" if row["share"] == 1 else "caution", begins=row["law"] != law))
        law = row["law"]
    headings = ("law", "reference", "arrived", "share", "interval (95 %)", "median settling", "friction")
    words, notes = frozenset({"law", "reference"}), (f"arrived, {settled}",)
    return ResultTable("Starts that arrive", headings, tuple(rows), words, notes=notes)
