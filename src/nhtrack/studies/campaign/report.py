"""The page of a campaign: from which share of starts each law arrives, where the others began, and how it went."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nhtrack.colours import robot_colour
from nhtrack.presentation.numbers import cell, counted, grouped, listed, percent, quantity, seconds
from nhtrack.presentation.shown import within
from nhtrack.presentation.thinned import even_rows
from nhtrack.report.downsample import numbers
from nhtrack.report.page import Page, write_page
from nhtrack.report.scenario_listing import meanings, yaml_text
from nhtrack.settling import SettlingLimits
from nhtrack.simulation.faults import LOST
from nhtrack.studies.campaign.grids import GridMap, by_reference, grid_labels, grid_maps, whole_percent

if TYPE_CHECKING:
    import pandas as pd

DRAWN_DIGITS = 5  # significant digits of what is drawn: a tenth of a pixel on a map
MOST_STARTS = 30_000  # of all maps together: two megabytes
LEAST_STARTS = 50  # of one map
CURVE_POINTS = 240  # of a distribution; more could not be seen
_SECTIONS = {"starts": "Starts", "distributions": "Distributions", "campaign": "Campaign"}
_LEAST = 1e-12  # errors below this are rounding, and are drawn at it


class Distribution(NamedTuple):
    """A figure of runs whose distribution is drawn."""

    column: str
    title: str
    unit: str
    logarithmic: bool = False


DISTRIBUTIONS = (
    Distribution("settling_time", "settling time", "s"),
    Distribution("peak_utilisation", "peak friction utilisation", "1"),
    Distribution("late_position", "largest late position error", "m", logarithmic=True),
    Distribution("late_heading", "largest late heading error", "rad", logarithmic=True),
    Distribution("effort_x", "RMS of the forward acceleration", "m/s²"),
    Distribution("effort_theta", "RMS of the turning acceleration", "rad/s²"),
)


@dataclass(frozen=True)
class Account:
    """What a campaign was, beside its tables.

    Attributes:
        tree: the campaign as its file has it, its time scale a number.
        versions: of what made the tables.
        worst: where the scenario of each law's worst run is, relative to the page, by the laws' labels.
        schema: JSON Schema of campaign files, which describes their keys.
        warnings: what was known to go wrong before it ran, in sentences.
    """

    tree: Mapping[str, Any]
    versions: Mapping[str, str]
    worst: Mapping[str, str]
    schema: Mapping[str, Any]
    warnings: Sequence[str] = ()


def write_campaign_page(runs: pd.DataFrame, cells: pd.DataFrame, account: Account, path: Path) -> Path:
    """Writes the page of a campaign; the file appears under its name only once it is whole.

    Args:
        runs: a row for every run.
        cells: a row for every law and reference.
        account: what else is known.
        path: file to write.
    """
    return write_page(campaign_page(runs, cells, account), path)


def campaign_page(runs: pd.DataFrame, cells: pd.DataFrame, account: Account) -> Page:
    """Returns what the page of a campaign shows. Arguments as `write_campaign_page`."""
    tree, maps = account.tree, list(_maps(cells, account.tree))
    runs, cells = by_reference(runs, cells)
    data = campaign_payload(runs, tree)
    shown = sum(len(each["start"]) for law in data["starts"] for each in law if each)
    again = [("The worst run of each law again:", "\n".join(f"nhtrack run {file}" for file in account.worst.values()))]
    return Page(
        "campaign.html.j2",
        tree["name"],
        {"shares": "Shares"} | ({"maps": "Maps"} if maps else {}) | _SECTIONS,
        campaign_verdicts(runs, cells, tree),
        [("With the same versions, the campaign above, saved as a file:", "nhtrack campaign campaign.yaml"), *again],
        account.versions,
        description=tree.get("description", ""),
        warnings=account.warnings,
        facts=_facts(tree),
        scripts=("campaign.js",),
        data=data,
        contents={
            "table": list(_table(cells, data)),
            "maps": maps,
            "scales": tree["similarity"],
            "thinning": {"runs": len(runs), "shown": shown, "points": CURVE_POINTS, "digits": DRAWN_DIGITS},
            "yaml": yaml_text(tree),
            "keys": meanings(tree, account.schema),
        },
    )


# Numbers --------------------------------------------------------------------------------------------------------------


def campaign_payload(runs: pd.DataFrame, tree: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what the page's scripts draw, ready for JSON; lengths and times in the campaign's own units.

    Families over grids have no starts: each is there once for every point.
    """
    laws, families = (list(dict.fromkeys(runs[column])) for column in ("law", "family"))
    parts = {key: part for key, part in runs.groupby(["law", "family"], sort=False)}
    most = max(LEAST_STARTS, MOST_STARTS // max(1, len(parts)))
    over_grids = {grid["name"] for grid in tree["families"] if "grid" in grid}
    return {
        "laws": [{"name": law, "colour": robot_colour(place)} for place, law in enumerate(laws, start=1)],
        "families": families,
        "radius": tree["starts"]["radius"],
        "lost": LOST,
        "figures": [figure._asdict() for figure in DISTRIBUTIONS],
        "curves": [[_curves(parts.get((law, family))) for family in families] for law in laws],
        "starts": [
            [None if family in over_grids else _starts(parts.get((law, family)), most) for family in families]
            for law in laws
        ],
    }


def _curves(part: pd.DataFrame | None) -> list[dict[str, Any]] | None:
    """Returns the distributions of a law against a reference: what share of its starts has at most a value."""
    if part is None:
        return None
    return [distribution(part[figure.column], figure.logarithmic) for figure in DISTRIBUTIONS]


def distribution(values: pd.Series, logarithmic: bool) -> dict[str, Any]:
    """Returns points of an empirical distribution: values in order, and the share of runs [%] that have at most them.

    A run whose value is not known or not finite is counted among those that have more than any.
    """
    every = values.to_numpy(dtype=float)
    known = np.sort(every[np.isfinite(every)])
    if logarithmic:
        known = np.maximum(known, _LEAST)
    kept = even_rows(len(known), CURVE_POINTS)
    return {"x": numbers(known[kept], DRAWN_DIGITS), "y": numbers(100 * (kept + 1) / max(len(every), 1), DRAWN_DIGITS)}


def _starts(part: pd.DataFrame | None, most: int) -> dict[str, Any] | None:
    """Returns where the starts of a law against a reference are, and what became of them."""
    if part is None:
        return None
    rows = kept_rows(part["converged"].to_numpy(dtype=bool), most)
    chosen = part.iloc[rows]
    names = ("x", "y", "theta", "settling_time", "late_position", "late_heading")
    columns = {name: numbers(chosen[name].to_numpy(dtype=float), DRAWN_DIGITS) for name in names}
    fate = np.where(chosen["lost"], "lost", np.where(chosen["converged"], "arrived", "astray"))
    return {"start": chosen["start"].tolist(), "fate": fate.tolist(), "of": len(part)} | columns


def kept_rows(converged: np.ndarray, most: int) -> np.ndarray:
    """Returns at most so many rows in order: those that did not converge first, up to half where others need room."""
    astray, arrived = np.flatnonzero(~converged), np.flatnonzero(converged)
    room = max(most // 2, most - len(arrived))
    failed = astray[even_rows(len(astray), room)]
    return np.sort(np.concatenate([failed, arrived[even_rows(len(arrived), most - len(failed))]]))


# In words -------------------------------------------------------------------------------------------------------------


def campaign_verdicts(runs: pd.DataFrame, cells: pd.DataFrame, tree: Mapping[str, Any]) -> list[str]:
    """Returns sentences on what was run, and from which share of starts each law arrives."""
    laws = dict.fromkeys(cells["law"])
    return [_whole(runs, cells, tree), *(told for law in laws for told in _law(law, runs, cells))]


def _whole(runs: pd.DataFrame, cells: pd.DataFrame, tree: Mapping[str, Any]) -> str:
    laws, families = cells["law"].nunique(), cells["family"].nunique()
    arrival = tree["arrival"]
    near = within(SettlingLimits(arrival["position"], arrival["heading"]))
    where = "on wheels in MuJoCo" if tree["backend"] == "mujoco" else "on the ideal integrator"
    return (
        f"{counted(laws, 'law')} against {counted(families, 'reference')}, {grouped(len(runs))} runs {where}. A run "
        f"arrives if its follower settles: it stays {near} of its place until the end, at least over the last "
        f"{arrival['last']:g} s of {tree['duration']:g} s."
    )


def _law(law: str, runs: pd.DataFrame, cells: pd.DataFrame) -> Iterator[str]:
    """Yields what became of a law's runs: sentences on where it arrives, whom it lost, what it asked of the floor."""
    own, rows = runs[runs["law"] == law], cells[cells["law"] == law]
    arrived, count = int(own["converged"].sum()), len(own)
    if arrived == count:
        yield f"{law} arrives from every start, against every reference: {grouped(count)} of {grouped(count)}."
    else:
        yield f"{law} arrives from {grouped(arrived)} of {grouped(count)} starts: {_where(rows)}."
    lost = int(own["lost"].sum())
    if lost:
        yield f"{law} lost {counted(lost, 'follower')}: each {LOST}."
    over = int((own["peak_utilisation"] >= 1).sum())
    if over:
        yield f"{law} asked for more friction than the floor has in {grouped(over)} of {grouped(count)} runs."


def _where(rows: pd.DataFrame) -> str:
    """Returns the references against which every start, none and some arrive."""
    every = list(rows.loc[rows["converged"] == rows["starts"], "family"])
    none = list(rows.loc[rows["converged"] == 0, "family"])
    parts = [f"all of those against {listed(every)}"] if every else []
    for row in rows.to_dict("records"):
        if 0 < row["converged"] < row["starts"]:
            parts.append(f"{grouped(row['converged'])} of {grouped(row['starts'])} against {row['family']}")
    return "; ".join(parts + ([f"none against {listed(none)}"] if none else []))


def _facts(tree: Mapping[str, Any]) -> list[tuple[str, str]]:
    backend = "MuJoCo" if tree["backend"] == "mujoco" else "ideal integrator"
    seeds = [("seed of the starts", str(tree["starts"]["seed"]))]
    return [("backend", backend), ("robot", str(tree["robot"])), *seeds]


# The table ------------------------------------------------------------------------------------------------------------


def _table(cells: pd.DataFrame, data: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields the table of shares: of each law its cells, None where it was not run."""
    rows = {(row["law"], row["family"]): row for row in cells.to_dict("records")}
    for law in data["laws"]:
        found = [rows.get((law["name"], family)) for family in data["families"]]
        yield law | {"cells": [None if row is None else _cell(row) for row in found]}


def _maps(cells: pd.DataFrame, tree: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields grids with their maps, the highest row first; a cell is None where the law was not run."""
    labels = grid_labels(tree)
    for name, several in groupby(grid_maps(cells), key=attrgetter("name")):
        maps, own = list(several), labels.get(name, {})
        across, up, columns = maps[0].across, maps[0].up, maps[0].columns
        yield {
            "name": name,
            "axes": f"Across: {own.get(across, across)}." + (f" Up: {own.get(up, up)}." if up else ""),
            "columns": columns,
            "laws": [(each.law, list(_map_rows(each))) for each in maps],
        }


def _map_rows(grid: GridMap) -> Iterator[tuple[str, list[tuple[float, str] | None]]]:
    """Yields the name and the cells of each row of a map, from above."""
    for row in range(len(grid.rows))[:: -1 if grid.up else 1]:
        shares = map(float, grid.shares[row])
        yield grid.rows[row], [None if math.isnan(share) else (share, whole_percent(share)) for share in shares]


def _cell(row: Mapping[str, Any]) -> dict[str, Any]:
    interval = f"{percent(row['share_low'])} to {percent(row['share_high'])}"
    count = f"{grouped(row['converged'])} of {grouped(row['starts'])}"
    told = f"{row['law']} against {row['family']}: {count} starts arrive ({percent(row['share'])} %; 95 % interval "
    told += f"{interval} %)"
    told += f", {grouped(row['lost'])} lost" if row["lost"] else ""
    return {
        "share": float(row["share"]),
        "percent": percent(row["share"]),
        "interval": interval,
        "count": count,
        "told": f"{told}. {' '.join(_figures(row))}",
    }


def _figures(row: Mapping[str, Any]) -> Sequence[str]:
    """Returns sentences on settling, errors, friction and gains of a law against a reference."""
    told = []
    if row["converged"]:
        half, last = (seconds(row[f"settling_{figure}"]) for figure in ("median", "max"))
        told.append(f"Half of those settle within {half}, all within {last}.")
    if math.isfinite(row["late_position_max"]):
        errors = f"{quantity(row['late_position_max'], 'm')} and {quantity(row['late_heading_max'], 'rad')}"
        told.append(f"Largest late errors: {errors}.")
    used = row["utilisation_max"]
    most = cell(used, "%") if math.isfinite(used) else "infinity: a wheel bears no load"
    told.append(f"Friction utilisation up to {most}.")
    return [*told, f"Gains found: {row['gains']}."] if row["gains"] else told
