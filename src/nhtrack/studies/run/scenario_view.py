"""What a notebook shows of a scenario, before it is run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from nhtrack.config.physics import Physics
from nhtrack.config.robots import Start
from nhtrack.config.scenario import Scenario
from nhtrack.plots.graph import parents_graph
from nhtrack.presentation.notebook import NotebookView, PageImage, drawing, html_of
from nhtrack.presentation.numbers import seconds
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.references import InputSection, SignalInput, SignalValue, TableInput

_ROBOTS = 12  # rows of a table
_GRAPH = (3, 40)  # from so many robots to so many, who tracks whom is drawn


def scenario_html(scenario: Scenario) -> str:
    """Returns what a notebook shows of a scenario: robots, law and gains, reference, duration, physics."""
    view = NotebookView(
        scenario.name,
        lead=scenario.description,
        figures=_drawings(scenario),
        tables=[_robots(scenario), _keys(scenario)],
    )
    return html_of(view)


def _drawings(scenario: Scenario) -> list[PageImage]:
    least, most = _GRAPH
    if not least <= len(scenario.parents) <= most:
        return []
    return [drawing(parents_graph(scenario.parents, "Who tracks whom"), f"{scenario.name}: who tracks whom", scale=0.9)]


def _robots(scenario: Scenario) -> ResultTable:
    """Returns who starts where and tracks whom."""
    leader, followers = scenario.leader, scenario.followers
    rows = [(leader.name, "virtual" if leader.virtual else "drives by its input", *_start(leader.start), "")]
    for each in followers:
        place = ", ".join(f"{value:g}" for value in each.offset) if any(each.offset) else ""
        rows.append((each.name, f"tracks {', '.join(each.parents)}", *_start(each.start), place))
    rest = (f"and {len(rows) - _ROBOTS} more",) if len(rows) > _ROBOTS else ()
    headings = ("robot", "", "starts at x, y, θ", "with v, ω", "its place")
    shown = tuple(TableRow(row) for row in rows[:_ROBOTS])
    return ResultTable("", headings, shown, frozenset(headings), notes=rest)


def _start(start: Start) -> tuple[str, str]:
    return tuple(", ".join(f"{value:g}" for value in values) for values in (start.pose, start.twist))  # type: ignore[return-value]


def _keys(scenario: Scenario) -> ResultTable:
    """Returns law and gains, reference, duration and physics, a row each."""
    auto = scenario.similarity.time == "auto"
    on_robot = "a time yet to be found" if auto else seconds(scenario.duration * scenario.similarity.time_scale)
    rows = [TableRow(("law", scenario.law.name, ""))]
    described = type(scenario.law).model_fields
    for key, value in scenario.law.model_dump(mode="json").items():
        if key != "name" and value is not None:
            rows.append(TableRow((f"  {key}", _value(value), described[key].description or "")))
    rows += [TableRow(("reference", *row)) for row in _reference(scenario.leader.input)]
    rows.append(TableRow(("duration", f"{scenario.duration:g}", f"{on_robot} on the robot's clock")))
    rate = f"{scenario.control_rate:g} control periods a second"
    rows.append(TableRow(("robot", scenario.robot, f"{scenario.backend} backend, {rate}")))
    rows += [TableRow(("physics", key, value)) for key, value in _physics(scenario.physics)]
    return ResultTable("", ("what", "value", "meaning"), tuple(rows), frozenset({"what", "value", "meaning"}))


def _reference(given: InputSection) -> list[tuple[str, str]]:
    if isinstance(given, SignalInput):
        return [(_signal(given.u_x), "u_x"), (_signal(given.u_theta), "u_theta")]
    if isinstance(given, TableInput):
        return [(f"a table of {len(given.table.t)} rows", f"until {given.table.t[-1]:g}, {given.interpolation}")]
    return [(_value(given.model_dump(mode="json")), given.words)]


def _signal(signal: SignalValue) -> str:
    if isinstance(signal, tuple):
        parts = [f"{each.value} until {each.until:g}" if each.until else f"{each.value}" for each in signal]
        return ", ".join(parts) if len(parts) <= 4 else f"{', '.join(parts[:3])}, ... ({len(parts)} pieces)"
    return f"{signal:g}" if isinstance(signal, float) else str(signal)


def _physics(physics: Physics) -> Iterator[tuple[str, str]]:
    """Yields friction, and whatever else is not as it is by default."""
    plain = Physics().model_dump(mode="json")
    for key, value in physics.model_dump(mode="json").items():
        if key == "friction" or value != plain[key]:
            yield key, _value(value)


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_value(each)}" for key, each in value.items() if each is not None)
    if isinstance(value, list):
        return "; ".join(_value(each) for each in value)
    return str(value)
