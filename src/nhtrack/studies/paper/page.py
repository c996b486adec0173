"""The page that holds the paper's examples on wheels against the ideal model, as Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

from nhtrack.analysis.metrics import follower_figures, robot_figures, smallest_separation
from nhtrack.config.robots import FollowerSection, LeaderSection, Start
from nhtrack.config.scenario import Scenario
from nhtrack.presentation.numbers import cell, quantity, row_of, seconds, share
from nhtrack.presentation.shown import within
from nhtrack.recording import Recording
from nhtrack.references import SignalInput
from nhtrack.settling import settling_limits
from nhtrack.studies.paper.result import ExampleRuns

START_HEADER = ("robot", "theta(0)", "x(0)", "y(0)", "omega(0)", "v_x(0)")
FOLLOWER_HEADER = (
    "follower", "model", "position at T", "heading at T", "late position", "late heading", "settled after",
)  # fmt: skip

_TITLE = """\
# The paper's examples on wheels

<!-- Written by `nhtrack paper`; do not edit. -->

This page is written by `nhtrack paper`: it runs the five examples of He and Geng, *Trajectory tracking control for
nonholonomic mobile robots under arbitrary reference input*, and draws every figure of the paper's simulations again.

Each example is run on the ideal integrator and in MuJoCo, on wheels that friction alone holds. Lengths and times are
the paper's unless a unit says *on the floor*: a scenario's similarity maps them to a robot of 0.1 m, and changes
neither the geometry nor the law. Pale broad lines are the ideal twin; thin lines on them are MuJoCo. Hollow robots mark
where each began.

The paper gives no gains. Those below were searched for on the ideal model (`nhtrack tune`). *Late* is the worst of the
last 15 % of a run; per cent are of the leader's path. A follower has *settled* once it stays {settled}
of its place, in the paper's units, until the end and at least over that part of the run. With a moving leader the
printed law ends on a limit cycle around it, on the ideal integrator as on wheels: late errors measure the law, the gap
to the twin measures the wheels.
"""


def page(done: Sequence[ExampleRuns], folder: str) -> str:
    """Returns the page.

    Args:
        done: examples with their runs.
        folder: where the figures are, relative to the page.
    """
    parts = [_TITLE.format(settled=within(settling_limits(1.0))), _overview(done)]
    parts += [_section(runs, folder) for runs in done]
    made = next(iter(done[0].shown.values())).versions
    parts.append(f"Made with nhtrack {made['nhtrack']} and MuJoCo {made['mujoco']}.\n")
    return "\n".join(parts)


def table(header: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> str:
    """Returns a Markdown table, the first columns of words to the left and the numbers to the right."""
    rule = ["---"] * words + ["---:"] * (len(header) - words)
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (header, rule, *rows))


def initial_conditions(scenario: Scenario) -> str:
    """Returns the table of a scenario's starts, with the paper's columns and in its order."""
    return table(START_HEADER, start_rows(scenario))


def start_rows(scenario: Scenario) -> list[list[str]]:
    """Returns the rows of that table."""
    robots: list[LeaderSection | FollowerSection] = [scenario.leader, *scenario.followers]
    return [[robot.name, *_start(robot.start)] for robot in robots]


def _start(start: Start) -> list[str]:
    (x, y, theta), (v, omega) = start.pose, start.twist
    return [angle(theta), *(f"{value:g}" for value in (x, y, omega, v))]


def angle(theta: float) -> str:
    """Returns an angle as a fraction of pi where it is a simple one, as a number otherwise."""
    share = Fraction(theta / math.pi).limit_denominator(12)
    if share == 0 or not math.isclose(theta, float(share) * math.pi, rel_tol=1e-12):
        return f"{theta:.6g}"
    top = {1: "pi", -1: "-pi"}.get(share.numerator, f"{share.numerator} pi")
    return top if share.denominator == 1 else f"{top}/{share.denominator}"


def _overview(done: Sequence[ExampleRuns]) -> str:
    """Returns the table of all examples: the worst follower's late errors, the worst robot's gap and utilisation."""
    rows = []
    for runs in done:
        for name, recording in runs.shown.items():
            late = [_late(run) for run in (runs.ideal[name], runs.wheels.get(name)) if run is not None]
            robots = robot_figures(recording).values() if runs.wheels else ()
            rows.append([
                f"[{name}](#example-{runs.example.number})",
                cell(farthest(recording), "m"),
                " / ".join(share(part) for part, _ in late),
                " / ".join(quantity(heading, "rad") for _, heading in late),
                cell(max((robot["gap_position_rms"] for robot in robots), default=None), "m"),
                cell(max((robot["peak_utilisation"] for robot in robots), default=None), "%"),
            ])  # fmt: skip
    header = ["scenario", "farthest start, on the floor", "late position, ideal / MuJoCo", "late heading"]
    return table([*header, "gap to the twin, RMS, on the floor", "peak friction utilisation"], rows)


def _section(runs: ExampleRuns, folder: str) -> str:
    """Returns what the page says of one example."""
    example = runs.example
    anchor = f'<a id="example-{example.number}"></a>'
    parts = [f"{anchor}\n\n## Example {example.number}: {example.title}\n", example.text + "\n"]
    scenarios = {name: recording.scenario for name, recording in runs.shown.items()}
    first = next(iter(scenarios.values()))
    parts.append("".join(f"- {line}\n" for line in settings(first)))
    for name, scenario in scenarios.items():
        heading = f"Initial conditions, `paper/{name}`:\n" if len(scenarios) > 1 else "Initial conditions:\n"
        parts += [heading, initial_conditions(scenario)]
    for figure in example.figures:
        parts.append(f"![{figure.caption}]({folder}/{figure.name}.png)\n\n*{figure.caption}*\n")
    parts += ["What each follower makes of what it tracks:\n", table(FOLLOWER_HEADER, follower_rows(runs), 2)]
    if runs.wheels:
        parts.append("How far wheels and ideal twin part, on the floor, and what the floor had to do:\n")
        parts.append(_robot_table(runs))
    touching = [name for name, scenario in scenarios.items() if scenario.physics.robot_contact]
    parts += [_closest(runs.wheels[name]) for name in touching if runs.wheels]
    return "\n".join(parts)


def settings(scenario: Scenario) -> list[str]:
    """Returns input, duration, gains and scales of a scenario, a line each."""
    law, scale = scenario.law, scenario.similarity
    gains = ", ".join(
        f"{name} = {getattr(law, name):g}" for name in ("kp", "kd", "ke", "k") if hasattr(law, name)
    )
    lines = [
        f"input of the leader: {_input(scenario)}; T = {scenario.duration:g} s",
        f"law: `{law.name}`, {gains}",
        f"similarity: 1 m becomes {1000 * scale.length:g} mm on the floor and 1 s becomes {scale.time_scale:g} s, "
        f"so that T is {scenario.duration * scale.time_scale:g} s there",
    ]
    edges = [f"{parent} -> {name}" for name, parents in scenario.parents.items() for parent in parents]
    if len(edges) > 1:
        lines.append(f"edges: {', '.join(edges)}; virtual leader `{scenario.virtual_leader}`")
    places = [f"{f.name} at ({f.offset[0]:g}, {f.offset[1]:g})" for f in scenario.followers if any(f.offset)]
    if places:
        lines.append(f"places: {', '.join(places)}, ahead and to the left; formation `{scenario.formation}`")
    return lines


def _input(scenario: Scenario) -> str:
    """Returns the leader's input in a line."""
    given = scenario.leader.input
    if not isinstance(given, SignalInput):
        return "a table"
    return ", ".join(
        f"{name} {_signal(value)}" for name, value in (("u_x0", given.u_x), ("u_theta0", given.u_theta))
    )


def _signal(value: Any) -> str:
    if isinstance(value, str):
        return f"= `{value}`"
    if not isinstance(value, tuple):
        return f"= {value:g}"
    if len(value) > 3:
        return f"piecewise constant, in {len(value)} pieces"
    pieces = (
        _signal(piece.value).removeprefix("= ") + (f" until {piece.until:g} s" if piece.until else "")
        for piece in value
    )
    return "= " + ", then ".join(pieces)


def follower_rows(runs: ExampleRuns) -> list[list[str]]:
    """Returns the errors at T and the late errors of every follower on both models, in scenario units."""
    rows = []
    for name, recording in runs.shown.items():
        models = {"ideal": runs.ideal[name]} | ({"MuJoCo": runs.wheels[name]} if runs.wheels else {})
        figures = {model: follower_figures(run) for model, run in models.items()}
        for follower in recording.followers:
            called = follower if len(runs.shown) == 1 else f"{follower}, `{name}`"
            for model, run in models.items():
                rows.append([called, model, *_error_cells(figures[model][follower], run)])
    return rows


def _error_cells(errors: Mapping[str, Any], recording: Recording) -> list[str]:
    """Returns position and heading error at T, then late, and when it settled."""
    path, cells = leader_path(recording), []
    for when in ("final", "late"):
        distance = errors[f"{when}_position_error"]
        cells.append(f"{quantity(distance / recording.length_scale, 'm')} ({share(distance / path)})")
        cells.append(quantity(errors[f"{when}_heading_error"], "rad"))
    settled = errors["settling_time"]
    return [*cells, "never" if settled is None else seconds(settled / recording.time_scale)]


_ON_WHEELS: Mapping[str, str] = {
    "path_length": "m",
    "gap_position_rms": "m",
    "gap_position_max": "m",
    "gap_heading_max": "rad",
    "peak_utilisation": "%",
    "torque_saturation_share": "%",
}  # figures of a robot and their units, as the columns of its table


def _robot_table(runs: ExampleRuns) -> str:
    """Returns the gaps to the ideal twin and the loads of every robot, on the floor."""
    rows = []
    for name, recording in runs.wheels.items():
        for robot, figures in robot_figures(recording).items():
            rows.append([
                robot if len(runs.wheels) == 1 else f"{robot}, `{name}`",
                *row_of(figures, _ON_WHEELS),
            ])  # fmt: skip
    header = ["robot", "path", "gap RMS", "gap max", "heading gap max"]
    return table([*header, "peak friction utilisation", "time at the torque limit"], rows)


def _closest(recording: Recording) -> str:
    """Returns how close robots came, in a sentence."""
    found = smallest_separation(recording)
    if found is None:
        return ""
    return (
        f"The closest two robots came: {cell(found.distance, 'm')} between {' and '.join(found.robots)}, "
        f"{seconds(found.time)} into the run on the floor.\n"
    )


def _late(recording: Recording) -> tuple[float, float]:
    """Returns the largest late errors of all followers: position as a share of the leader's path, heading [rad]."""
    followers = follower_figures(recording).values()
    position = max(follower["late_position_error"] for follower in followers)
    return position / leader_path(recording), max(follower["late_heading_error"] for follower in followers)


def leader_path(recording: Recording) -> float:
    """Returns the length of the leader's path [m]."""
    return float(robot_figures(recording)[recording.robots[0]]["path_length"])


def farthest(recording: Recording) -> float:
    """Returns how far from the leader the farthest follower starts [m]."""
    start = recording["pose"].values[0, :, :2]
    return float(max(math.hypot(*(place - start[0])) for place in start[1:]))
