"""Draws how the storage function of `agile` runs on beside quick leaders, docs/figures/theory_storage.png.

Run as `python docs/_generate/generate_storage.py`; takes a minute.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from nhtrack.experiment.load import load_campaign
from nhtrack.laws import agile, law_named
from nhtrack.laws.evaluate import commands, first_memories
from nhtrack.laws.leader_motion import Seen, schedule
from nhtrack.plots.style import panel_title, styled
from nhtrack.simulation.ideal import propagate
from nhtrack.studies.campaign.cell import Cell

FIGURE = Path(__file__).resolve().parents[1] / "figures" / "theory_storage.png"
FAMILIES = {"reverse-1s": "#0072B2", "chirp": "#D55E00", "circle-4": "#009E73", "cusps-fast": "#CC79A7"}
STARTS, PERIODS, EVERY, SHOWN = 50, 4000, 5, 6  # of every family; control periods of 10 ms; the start of panel a
GAINS = agile.Gains()
MODE, SEEN = 0, 5  # places in the law's memory


class Account(NamedTuple):
    """What became of followers.

    Attributes:
        time: shape (t,) [s].
        storage: V, shape (t, b) [m^2].
        near: whether they were near, shape (t, b).
    """

    time: np.ndarray
    storage: np.ndarray
    near: np.ndarray


def storage_of(follower: np.ndarray, leader: np.ndarray, memory: np.ndarray) -> float:
    """Returns V = int_0^|r| s/q(s) ds + theta^2/(2 b) with the gains of the moment [m^2]."""
    seen = Seen(*memory[SEEN:])
    b = schedule(seen, GAINS.rate, GAINS.k_theta, GAINS.k_inner, GAINS.zeta, GAINS.least_speed).b
    pull = (b / GAINS.turn_rate) ** 2 * seen.speed_2
    square = float((follower[0] - leader[0]) ** 2 + (follower[1] - leader[1]) ** 2)
    theta = math.remainder(float(leader[2] - follower[2]), 2 * math.pi)
    return square / (1 + math.sqrt(1 + pull * square)) + theta**2 / (2 * b)


def follow(family: str) -> Account:
    """Returns what became of followers of a family of `campaign/fast_leaders`."""
    campaign = load_campaign("campaign/fast_leaders", ["similarity.length=1"])
    law, dt = law_named("agile")(), 0.01
    experiment = Cell(campaign, "agile", family).experiment(slice(0, STARTS))
    g_0, g = (experiment.start.g[:, i].copy() for i in range(2))
    xi_0, xi = (experiment.start.xi[:, i].copy() for i in range(2))
    memory, storage, near = None, [], []
    for k in range(PERIODS):
        u_0 = experiment.inputs[k]
        follower = np.concatenate([g, xi], axis=1)
        leader = np.concatenate([g_0, xi_0, np.insert(u_0, 1, 0.0, axis=1)], axis=1)
        if memory is None:
            memory = first_memories(law, follower, leader, dt)
        u, memory = commands(law, follower, leader, memory, dt)
        if k % EVERY == 0:
            storage.append([storage_of(*rows) for rows in zip(follower, leader, memory, strict=True)])
            near.append(memory[:, MODE] == agile.NEAR)
        g, xi = propagate(g, xi, u, dt)
        g_0, xi_0 = propagate(g_0, xi_0, u_0, dt)
    return Account(np.arange(len(storage)) * EVERY * dt, np.array(storage), np.array(near))


@styled
def draw() -> Figure:
    """Returns V of one start a leader over time, and the quarter to three quarters of all since they were near."""
    figure = Figure(figsize=(7.2, 3.0))
    left, right = figure.subplots(1, 2, sharey=True)
    for family, colour in FAMILIES.items():
        account = follow(family)
        values, near = account.storage[:, SHOWN], account.near[:, SHOWN]
        left.plot(account.time, values, color=colour, linewidth=0.7, alpha=0.6)
        left.plot(account.time, np.where(near, values, np.nan), color=colour, linewidth=1.6, label=family)
        begun = account.near.argmax(axis=0)
        length = len(account.time) - int(begun.max())
        since = np.stack([account.storage[first : first + length, i] for i, first in enumerate(begun)], axis=1)
        low, middle, high = np.quantile(since, [0.25, 0.5, 1.0], axis=1)
        right.plot(account.time[:length], middle, color=colour)
        right.fill_between(account.time[:length], low, high, color=colour, alpha=0.15, linewidth=0)
    for axes, letter, text, under in (
        (left, "a", "one start; bold while near", "time [s]"),
        (right, "b", f"{STARTS} starts: median, up to the worst", "time since near [s]"),
    ):
        panel_title(axes, letter, text)
        axes.set_xlabel(under)
        axes.set_yscale("log")
        axes.set_ylim(1e-14, 1e2)
        axes.set_xlim(0, 20)
    left.set_ylabel("V [m$^2$]")
    left.legend(loc="upper right")
    return figure


def main() -> None:
    """Draws the figure."""
    draw().savefig(FIGURE, dpi=150)


if __name__ == "__main__":
    main()
