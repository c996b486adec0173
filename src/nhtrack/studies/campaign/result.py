"""What a campaign leaves behind."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from nhtrack.config.campaign import Campaign
from nhtrack.config.documentation import json_schema
from nhtrack.views import drawn_by


@dataclass(frozen=True, repr=False)
class CampaignResults:
    """What a campaign left behind.

    Attributes:
        campaign: with its time scale as a number.
        runs: a row for every run, see `nhtrack.studies.campaign.tables.COLUMNS`.
        cells: a row for every law and family.
        worst: the scenario file of the worst run of each law, by label.
        folder: where all of it is.
        files: the files written.
        warnings: what was known to go wrong before it ran, in sentences.
    """

    campaign: Campaign
    runs: pd.DataFrame
    cells: pd.DataFrame
    worst: Mapping[str, Path]
    folder: Path
    files: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"CampaignResults({self.campaign.name!r}, {len(self.runs)} runs in {self.folder})"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the shares that arrive, with their intervals, and a drawing of them."""
        return drawn_by("nhtrack.studies.campaign.view.campaign_html", self)


def write_campaign_report(results: CampaignResults) -> Path:
    """Writes the report of a campaign into its folder."""
    from nhtrack.studies.campaign.report import Account, write_campaign_page

    folder = results.folder
    versions_then = json.loads((folder / "campaign.json").read_text())["versions"]
    worst = {label: path.relative_to(folder).as_posix() for label, path in results.worst.items()}
    tree = results.campaign.model_dump(mode="json")
    account = Account(tree, versions_then, worst, json_schema(Campaign), results.warnings)
    return write_campaign_page(results.runs, results.cells, account, folder / "report.html")
