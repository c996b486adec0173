"""Writes the figures of a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from nhtrack.files.names import file_names
from nhtrack.plots.files import save_figure
from nhtrack.plots.style import styled
from nhtrack.studies.campaign.grids import by_reference, grid_maps
from nhtrack.studies.campaign.plots.distributions import late_errors, settling
from nhtrack.studies.campaign.plots.maps import grid_map
from nhtrack.studies.campaign.plots.pieces import names
from nhtrack.studies.campaign.plots.shares import share_map
from nhtrack.studies.campaign.plots.starts import start_map
from nhtrack.studies.campaign.tables import grid_of


@styled
def save_campaign_figures(
    starts: pd.DataFrame,
    cells: pd.DataFrame,
    folder: Path,
    *,
    labels: Mapping[str, Mapping[str, str]] | None = None,
    pdf: bool = False,
) -> list[Path]:
    """Writes every figure of a campaign; each file appears only once it is whole.

    The map of starts is one figure a law, `start_map_<label>`, the label in small letters and underscores; families
    over grids have none, but a map each, `grid_map_<family>_<label>`, and in other figures their points are one.

    Args:
        starts: a row a run.
        cells: a row for every law and family; its `worst_start` is ringed in the map of starts.
        folder: where to write.
        labels: what the axes of maps over grids say, see `nhtrack.studies.campaign.grids.grid_labels`.
        pdf: whether to write for print, see `nhtrack.plots.files.save_figure`.

    Returns:
        The files, PNG before PDF.
    """
    whole, summed = by_reference(starts, cells)
    figures = {"share_map": share_map(summed)}
    figures |= {"settling": settling(whole, summed), "late_errors": late_errors(whole, summed)}
    laws = file_names(names(starts, "law"))
    alone, single = starts[grid_of(starts) == ""], cells[grid_of(cells) == ""]
    for law in names(alone, "law"):
        own = single[single["law"] == law]
        worst = {str(family): int(start) for family, start in zip(own["family"], own["worst_start"], strict=True)}
        figures[f"start_map_{laws[law]}"] = start_map(alone, single, law, worst)
    for each in grid_maps(cells):
        name = "_".join(["grid_map", *file_names([each.name]).values(), *([laws[each.law]] if each.law else [])])
        figures[name] = grid_map(cells, each, (labels or {}).get(each.name))
    return [path for name, figure in figures.items() for path in save_figure(figure, folder / name, pdf=pdf)]
