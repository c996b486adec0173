"""Draws the share of starts that converge over control rate, delay and noise, and writes it into docs/convergence.md.

Run as `python docs/_generate/generate_curves.py`; two cores need some six minutes, and ten times as long with
`--starts 100`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from pages import fill, table
from rich.progress import track

from nhtrack.config.campaign import Campaign
from nhtrack.config.families import FAMILIES, RANDOM
from nhtrack.config.law_sections import LawSection
from nhtrack.config.link import Noise
from nhtrack.execution import Processes
from nhtrack.experiment.build import make_law
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.load import load_campaign
from nhtrack.plots.style import panel_title, styled
from nhtrack.studies.campaign.cell import Cell
from nhtrack.studies.campaign.outcomes import run_outcomes
from nhtrack.studies.campaign.plots.pieces import legend, line

DOCS = Path(__file__).resolve().parents[1]
PAGE = DOCS / "convergence.md"
FIGURE = DOCS / "figures" / "convergence_curves.png"
STARTS = 10  # of every law, reference and setting
AHEAD = ", asked ahead"  # what a law is called that predicts the delay
LEFT_OUT = (  # of the fast leaders: those that came to them after the curves were measured
    "reverse-20s", "circle-10", "circle-20", "bursts", "square", "eight", "decay-1s", "decay-10s", "decay-30s",
    "random-walk",
)  # fmt: skip
LAWS = ("agile", "universal", "samson", "jiang_nijmeijer")
RATES = (5, 10, 20, 50, 100, 200)  # [Hz]
DELAYS = (0, 1, 2, 5, 10)  # control periods at 100 Hz
NOISES = (0, 1, 2, 5, 10)  # [mm], and twice as many [mrad]

Keys = Mapping[str, Any]


class Panel(NamedTuple):
    """One of the curves: what is along it, the values, the keys of a campaign that each means, and the laws."""

    title: str
    label: str
    values: tuple[int, ...]
    keys: tuple[Keys, ...]
    laws: tuple[str, ...] = LAWS


PANELS = (
    Panel("control rate", "control rate [Hz]", RATES, tuple({"control_rate": float(rate)} for rate in RATES)),
    Panel(
        "delay", "delay [periods of 10 ms]", DELAYS, tuple({"delay": delay} for delay in DELAYS),
        ("agile", f"agile{AHEAD}", *LAWS[1:]),
    ),
    Panel(
        "noise", "noise [mm, 2 mrad]", NOISES,
        tuple({"noise": Noise(position=1e-3 * size, heading=2e-3 * size)} for size in NOISES),
    ),
)  # fmt: skip


def base(starts: int) -> Campaign:
    """Returns a campaign of the ten families and of the fast leaders, at 100 Hz and with nothing amiss."""
    names = {law: {"name": law} for law in LAWS}
    changes = {"starts.count": starts, "physics.timestep": 0.001, "laws": names}
    fast = load_campaign("campaign/fast_leaders", [f"{key}={value}" for key, value in changes.items()])
    kept = (name for name in fast.family_names if name not in LEFT_OUT)
    return fast.model_copy(update={"families": (*FAMILIES, RANDOM, *kept)})


class Task(NamedTuple):
    """What one reference is like at one place along a curve: all laws drive from the same starts."""

    place: int
    campaign: Campaign
    family: str


def tasks(panel: Panel, campaign: Campaign) -> Iterator[Task]:
    """Yields every place along a curve with every reference."""
    for place, keys in enumerate(panel.keys):
        at = campaign.model_copy(update=dict(keys))
        laws = {law: _asked(law, at) for law in panel.laws}
        for family in campaign.family_names:
            yield Task(place, at.model_copy(update={"laws": laws}), family)


def _asked(law: str, campaign: Campaign) -> LawSection:
    """Returns the section of a law, which is asked as far ahead as its name says."""
    section: LawSection = campaign.laws[law.removesuffix(AHEAD)]
    return section.model_copy(update={"delay_periods": campaign.delay}) if law.endswith(AHEAD) else section


def shares(task: Task) -> dict[str, float]:
    """Returns the share of starts that converge, by the labels of the laws."""
    campaign, found = task.campaign, {}
    some = Cell(campaign, next(iter(campaign.laws)), task.family).experiment(slice(0, campaign.starts.count))
    for label, section in campaign.laws.items():
        experiment = replace(some, law=make_law(section, some.similarity))
        found[label] = float(run_outcomes(campaign, experiment)["converged"].mean())
    return found


def curves(panel: Panel, campaign: Campaign) -> dict[str, np.ndarray]:
    """Returns the mean over all references of the share that converges [%], along the curve of each law."""
    asked = list(tasks(panel, campaign))
    found = {law: np.zeros(len(panel.values)) for law in panel.laws}
    done = Processes()(asked, shares)
    for place, converged in track(done, panel.title, len(asked)):
        for law, each in converged.items():
            found[law][asked[place].place] += 100 * each / len(campaign.families)
    return found


@styled
def draw(found: Mapping[str, Mapping[str, np.ndarray]]) -> Figure:
    """Returns a panel for control rate, delay and noise, with a curve for each law."""
    figure = Figure(figsize=(7.2, 2.9))
    entries: dict[str, Any] = {}
    looks = {law: line(place) for place, law in enumerate((*LAWS, f"agile{AHEAD}"))}
    for axes, panel, letter in zip(figure.subplots(1, 3, sharey=True), PANELS, "abc", strict=True):
        panel_title(axes, letter, panel.title)
        for law, shares in found[panel.title].items():
            (entries[law],) = axes.plot(shares, label=law, marker="o", markersize=3, **looks[law])
        axes.set_xticks(range(len(panel.values)), [f"{value:g}" for value in panel.values])
        axes.set_xlabel(panel.label)
        axes.set_ylim(-3, 103)
    figure.axes[0].set_ylabel("converged [%]")
    legend(figure, [entries[law] for law in looks])
    return figure


def part(found: Mapping[str, Mapping[str, np.ndarray]], campaign: Campaign) -> str:
    """Returns what the page shows: the figure, how it was measured, and its numbers."""
    arrival, count = campaign.arrival, len(campaign.families)
    said = (
        f"Ideal model, {campaign.starts.count} starts from each of {count} references, the ten families and 22 of "
        f"`campaign/fast_leaders`; converged: within {1e3 * arrival.position:g} mm and {1e3 * arrival.heading:g} mrad, "
        "truly. All laws have their default gains; *asked ahead* is `delay_periods` as long as the delay."
    )
    shown = [
        table([panel.label, *map(str, panel.values)], [
            [f"`{law}`" if AHEAD not in law else f"`{law.removesuffix(AHEAD)}`{AHEAD}", *(f"{x:.0f} %" for x in shares)]
            for law, shares in found[panel.title].items()
        ])
        for panel in PANELS
    ]  # fmt: skip
    return "\n\n".join([said, f"![Share that converges over rate, delay and noise](figures/{FIGURE.name})", *shown])


def main() -> None:
    """Writes the figure, and its part of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--starts", type=int, default=STARTS)
    campaign = base(parser.parse_args().starts)
    compile_once(None)
    found = {panel.title: curves(panel, campaign) for panel in PANELS}
    draw(found).savefig(FIGURE, dpi=150)
    fill(PAGE, {"curves": part(found, campaign)})


if __name__ == "__main__":
    main()
