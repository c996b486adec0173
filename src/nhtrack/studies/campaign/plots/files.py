"""Writes the figures of a campaign."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from nhtrack.plots.files import save_figure
from nhtrack.plots.style import styled
from nhtrack.studies.campaign.plots.distributions import late_errors, settling
from nhtrack.studies.campaign.plots.pieces import names
from nhtrack.studies.campaign.plots.shares import share_map
from nhtrack.studies.campaign.plots.starts import start_map


@styled
def save_campaign_figures(
    starts: pd.DataFrame, cells: pd.DataFrame, folder: Path, *, pdf: bool = False
) -> list[Path]:
    """Writes every figure of a campaign; each file appears only once it is whole.

    The map of starts is one figure a law, `start_map_<label>`, the label in small letters and underscores.

    Args:
        starts: a row a run.
        cells: a row for every law and family; its `worst_start` is ringed in the map of starts.
        folder: where to write.
        pdf: whether to write for print, see `nhtrack.plots.files.save_figure`.

    Returns:
        The files, PNG before PDF.
    """
    figures = {"share_map": share_map(cells)}
    figures |= {"settling": settling(starts, cells), "late_errors": late_errors(starts, cells)}
    for law, name in file_names(names(starts, "law")).items():
        own = cells[cells["law"] == law]
        worst = {str(family): int(start) for family, start in zip(own["family"], own["worst_start"], strict=True)}
        figures[f"start_map_{name}"] = start_map(starts, cells, law, worst)
    return [path for name, figure in figures.items() for path in save_figure(figure, folder / name, pdf=pdf)]


def file_names(labels: Sequence[str]) -> dict[str, str]:
    """Returns a name for a file for every label; those that would be the same are numbered."""
    chosen: dict[str, str] = {}
    for label in labels:
        slug = name = re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_")
        number = 1
        while name in chosen.values():
            number += 1
            name = f"{slug}_{number}"
        chosen[label] = name
    return chosen
