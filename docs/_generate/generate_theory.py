"""Writes the tables and the figures of docs/theory.md anew; takes a few minutes.

Run as `python docs/_generate/generate_theory.py`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from pages import fill
from rich.progress import track

from nhtrack import se2
from nhtrack.colours import INK
from nhtrack.config.law_sections import law_names, law_section
from nhtrack.experiment.build import make_law
from nhtrack.experiment.loop import run_loop
from nhtrack.experiment.recorder import Shape, Streaming
from nhtrack.experiment.rows import Rows, variables_of
from nhtrack.laws import Law, Leader, law_named
from nhtrack.laws.virtual_leader import fold
from nhtrack.network import Network
from nhtrack.plots.style import panel_title, styled
from nhtrack.similarity import Similarity
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.state import State

DOCS = Path(__file__).resolve().parents[1]
PAGE = DOCS / "theory.md"
FIGURES = DOCS / "figures"

RATE = 50.0  # [Hz]
DURATION = 80.0  # [s]
LATE = 0.2  # share of the time over which errors count
STARTS = 200  # of every family
POSITION, HEADING = 0.01, 0.01  # [m], [rad]: at most so much in the late part counts as converged
DEAD_ZONE = 1e-9
RIVAL_STARTS, RIVAL_LATE, RIVAL_HEADING = 300, 15 / 80, 0.02  # of every family; the last 15 s; [rad]

ABOVE = {"kp": 4.0, "kd": 6.0, "ke": 2.0, "k": 7.0}  # k_eff = 4.7
BELOW = {"kp": 4.0, "kd": 6.0, "ke": 2.0, "k": 2.25}  # k_eff = 1.5

BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#8A8A8A"


# -- reference families -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Family:
    """A leader's motion at the scale of 1 m/s.

    Attributes:
        name: what it is called.
        u_x: acceleration [m/s^2] of times [s].
        u_theta: acceleration [rad/s^2] of times.
        twist: speed [m/s] and turning rate [rad/s] to start with.
    """

    name: str
    u_x: Callable[[np.ndarray], np.ndarray]
    u_theta: Callable[[np.ndarray], np.ndarray]
    twist: tuple[float, float] = (0.0, 0.0)


def piece(value: float, begin: float, end: float) -> Callable[[np.ndarray], np.ndarray]:
    """Returns a signal that is `value` on [begin, end) and 0 elsewhere."""
    return lambda t: np.where((t >= begin) & (t < end), value, 0.0)


def nothing(t: np.ndarray) -> np.ndarray:
    """Returns zeros."""
    return np.zeros_like(t)


def decay(t: np.ndarray) -> np.ndarray:
    """Returns the derivative of 1/(1 + t)."""
    return -1.0 / (1.0 + t) ** 2


def pushes(value: float, begin: float, back: float, length: float) -> Callable[[np.ndarray], np.ndarray]:
    """Returns a push of a length [s] at `begin` and one against it at `back`."""
    return lambda t: piece(value, begin, begin + length)(t) - piece(value, back, back + length)(t)


FAMILIES = (
    Family("rest", nothing, nothing),
    Family("line", piece(0.5, 0, 2), nothing),
    Family("circle", piece(0.5, 0, 2), piece(0.5, 0, 1)),
    Family("sinus", piece(0.5, 0, 2), lambda t: 0.3 * np.cos(0.5 * t)),
    Family("stop-and-go", lambda t: 0.5 * np.sign(np.sin(2 * pi * t / 20)), lambda t: 0.2 * np.cos(0.4 * t)),
    Family("forward-reverse", lambda t: 0.5 * np.cos(2 * pi * t / 20), lambda t: 0.1 * np.cos(0.4 * t)),
    Family("park", pushes(0.5, 0, 20, 2), pushes(0.3, 0, 19, 1)),
    Family("spin", nothing, piece(0.5, 0, 1)),
    Family("slow decay", decay, decay, (1.0, 1.0)),
)


# -- closed loops -----------------------------------------------------------------------------------


class Motion(NamedTuple):
    """What pairs of leader and follower did.

    Attributes:
        error: follower seen from its leader, heading wrapped, shape (t, b, 3).
        lost: which followers ran away, shape (b,).
    """

    error: np.ndarray
    lost: np.ndarray


def starts(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns poses in a disc of 10 m, any heading, and twists |v| <= 1, |omega| <= 1, shapes (count, 3)."""
    rng = np.random.default_rng(seed)
    radius, bearing = 10 * np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-pi, pi, count)
    g = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), rng.uniform(-pi, pi, count)], axis=-1)
    return g, rng.uniform(-1, 1, (count, 3)) * [1, 0, 1]


def chase(
    law: Law, families: tuple[Family, ...], g: np.ndarray, xi: np.ndarray, kept: float = LATE, rate: float = RATE
) -> Motion:
    """Returns the motion of one pair a family, followers from `g` and `xi` (b, 3), over the last share of the time."""
    periods = round(DURATION * rate)
    t = (np.arange(periods) / rate)[:, None]
    distinct = {family.name: np.concatenate([family.u_x(t), family.u_theta(t)], axis=1) for family in families}
    inputs = np.stack([distinct[family.name] for family in families], axis=1)
    poses, twists = np.zeros((2, len(g), 2, 3))
    poses[:, 1], twists[:, 1] = g, xi
    twists[:, 0, 0], twists[:, 0, 2] = np.array([family.twist for family in families]).T
    network = Network.from_parents({"leader": (), "follower": ("leader",)})
    simulation = IdealSimulation(network.names, None, 1 / rate, keep_going=True)
    recorder = _Late(round((1 - kept) * periods))
    run_loop(simulation, law, network, inputs, State(0.0, poses, twists), recorder)
    return Motion(np.concatenate(recorder.errors)[:-1], simulation.lost)


class _Late(Streaming):
    """Keeps the errors of followers from some row on, shape (t, b, 3).

    Args:
        begin: the first row to keep.
    """

    def __init__(self, begin: int) -> None:
        self._begin = begin

    def begin(self, shape: Shape) -> None:
        """Begins with nothing."""
        super().begin(shape)
        self.errors: list[np.ndarray] = []

    def take(self, first: int, count: int, rows: Rows) -> None:
        """Keeps those of a block."""
        error = variables_of(rows.table[:, :count, 1].swapaxes(0, 1))["error"]
        self.errors.append(error[max(0, self._begin - first) :].copy())


def tracking_law(gains: dict[str, Any], variant: str, dead_zone: Any = DEAD_ZONE) -> Law:
    """Returns the law of Theorem 1; a gain may be an array, one value a pair."""
    kind = law_named("published")
    number = kind.described["variant"].choices.index(variant)
    return kind(**gains, variant=number, dead_zone_length=dead_zone, dead_zone_speed=dead_zone)


def worst(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Returns the largest position [m] and heading [rad] errors of each pair, shapes (b,)."""
    position = np.hypot(motion.error[..., 0], motion.error[..., 1]).max(axis=0)
    return np.where(motion.lost, np.inf, position), np.abs(motion.error[..., 2]).max(axis=0)


def median(values: np.ndarray, unit: float = 1.0) -> str:
    """Returns the median for a table, in words where it is nothing."""
    value = float(np.median(values)) / unit
    return "< 0.001" if value < 5e-4 else f"{value:.3f}" if value < 1 else f"{value:.1f}"


def convergence() -> str:
    """Returns the table of Theorem 1: shares that converge and what is left, per family, variant and side."""
    g, xi = (np.tile(array, (len(FAMILIES), 1)) for array in starts(STARTS, 2024))
    families = tuple(family for family in FAMILIES for _ in range(STARTS))
    cells: dict[str, list[str]] = {family.name: [] for family in FAMILIES}
    heads = []
    cases = [(v, side, gains) for v in ("published", "full") for side, gains in (("above", ABOVE), ("below", BELOW))]
    for variant, side, gains in track(cases, "table"):
        heads.append(f"{variant}, {side}")
        left = worst(chase(tracking_law(gains, variant), families, g, xi))
        add_column(cells, *left, HEADING)
    return families_table(heads, cells)


def rivals() -> str:
    """Returns the table of the rivals and `universal` at their default gains: shares that converge, what is left."""
    g, xi = (np.tile(array, (len(FAMILIES), 1)) for array in starts(RIVAL_STARTS, 2025))
    families = tuple(family for family in FAMILIES for _ in range(RIVAL_STARTS))
    cells: dict[str, list[str]] = {family.name: [] for family in FAMILIES}
    others = ("published", "stabiliser", "universal", "agile")  # not of the literature
    names = (*(name for name in law_names() if name not in others), "universal")
    for name in track(names, "rivals"):
        law = make_law(law_section(name)(name=name), Similarity())
        add_column(cells, *worst(chase(law, families, g, xi, RIVAL_LATE)), RIVAL_HEADING)
    return families_table([f"`{name}`" for name in names], cells)


def add_column(cells: dict[str, list[str]], position: np.ndarray, heading: np.ndarray, bound: float) -> None:
    """Adds to each family's cells which share converged, and the medians of what is left; equally many of each."""
    by_family = (each.reshape(len(cells), -1) for each in (position, heading))
    for own, r, a in zip(cells.values(), *by_family, strict=True):
        good = (r < POSITION) & (a < bound)
        own.append(f"{100 * good.mean():.3g} % ({median(r)} m, {median(a)} rad)")


def families_table(heads: list[str], cells: dict[str, list[str]]) -> str:
    """Returns a table of families and laws."""
    rows = [["reference", *heads], ["---"] * (1 + len(heads)), *([name, *values] for name, values in cells.items())]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def scaling() -> str:
    """Returns the table of the cycle behind a leader on a line, over kp and the leader's speed."""
    cases = [(4.0, 1.0), (16.0, 1.0), (64.0, 1.0), (4.0, 0.5)]
    g, xi = starts(30, 4)
    kp, speed = (np.repeat(column, len(g)) for column in zip(*cases, strict=True))
    law = tracking_law({"kp": kp, "kd": 3 * np.sqrt(kp), "ke": kp / 2, "k": 7.0}, "published")
    families = tuple(Family(f"{v}", nothing, nothing, (v, 0.0)) for v in speed)
    motion = chase(law, families, np.tile(g, (4, 1)), np.tile(xi, (4, 1)), rate=200.0)
    rows = [["kp [1/s^2]", "v_0 [m/s]", "position [m]", "heading [rad]", "position sqrt(kp)/v_0"], ["---"] * 5]
    for (gain, v), r, a in zip(cases, *(each.reshape(4, -1) for each in worst(motion)), strict=True):
        size = float(np.median(r))
        rows.append([f"{gain:g}", f"{v:g}", f"{size:.4f}", f"{np.median(a):.3f}", f"{size * gain**0.5 / v:.3f}"])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def damping() -> str:
    """Returns the table of a leader at rest about kd = 2 sqrt(kp), with and without dead zone."""
    g, _ = starts(100, 3)
    values, zones = (3.6, 3.8, 3.9, 4.0, 4.2), (0.0, 1e-9)
    kd, zone = (np.repeat(each.ravel(), len(g)) for each in np.meshgrid(values, zones))
    law = tracking_law({"kp": 4.0, "kd": kd, "ke": 0.0, "k": 3.0}, "published", zone)
    poses = np.tile(g, (10, 1))
    heading = worst(chase(law, (FAMILIES[0],) * len(kd), poses, np.zeros_like(poses), kept=0.25))[1]
    shares = 100 * np.mean(heading.reshape(2, 5, -1) < 0.5, axis=-1)
    rows = [["kd [1/s]", *(f"{value:g}" for value in values)], ["---"] * 6]
    rows += [[f"dead zone {z:g} m", *(f"{x:.3g} %" for x in row)] for z, row in zip(zones, shares, strict=True)]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


# -- figures ----------------------------------------------------------------------------------------


def arrow(x: float, y: float, theta: float, size: float, **style: Any) -> Polygon:
    """Returns a robot drawn as a triangle that points along its heading."""
    corners = np.array([[1.0, 0.0], [-0.6, 0.5], [-0.6, -0.5]]) * size
    return Polygon(se2.act(np.array([x, y, theta]), corners), **style)


@styled
def limit_cycle() -> Figure:
    """Returns the cycle that followers end on behind a leader on a line, seen from it, and their errors over time."""
    g, xi = starts(40, 5)
    line = FAMILIES[1]
    motion = chase(tracking_law(ABOVE, "published"), (line,) * len(g), g, xi, kept=1.0, rate=100.0)
    shown, last = 3, motion.error[-1000 :]
    figure = Figure(figsize=(7.2, 3.0))
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.0))
    for i, colour in zip(range(shown), (BLUE, ORANGE, GREEN), strict=True):
        left.plot(motion.error[..., i, 0], motion.error[..., i, 1], color=colour, linewidth=0.9)
        left.plot(*motion.error[0, i, :2], "o", color=colour, markersize=3.5)
    left.add_patch(arrow(0, 0, 0, 1.0, color=INK, zorder=4))
    left.set_aspect("equal", adjustable="datalim")
    i = 0
    middle.plot(last[:, i, 0], last[:, i, 1], color=BLUE, linewidth=0.9)
    for k in range(0, len(last), 1 + len(last) // 13):
        x, y, heading = last[k, i]
        middle.add_patch(arrow(x, y, heading, 0.012, color=ORANGE, zorder=3, linewidth=0))
    middle.plot(0, 0, "+", color=INK, markersize=9, markeredgewidth=1.5, zorder=4)
    middle.set_aspect("equal", adjustable="datalim")
    t = np.linspace(0, DURATION, len(motion.error))
    window = 50
    for values, colour, name in (
        (np.hypot(motion.error[..., 0], motion.error[..., 1]), BLUE, "position [m]"),
        (np.abs(motion.error[..., 2]), ORANGE, "heading [rad]"),
    ):
        peaks = values[: len(values) // window * window].reshape(-1, window, values.shape[1]).max(axis=1)
        times = t[: len(peaks) * window : window]
        right.fill_between(times, peaks.min(axis=1), peaks.max(axis=1), color=colour, alpha=0.2, linewidth=0)
        right.plot(times, np.median(peaks, axis=1), color=colour, label=name)
    right.set_yscale("log")
    right.set_xlim(0, DURATION)
    right.set_xlabel("time [s]")
    right.legend(loc="upper right")
    for axes, letter, text in (
        (left, "a", "three starts"), (middle, "b", "the cycle that is left"), (right, "c", "errors of 40 starts"),
    ):  # fmt: skip
        panel_title(axes, letter, text)
    for axes in (left, middle):
        axes.set_xlabel("ahead of the leader [m]")
        axes.set_ylabel("to its left [m]")
    return figure


@styled
def heading_bound() -> Figure:
    """Returns how many followers of a resting leader align over k_eff, and how far off the others stay."""
    values = np.concatenate([np.arange(1.0, 1.8, 0.2), np.arange(1.8, 2.4, 0.05), np.arange(2.4, 5.01, 0.2)])
    g, _ = starts(60, 9)
    k_eff, poses = np.repeat(values, len(g)), np.tile(g, (len(values), 1))
    gains = {"kp": 4.0, "kd": 4.0, "ke": 1.0, "k": k_eff * 5 / 4}
    # without dead zone: within one beta counts as 0, which turns followers home from either side of the bound
    law = tracking_law(gains, "published", dead_zone=0.0)
    left = worst(chase(law, (FAMILIES[0],) * len(poses), poses, np.zeros_like(poses), kept=0.02))
    position, heading = (each.reshape(len(values), -1) for each in left)
    shares = np.mean(heading < 0.5, axis=1)
    off, ends = (np.quantile(each, [0.1, 0.5, 0.9], axis=1).T for each in (heading, np.maximum(position, 1e-15)))
    figure = Figure(figsize=(7.2, 2.7))
    panels = figure.subplots(1, 3)
    for axes, letter, text in zip(
        panels, "abc",
        ("share within 0.5 rad", "heading left [rad]", "position left [m]"),
        strict=True,
    ):  # fmt: skip
        panel_title(axes, letter, text)
        axes.axvline(2.0, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)))
        axes.set_xlabel("$k_\\mathrm{eff} = k\\, k_p/(k_p + k_e)$")
        axes.set_xlim(values[0], values[-1])
    panels[0].plot(values, shares, "o-", color=BLUE, markersize=3)
    for axes, data in ((panels[1], off), (panels[2], ends)):
        axes.fill_between(values, data[:, 0], data[:, 2], color=BLUE, alpha=0.2, linewidth=0)
        axes.plot(values, data[:, 1], "o-", color=BLUE, markersize=3)
    below = values[values <= 2.0]
    panels[1].plot(below, below * pi / 2, color=ORANGE, linewidth=1.0, label="$k_\\mathrm{eff}\\, \\pi/2$")
    panels[1].legend(loc="upper right")
    panels[2].set_yscale("log")
    return figure


@styled
def printed_twist() -> Figure:
    """Returns the body velocity of a folded leader as printed and as it is, along lambda and over headings apart."""
    figure = Figure(figsize=(7.2, 2.8))
    left, right = figure.subplots(1, 2)
    shares = np.linspace(0, 1, 201)
    a = _parent(np.zeros(3), np.array([0.8, 0.0, -0.6]))
    b = _parent(np.array([0.3, 0.9, 2.6]), np.array([-0.2, 0.0, 0.7]))
    for exact, style in ((False, {"linestyle": (0, (4, 2))}), (True, {})):
        velocities = np.array([_folded_velocity(a, b, share, exact) for share in shares])
        for axis, colour, name in ((0, BLUE, "v_x"), (1, ORANGE, "v_y")):
            label = f"${name}$ {'true' if exact else 'as printed'}"
            left.plot(shares, velocities[:, axis], color=colour, label=label, **style)
    left.set_xlabel("$\\lambda$")
    left.set_ylabel("body velocity [m/s]")
    left.legend(ncols=1, loc="best")
    defects = unit_defects()
    apart = np.linspace(0, pi, 25)
    middles, quantiles = (apart[1:] + apart[:-1]) / 2, []
    for low, high in itertools.pairwise(apart):
        chosen = defects[1][(defects[0] >= low) & (defects[0] < high)]
        quantiles.append([*np.quantile(chosen, [0.5, 0.9]), chosen.max()])
    for column, colour, name in ((2, ORANGE, "worst of 400 000"), (1, GREEN, "nine in ten below"), (0, BLUE, "median")):
        right.plot(middles, np.array(quantiles)[:, column], color=colour, label=name)
    theta = np.linspace(1e-3, pi, 200)
    reach = (theta / 2) / np.sin(theta / 2)  # |q| of parents 1 m apart
    bound = (1 + reach / theta) * np.tan(theta / 4)
    right.plot(theta, bound, color=GREY, linestyle=(0, (4, 3)), label="bound of the closed form", zorder=1)
    right.set_xlabel("headings apart [rad]")
    right.set_ylabel("defect at $\\lambda = 1/2$ [m/s]")
    right.legend(loc="upper left")
    panel_title(left, "a", "one pair of parents")
    panel_title(right, "b", "pairs at most 1 m apart, $|v|, |\\omega| \\leq 1$")
    return figure


def _parent(g: np.ndarray, xi: np.ndarray) -> Leader:
    x, y, theta, v_x, v_y, omega = map(float, (*g, *xi))
    return Leader(x, y, theta, v_x, v_y, omega, 0.0, 0.0, 0.0)


def _folded_velocity(a: Leader, b: Leader, share: float, exact: bool) -> tuple[float, float]:
    """Returns the body velocity of the leader folded from two."""
    folded = fold(a, b, float(share), exact, 0.0, False)[0]
    return folded.v_x, folded.v_y


def unit_defects(count: int = 400_000) -> tuple[np.ndarray, np.ndarray]:
    """Returns headings apart [rad] and the size of true less printed velocity at lambda = 1/2 [m/s]."""
    rng = np.random.default_rng(7)
    radius, bearing, theta = np.sqrt(rng.uniform(0, 1, count)), *rng.uniform(-pi, pi, (2, count))
    g = np.stack([radius * np.cos(bearing), radius * np.sin(bearing), theta], axis=-1)
    xi = rng.uniform(-1, 1, (2, count, 3)) * [1, 0, 1]
    origin, gap = np.zeros(3), np.empty((count, 2))
    for k in range(count):
        a, b = _parent(origin, xi[0, k]), _parent(g[k], xi[1, k])
        gap[k] = np.subtract(_folded_velocity(a, b, 0.5, True), _folded_velocity(a, b, 0.5, False))
    return np.abs(theta), np.hypot(gap[:, 0], gap[:, 1])


# -- the page ---------------------------------------------------------------------------------------


def main() -> None:
    """Writes the page's tables and its figures."""
    FIGURES.mkdir(exist_ok=True)
    for draw in (limit_cycle, heading_bound, printed_twist):
        draw().savefig(FIGURES / f"theory_{draw.__name__}.png", dpi=150)
    fill(PAGE, {"theorem 1": convergence(), "scaling": scaling(), "damping": damping(), "rivals": rivals()})


if __name__ == "__main__":
    main()
