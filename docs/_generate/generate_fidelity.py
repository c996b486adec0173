"""Writes the tables and figures of docs/fidelity.md anew, between their markers; takes a few minutes.

Run as `python docs/_generate/generate_fidelity.py`. The figures are those of `nhtrack fidelity`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pages import fill, table
from rich.progress import Progress, track

from nhtrack import assets
from nhtrack.colours import INK
from nhtrack.plots.style import panel_title, styled
from nhtrack.recording.versions import versions
from nhtrack.simulation.contact import FrictionRow
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.studies.fidelity import suite
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import drive_open_loop, open_loop_error, state_of, weave_within
from nhtrack.studies.fidelity.open_loop import SHARE, TIMESTEPS, path_length, step_errors

PAGE = Path(__file__).resolve().parents[1] / "fidelity.md"
FIGURES = PAGE.with_name("figures")
_INKS = ("#D55E00", "#CC79A7", "#0072B2", "#009E73", "#8A8A8A", "#E69F00")
COLOURS = dict(zip(assets.robots(), _INKS, strict=True))


def measured() -> list[Finding]:
    """Returns the findings of the whole suite."""
    with Progress() as bars:
        task = bars.add_task("fidelity suite", total=None)
        return suite.run_suite(suite.tasks(), lambda done, total: bars.update(task, completed=done, total=total))


def findings_table(findings: list[Finding], robots: tuple[str, ...]) -> str:
    """Returns figures and budgets, a row for each check; a broken budget is in bold, what is not asked a dash."""
    rows: list[list[str]] = []
    cause = ""
    for check in dict.fromkeys(finding.check for finding in findings):
        own = {finding.robot: finding for finding in findings if finding.check == check}
        first = next(iter(own.values()))
        unit = "" if first.unit == "1" else f" [{first.unit}]"
        others = "".join(f"; {name} {each.budget:.2g}" for name, each in own.items() if each.budget != first.budget)
        bound = f"{'≤' if first.sense == 'at most' else '≥'} {first.budget:.2g}{others}"
        rows.append([check + unit, bound, *(_figure(own.get(robot)) for robot in robots), _unless(cause, first.cause)])
        cause = first.cause
    return table(["check", "budget", *robots, "what the figure is made of"], rows)


def _figure(finding: Finding | None) -> str:
    if finding is None:
        return "-"
    shown = f"{finding.value:.1e}" if finding.sense == "at most" and finding.value else f"{finding.value:.2f}"
    return shown if finding.ok else f"**{shown}**"


def _unless(before: str, cause: str) -> str:
    """Returns a cause, or that it is the row's before."""
    return "same" if cause == before else cause


# -- what the open-loop error is made of ------------------------------------------------------------


def _no_half_steps(simulation: MujocoSimulation) -> None:
    """Every command takes effect at the step at which it is given, not half a step before."""
    simulation.wheels = simulation.wheels._replace(straddling=0.0)


def _no_creep(simulation: MujocoSimulation) -> None:
    simulation.wheels = simulation.wheels._replace(force_share=0.0)


LEFT_OUT: tuple[tuple[str, dict[str, Any], Callable[[MujocoSimulation], None] | None], ...] = (
    ("nothing", {}, None),
    ("stiff contacts and rate correction", {"contact": "default", "rate_correction": False}, None),
    ("rate correction", {"rate_correction": False}, None),
    ("half steps: the command acts at once", {}, _no_half_steps),
    ("anticipation of creep", {}, _no_creep),
)


def split_by_cause(robot: str) -> str:
    """Returns the error of the drive of a robot with one measure after another left out."""
    weave, rows = weave_within(Bench(robot).drive, SHARE), []
    for name, fields, tamper in track(LEFT_OUT, "causes"):
        bench = Bench(robot, tamper=tamper)
        found = [open_loop_error(bench.simulation(timestep=h, **fields), weave) for h in (0.002, 0.001)]
        order = np.log2(found[0].position / found[1].position)
        rows.append([name, f"{found[1].position:.1e} m", f"{found[1].heading:.1e} rad", f"{order:.1f}"])
    return table(["left out", "position after 10 s", "heading", "order in the step"], rows)


# -- figures ----------------------------------------------------------------------------------------


@styled
def convergence() -> Figure:
    """Returns the error after 10 s over the time step of robots without swivels, with and without rate correction."""
    figure = Figure(figsize=(7.6, 3.7))
    panels = figure.subplots(1, 2, sharex=True)
    h = 1e3 * np.array(TIMESTEPS)
    for robot in track(assets.robots(), "time steps"):
        bench = Bench(robot)
        if bench.swivels:
            continue
        weave = weave_within(bench.drive, SHARE)
        for corrected, style in ((True, "o-"), (False, "s--")):
            found = step_errors(bench, weave, corrected)
            position = [error.position / path_length(weave) for error in found]
            line = {"color": COLOURS[robot], "markersize": 4, "label": robot if corrected else None}
            panels[0].loglog(h, position, style, **line)
            panels[1].loglog(h, [error.heading for error in found], style, **line)
    for panel, budget, label in ((panels[0], 5e-6, "position error / path"), (panels[1], 2e-5, "heading error [rad]")):
        panel.set_xlabel("physics step [ms]")
        panel.set_ylabel(label)
        panel.set_xticks(h, [f"{value:g}" for value in h])
        panel.minorticks_off()
        panel.plot([1.0], [budget], "_", color=INK, markersize=16)
        panel.annotate("budget", (1.0, budget), xytext=(10, -3), textcoords="offset points", fontsize=8)
    panel_title(panels[0], "a", "solid: with rate correction")
    panel_title(panels[1], "b", "dashed: without")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(COLOURS))
    return figure


@styled
def slips() -> Figure:
    """Returns the turning slip over the contact's time constant, and a wheel's load while it slides."""
    figure = Figure(figsize=(7.6, 3.0))
    left, right = figure.subplots(1, 2)
    _draw_turning_slip(left)
    _draw_skid(right)
    return figure


def _draw_turning_slip(axes: Axes) -> None:
    bench, times = Bench("nh_mini"), np.array([0.002, 0.004, 0.006, 0.01, 0.014, 0.02])
    v, omega, found, law = 0.3, 2.0, [], []
    for timeconst in track(times, "turning slip"):
        scene = bench.scene(rate_correction=False)
        tyres = scene.addresses.tyres.ravel()
        scene.model.geom_solref[tyres] = timeconst, 1.0
        start = state_of(((0, 0, 0), (v, omega)))
        simulation = bench.simulation(dt=0.01, scene=scene)
        run = drive_open_loop(simulation, np.zeros((30, 1, 2)), start, ("lateral_slip",))
        rate = run.xi[-1, 0, 0] * run.xi[-1, 0, 2]
        found.append(-1e3 * run.telemetry["lateral_slip"][-1, 0])
        law.append(1e3 * rate * (1 / FrictionRow.of(scene.model, int(tyres[0])).damping - 0.0005))
    axes.plot(1e3 * times, law, color=INK, linewidth=0.9, label=r"$v\,\omega\,(1/b - h/2)$")
    axes.plot(1e3 * times, found, "o", color="#D55E00", markersize=5, label="measured")
    axes.set_xlabel("time constant of the contact [ms]")
    axes.set_ylabel("sideways slip [mm/s]")
    axes.legend(loc="upper left")
    panel_title(axes, "a", "a wheel that turns, no rate correction")


def _untold(simulation: MujocoSimulation) -> None:
    """Leaves every step to MuJoCo, whatever slides."""
    simulation.wheels = simulation.wheels._replace(told_of_slip=False)


def _draw_skid(axes: Axes) -> None:
    inputs = np.broadcast_to([2.5, 0.0], (400, 1, 2))
    looks = {"#BBBBBB": (0.6, "MuJoCo's steps", _untold), "#0072B2": (1.2, "told of the slip", None)}
    for colour, (width, label, tamper) in looks.items():
        simulation = Bench("nh_mini", tamper=tamper).simulation(friction=0.1)
        run = drive_open_loop(simulation, inputs, telemetry=("wheel_load",))
        load = run.telemetry["wheel_load"][:, 0, 0]
        axes.plot(1e3 * run.time[1:], load, color=colour, linewidth=width, label=label)
    drive, zero = simulation.drive, np.zeros(())
    a = float(np.diff(run.xi[[200, 400], 0, 0])[0] / 0.2)
    statics = float(drive.wheel_loads(zero, zero, np.array(a), zero)[0])
    axes.axhline(statics, color="#D55E00", linestyle=(0, (4, 3)), label="statics")
    axes.set_ylim(0, 30)
    axes.set_xlabel("time [ms]")
    axes.set_ylabel("load of a wheel in every step [N]")
    axes.legend(loc="upper right", fontsize=7.5)
    panel_title(axes, "b", "a wheel that spins, friction 0.1")


# -- the page ---------------------------------------------------------------------------------------


def main() -> None:
    """Writes the page and its figures."""
    findings, robots = measured(), assets.robots()
    made_with = f"\n\nMuJoCo {versions()['mujoco']}."
    closed = [finding for finding in findings if finding.check.startswith("paper/")]
    parts = {
        "suite": findings_table([finding for finding in findings if finding not in closed], robots),
        "closed loop": findings_table(closed, ("nh_mini",)),
        "causes": split_by_cause("nh_mini"),
    }
    fill(PAGE, {marker: content + made_with for marker, content in parts.items()})
    for name, draw in (("convergence", convergence), ("slips", slips)):
        draw().savefig(FIGURES / f"fidelity_{name}.png", dpi=130)


if __name__ == "__main__":
    main()
