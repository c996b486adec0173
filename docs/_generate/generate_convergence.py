"""Writes the tables of docs/convergence.md, and that of laws in README.md, from what campaigns left in docs/campaigns/.

Run as `python docs/_generate/generate_convergence.py`. A campaign's folder there holds its `cells.csv` and, in
`figures/`, those of its figures that the page shows; a folder that is not there leaves a line that says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pages import fill, table

from nhtrack.config.families import FAMILIES, QUICK, RANDOM, RANDOM_WALK, SETS
from nhtrack.presentation.numbers import percent

DOCS = Path(__file__).resolve().parents[1]
PAGE = DOCS / "convergence.md"
README = DOCS.parent / "README.md"
CAMPAIGNS = DOCS / "campaigns"

FOLDERS = ("ideal", "mujoco", "agile", "rivals_ideal", "rivals_mujoco")  # of docs/campaigns/, each between its markers
MAPS = "bandwidth"  # likewise, but shown by its maps alone
MAPS_IN_A_ROW = 2
FIGURES: Mapping[str, str] = {
    "share_map": "Share of starts that converge, for every law and reference",
    "settling": "Share of starts that have settled by a time",
    "late_errors": "Largest late errors, a panel for each law",
    "start_map_universal": "Where followers of `universal` start, and how long until they settle",
}
MANY_LAWS = 3  # so many are first compared, and their figures one by one are folded away
BACKENDS = {"ideal": "Ideal model", "mujoco": "Wheels in MuJoCo"}
LEADERS: Mapping[str, str] = {
    "rest": "stands",
    "line": "drives off along a line",
    "circle": "drives off on a circle",
    "sinus": "drives off and weaves",
    "stop-and-go": "stops every 20 s, weaving",
    "forward-reverse": "goes to and fro, weaving",
    "park": "drives an arc and parks",
    "spin": "turns on the spot",
    "slow-decay": "slows down as 1/(1 + t), in speed and turning rate",
    **{name: "goes to and fro, swaying" for name in QUICK if name.startswith("reverse-")},
    "chirp": "goes to and fro ever faster, up to 3.4 rad/s, swaying",
    "crossings": "goes to and fro, longer ahead than back",
    **{name: "goes to and fro while it turns" for name in QUICK if name.startswith("cusps-")},
    **{name: "on a circle, at once" for name in QUICK if name.startswith("circle-")},
    **{name: "turns on the spot, at once" for name in QUICK if name.startswith("spin-")},
    "bursts": "stands, and every 5 s is pushed for 0.2 s and braked",
    "wander": "drives and turns as sums of sines that never repeat",
    "square": "drives along a side of 2 m, stops, turns on the spot, goes on",
    "eight": "drives a lemniscate, x = 2 sin 0.3t, y = sin 0.6t",
    **{name: "slows down exponentially" for name in QUICK if name.startswith("decay-")},
    "ever-faster": "never stops speeding up, swaying",
    "tiny": "hardly moves",
    RANDOM: "random pieces, see below",
    RANDOM_WALK: "velocities walk at random, see below",
}


# -- numbers in words -------------------------------------------------------------------------------


def quantity(value: float, unit: str) -> str:
    """Returns a length or an angle with two digits and the prefix that suits it; `-` where it is not known."""
    if not np.isfinite(value):
        return "-"
    for factor, prefix in ((1.0, ""), (1e3, "m"), (1e6, "u"), (1e9, "n")):
        if factor * value >= 0.995:
            return f"{rounded(factor * value)} {prefix}{unit}"
    return f"< 1 n{unit}"


def seconds(value: float) -> str:
    """Returns a time in whole seconds, `-` where it is not known."""
    return f"{value:.0f} s" if np.isfinite(value) else "-"


def rounded(value: float) -> str:
    """Returns a number with two digits, or all of those before the point."""
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}"


def utilisation(value: float) -> str:
    """Returns a share of the friction limit in per cent; a wheel that bears nothing can use no friction at all."""
    return f"{100 * value:.0f} %" if np.isfinite(value) else "no load"


def grouped(number: float) -> str:
    """Returns a whole number with its thousands apart."""
    return f"{number:,.0f}".replace(",", " ") if number >= 10_000 else f"{number:.0f}"


# -- tables -----------------------------------------------------------------------------------------


def read_cells(path: Path) -> pd.DataFrame:
    """Returns the rows of a campaign's `cells.csv`, a row for every law and reference."""
    return pd.read_csv(path, dtype={"gains": str}).fillna({"gains": ""})


def families_table(names: Iterable[str]) -> str:
    """Returns what the leader does in bundled families."""
    rows = []
    for name in names:
        family = {**FAMILIES, **QUICK}.get(name, {})
        (v, omega), signals = family.get("twist", (0.0, 0.0)), (family.get(key, "") for key in ("u_x", "u_theta"))
        first = "those of the path" if "input" in family else f"{v:g}, {omega:g}"
        rows.append([name, LEADERS[name], *map(signal, signals), first])
    header = ["reference", "the leader", "u_x [m/s^2]", "u_theta [rad/s^2]", "v [m/s], omega [rad/s] at first"]
    return table(header, rows)


def signal(value: Any) -> str:
    """Returns a signal of a scenario in words."""
    if not isinstance(value, list):
        return f"{value:g}" if isinstance(value, (int, float)) else f"`{value}`" if value else ""
    return ", ".join(f"{piece['value']:g} until {piece['until']:g} s" for piece in value) + ", then 0"


def comparison(cells: pd.DataFrame, heading: str, show: Callable[[pd.Series], str]) -> str:
    """Returns one figure of every law, references down and laws across; `-` where it was not measured."""
    laws, families = cells["law"].unique(), cells["family"].unique()
    found = {(cell["law"], cell["family"]): show(cell) for _, cell in cells.iterrows()}
    rows = [[family, *(found.get((law, family), "-") for law in laws)] for family in families]
    return table([heading, *(f"`{law}`" for law in laws)], rows)


def share(cell: pd.Series) -> str:
    """Returns the share that converges with its interval, and how many were lost."""
    lost = f", {grouped(cell['lost'])} lost" if cell["lost"] else ""
    return f"{percent(cell['share'])} % {interval(cell)}{lost}"


def interval(cell: pd.Series) -> str:
    """Returns the interval of a share [%]."""
    return f"[{percent(cell['share_low'])}, {percent(cell['share_high'])}]"


def left(cell: pd.Series) -> str:
    """Returns the medians of the largest late errors."""
    return f"{quantity(cell['late_position_median'], 'm')}, {quantity(cell['late_heading_median'], 'rad')}"


def settled(cell: pd.Series) -> str:
    """Returns when the median of those that settle has, and when 99 % and the last of them."""
    if not np.isfinite(cell["settling_median"]):
        return "-"
    return f"{seconds(cell['settling_median'])} ({cell['settling_p99']:.0f}, {cell['settling_max']:.0f})"


COLUMNS: Mapping[str, Callable[[pd.Series], str]] = {
    "reference": lambda cell: cell["family"],
    "converged": lambda cell: f"{grouped(cell['converged'])} of {grouped(cell['starts'])}",
    "95 % interval [%]": interval,
    "lost": lambda cell: grouped(cell["lost"]),
    "late position": lambda cell: with_worst(cell, "late_position", lambda value: quantity(value, "m")),
    "late heading": lambda cell: with_worst(cell, "late_heading", lambda value: quantity(value, "rad")),
    "settled (99 %, last)": settled,
    "friction": lambda cell: with_worst(cell, "utilisation", utilisation),
    "motor at its limit": lambda cell: f"{percent(cell['saturated_share'])} %",
    "effort u_x, u_theta": lambda cell: f"{cell['effort_x_median']:.2f}, {cell['effort_theta_median']:.2f}",
    "switches": lambda cell: with_worst(cell, "switches", grouped),
    "worst start": lambda cell: f"{cell['worst_start']:.0f}",
}


def with_worst(cell: pd.Series, name: str, show: Callable[[float], str]) -> str:
    """Returns the median of a figure over the starts, and in brackets the largest."""
    return f"{show(cell[f'{name}_median'])} ({show(cell[f'{name}_max'])})"


def law_table(cells: pd.DataFrame) -> str:
    """Returns every figure of one law, a row for each reference."""
    return table(list(COLUMNS), [[show(cell) for show in COLUMNS.values()] for _, cell in cells.iterrows()])


def gains_table(cells: pd.DataFrame) -> str:
    """Returns the gains that tuning found, of the laws that were tuned."""
    tuned = cells[cells["gains"] != ""]
    rows = [[f"`{cell['law']}`", cell["family"], f"`{cell['gains']}`"] for _, cell in tuned.iterrows()]
    return table(["law", "reference", "gains"], rows)


# -- the page ---------------------------------------------------------------------------------------


def part(folder: Path) -> str:
    """Returns what the page says of a campaign: how it was measured, figures, and tables; or that it was not."""
    path = folder / "cells.csv"
    if not path.is_file():
        return f"*Not measured yet: `docs/campaigns/{folder.name}/cells.csv` is missing.*"
    cells = read_cells(path)
    laws = [cells[cells["law"] == law] for law in cells["law"].unique()]
    blocks = [conditions(cells), figures(folder)]
    if len(laws) >= MANY_LAWS:
        blocks += [
            comparison(cells, "converged", share),
            comparison(cells, "late position, heading", left),
            comparison(cells, "settled (99 %, last)", settled),
            *(folded(total(law), law_table(law)) for law in laws),
        ]
    else:
        blocks += [block for law in laws for block in (total(law), law_table(law))]
    if cells["gains"].any():
        blocks.append(folded("Gains found by tuning, scenario units", gains_table(cells)))
    return "\n\n".join(block for block in blocks if block)


def maps_part(folder: Path) -> str:
    """Returns what the page shows of a campaign over grids: how it was measured, maps, and the shares of laws."""
    path = folder / "cells.csv"
    if not path.is_file():
        return f"*Not measured yet: `docs/campaigns/{folder.name}/cells.csv` is missing.*"
    cells = read_cells(path)
    blocks = [f"{measured_on(cells)} of each point; converged: {limits(cells)}."]
    for name, own in cells.groupby("grid", sort=False):
        shown = [
            f"![Shares of `{law}` over the grid {name}](campaigns/{folder.name}/figures/grid_map_{name}_{law}.png)"
            for law in own["law"].unique()
        ]
        shown += ["-"] * (-len(shown) % MAPS_IN_A_ROW)
        rows = [shown[first : first + MAPS_IN_A_ROW] for first in range(0, len(shown), MAPS_IN_A_ROW)]
        blocks.append(table([str(name)] * MAPS_IN_A_ROW, rows))
    whole = cells.assign(family=cells["grid"]).groupby(["law", "family"], sort=False)[["converged", "starts"]].sum()
    shares = [[f"`{law}`", *(f"{percent(row.converged / row.starts)} %" for row in own.itertuples())]
              for law, own in whole.groupby("law", sort=False)]  # fmt: skip
    return "\n\n".join([*blocks, table(["of all starts", *map(str, cells["grid"].unique())], shares)])


def conditions(cells: pd.DataFrame) -> str:
    """Returns how the tables were measured, and how they read."""
    return (
        f"{measured_on(cells)} for every law and reference; converged: {limits(cells)}. Figures are medians "
        "over the starts, in brackets the largest; errors are of followers that were not lost, times of those that "
        "settled."
    )


def measured_on(cells: pd.DataFrame) -> str:
    """Returns on what, and from how many starts."""
    backends = " and ".join(BACKENDS[name] for name in cells["backend"].unique())
    counts = " to ".join(grouped(count) for count in sorted({cells["starts"].min(), cells["starts"].max()}))
    return f"{backends}, {counts} starts"


def limits(cells: pd.DataFrame) -> str:
    """Returns the criterion of arrival."""
    found = cells[["position_limit", "heading_limit"]].drop_duplicates().to_numpy()
    return "within " + " or ".join(f"{quantity(near, 'm')} and {quantity(turned, 'rad')}" for near, turned in found)


def figures(folder: Path) -> str:
    """Returns the campaign's figures as images, as far as there are any."""
    shown = [
        f"![{text}](campaigns/{folder.name}/figures/{name}.png)"
        for name, text in FIGURES.items()
        if (folder / "figures" / f"{name}.png").is_file()
    ]
    return "\n\n".join(shown)


def total(law: pd.DataFrame) -> str:
    """Returns how many runs of a law converge, over all references."""
    converged, starts = law["converged"].sum(), law["starts"].sum()
    return f"`{law['law'].iloc[0]}`: {grouped(converged)} of {grouped(starts)} runs converge."


def folded(summary: str, content: str) -> str:
    """Returns content that is folded away until its summary is clicked on."""
    heading = summary.replace("`", "")  # Markdown is not read in there
    return f"<details><summary>{heading}</summary>\n\n{content}\n\n</details>"


def overview() -> str:
    """Returns the table of the README: what share of all starts each law brings in, and to which references all."""
    ideal, wheels = measured(("ideal", "rivals_ideal")), measured(("mujoco", "rivals_mujoco"))
    if ideal.empty:
        return "*Not measured yet.*"
    rows = []
    for law in ideal["law"].unique():
        cells = ideal[ideal["law"] == law]
        all_of = cells[cells["converged"] == cells["starts"]]["family"]
        reached = "all" if len(all_of) == len(cells) else ", ".join(all_of) or "none"
        # On wheels `universal` keeps the limits of its robot and is called by its name alone.
        driven = wheels[wheels["law"] == law.removesuffix(" limited")] if law != "universal" else wheels[:0]
        rows.append([f"`{law}`", reached, overall(cells), overall(driven)])
    return table(["law", "every start arrives at", "of all starts, ideal", "on wheels"], rows)


def measured(names: Iterable[str]) -> pd.DataFrame:
    """Returns the rows of some campaigns, of those that there are."""
    found = [read_cells(path) for name in names if (path := CAMPAIGNS / name / "cells.csv").is_file()]
    return pd.concat(found) if found else pd.DataFrame(columns=["law"])


def overall(cells: pd.DataFrame) -> str:
    """Returns the share of all runs that converge, and their number; `-` where there are none."""
    if cells.empty:
        return "-"
    return f"{percent(cells['converged'].sum() / cells['starts'].sum())} % of {grouped(cells['starts'].sum())}"


def main() -> None:
    """Writes the tables of the page, and the one of the README."""
    families = {"families": families_table(SETS["slow"]), "quick_families": families_table(SETS["quick"])}
    fill(PAGE, families | {name: part(CAMPAIGNS / name) for name in FOLDERS} | {MAPS: maps_part(CAMPAIGNS / MAPS)})
    fill(README, {"laws": overview()})


if __name__ == "__main__":
    main()
