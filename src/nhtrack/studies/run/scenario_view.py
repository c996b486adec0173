"""What a notebook shows of a scenario, before it is run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import isfinite
from typing import Any

from nhtrack.config.link import Noise
from nhtrack.config.physics import Physics
from nhtrack.config.robots import Start
from nhtrack.config.scenario import Scenario
from nhtrack.plots.graph import draw_graph
from nhtrack.plots.style import column_styled
from nhtrack.presentation.notebook import NotebookView, PageImage, drawing, html_of
from nhtrack.presentation.numbers import seconds
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.references import InputSection, MotionInput, SignalInput, SignalValue, TableInput
from nhtrack.section import Section

_AT_ONCE = ("delay_periods", 0)  # of every law where commands are not late
_LINK = {"delay": 0, "noise": Noise().model_dump(mode="json")}
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
    return [drawing(column_styled(draw_graph)(scenario.parents), f"{scenario.name}: who tracks whom", scale=0.9)]


def _robots(scenario: Scenario) -> ResultTable:
    """Returns who starts where and tracks whom."""
    leader, followers = scenario.leader, scenario.followers
    rows = [(leader.name, "virtual" if leader.virtual else "drives by its input", *_start(leader.start), "")]
    for each in followers:
        place = ", ".join(f"{value:g}" for value in each.offset) if any(each.offset) else ""
        rows.append((each.name, f"tracks {', '.join(each.parents)}", *_start(each.start), place))
    rest = (f"and {len(rows) - _ROBOTS} more",) if len(rows) > _ROBOTS else ()
    placed = any(row[-1] for row in rows)
    headings = ("robot", "", "starts at x, y, θ", "with v, ω", *["its place"] * placed)
    shown = tuple(TableRow(row[: len(headings)]) for row in rows[:_ROBOTS])
    return ResultTable("", headings, shown, frozenset(headings), notes=rest)


def _start(start: Start) -> tuple[str, str]:
    return tuple(", ".join(f"{value:g}" for value in values) for values in (start.pose, start.twist))  # type: ignore[return-value]


def _keys(scenario: Scenario) -> ResultTable:
    """Returns law and gains, reference, duration and physics, a row each."""
    auto = scenario.similarity.time == "auto"
    on_robot = "a time yet to be found" if auto else seconds(scenario.duration * scenario.similarity.time_scale)
    rate = f"{scenario.control_rate:g} control periods a second"
    rows = [
        ("law", scenario.law.name, ""),
        *_section(scenario.law, lambda key, value: key != "name" and value is not None and (key, value) != _AT_ONCE),
        *_section(scenario, lambda key, value: key in _LINK and value != _LINK[key]),
        *_reference(scenario.leader.input),
        ("duration", f"{scenario.duration:g}", f"{on_robot} on the robot's clock"),
        ("robot", scenario.robot.file, f"{scenario.backend} backend, {rate}"),
        *_section(scenario.physics, _tells),
    ]
    headings = ("what", "value", "meaning")
    return ResultTable("", headings, tuple(TableRow(row) for row in rows), frozenset(headings))


def _section(section: Section, shown: Callable[[str, Any], bool]) -> Iterator[tuple[str, str, str]]:
    """Yields key, value and meaning of what is shown of a section."""
    described = type(section).model_fields
    for key, value in section.model_dump(mode="json").items():
        if shown(key, value):
            yield key, _value(value), described[key].description or ""


def _tells(key: str, value: Any) -> bool:
    """Returns whether a key of the physics is shown: friction, and whatever is not as it is by default."""
    return key == "friction" or value != Physics().model_dump(mode="json")[key]


def _reference(given: InputSection) -> list[tuple[str, str, str]]:
    if isinstance(given, SignalInput):
        signals = {"u_x": given.u_x, "u_theta": given.u_theta}
        return [(name, _signal(signal), "the leader's input") for name, signal in signals.items()]
    if isinstance(given, TableInput):
        until = f"the leader's input until {given.table.t[-1]:g}, {given.interpolation}"
        return [("input", f"a table of {len(given.table.t)} rows", until)]
    if isinstance(given, MotionInput):
        end = given.reference().end
        return [("input", given.words, "the leader's input" + (f" until {end:g}" if isfinite(end) else ""))]
    return [("input", _value(given.model_dump(mode="json")), f"the leader's input, {given.words}")]


def _signal(signal: SignalValue) -> str:
    if isinstance(signal, tuple):
        parts = [f"{each.value} until {each.until:g}" if each.until else f"{each.value}" for each in signal]
        return ", ".join(parts) if len(parts) <= 4 else f"{', '.join(parts[:3])}, ... ({len(parts)} pieces)"
    return f"{signal:g}" if isinstance(signal, float) else str(signal)


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_value(each)}" for key, each in value.items() if each is not None)
    if isinstance(value, list):
        return "; ".join(_value(each) for each in value)
    return str(value)
