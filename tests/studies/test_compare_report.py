"""The report of a comparison: the figures of its tables, all runs in one payload, sentences on who is best."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elements import Elements
from nhtrack.analysis.metrics import position_error
from nhtrack.colours import robot_colour
from nhtrack.presentation.numbers import cell
from nhtrack.presentation.shown import CROWD
from nhtrack.recording import Recording
from nhtrack.report.data import payload
from nhtrack.studies.compare.ranking import MEASURES
from nhtrack.studies.compare.report import compare_page, compare_verdicts, fitted, join_runs
from nhtrack.studies.compare.result import Comparison, room_of
from nhtrack.studies.run.report import Extras
from nhtrack.video.together import together
from reports import HOSTILE, small_comparison

pytestmark = pytest.mark.slow

# Eight significant digits: rounding moves a number by at most half a unit of the last one.
DIGITS = 5e-8


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """Three laws, the last of which is lost within a second."""
    return small_comparison(tmp_path_factory.mktemp("compare"), description=HOSTILE)


@pytest.fixture(scope="module")
def merged(found: Comparison) -> Recording:
    return together(found.recordings, room_of(list(found.recordings.values())))


def page_of(found: Comparison) -> str:
    return (found.folder / "report.html").read_text(encoding="utf-8")


def test_the_standings_are_those_of_the_tables(found: Comparison) -> None:
    table = Elements(page_of(found))
    rows = [texts for texts in table.rows if texts[0] in found.recordings and len(texts) == len(MEASURES) + 2]
    assert [row[0] for row in rows] == list(found.recordings)
    for row, law in zip(rows, found.standings, strict=True):
        expected = [cell(getattr(law, name), measure.unit) for name, measure in MEASURES.items()]
        assert row[1:-1] == expected
    assert rows[2][-1].startswith("diverged at 0.")


def test_all_runs_are_in_one_payload_in_the_colours_of_their_laws(found: Comparison, merged: Recording) -> None:
    data = json.loads(json.dumps(payload(join_runs(merged, found.recordings), ()), allow_nan=False))
    assert [robot["colour"] for robot in data["robots"]] == [robot_colour(place) for place in range(4)]
    panels = {panel["key"]: panel for panel in data["panels"]}
    for place, (label, run) in enumerate(found.recordings.items()):
        for key, values in (("position", position_error(run)), ("u_theta", run["input"].values[..., 1])):
            curves = {curve["name"]: curve for curve in panels[key]["curves"]}
            known = [value for value in curves[f"follower-{label}"]["y"] if value is not None]
            expected = values[np.isfinite(values[:, 1]), 1]
            assert len(known) == len(expected) > 3  # one is lost soon
            np.testing.assert_allclose(known, expected, rtol=DIGITS)
        assert panels["position"]["curves"][place]["colour"] == robot_colour(place + 1)
    assert {robot["dash"] for robot in data["robots"]} == {"solid"}


def test_a_colour_that_comes_again_has_a_broken_line(found: Comparison) -> None:
    runs = {f"law-{k}": next(iter(found.recordings.values())) for k in range(9)}
    merged = together(runs, room_of(list(runs.values())))
    robots = payload(join_runs(merged, runs), ())["robots"][1:]
    looks = {(robot["colour"], robot["dash"]) for robot in robots}
    assert len({colour for colour, _ in looks}) == 7 < len(looks) == 9


def test_a_law_gone_wild_does_not_flatten_the_others(found: Comparison, merged: Recording) -> None:
    whole = join_runs(merged, found.recordings)
    panel = next(panel for panel in payload(whole, ())["panels"] if panel["key"] == "u_x")
    kept = list(found.recordings)[:2]
    low, high = fitted(panel, kept, whole)["range"]
    inside = np.concatenate([found.recordings[label]["input"].values[:-1, 1, 0] for label in kept])
    wild = found.recordings["kanayama-2"]["input"].values[:, 1, 0]
    assert low < inside.min() < inside.max() < high
    assert high < 2 * inside.max()
    assert np.abs(wild[np.isfinite(wild)]).max() > 10 * high
    assert "range" not in fitted(panel, found.recordings, whole)


def test_crowds_of_several_laws_are_a_band_for_each(found: Comparison) -> None:
    rng = np.random.default_rng(1)
    names = {label: [f"f{k}-{label}" for k in range(CROWD)] for label in ("one", "two")}
    dataset = small_crowd(names, rng)
    panel = payload(dataset, ())["panels"][0]
    assert [curve["name"] for curve in panel["curves"]] == ["one", "two"]
    errors = position_error(dataset)
    for k, curve in enumerate(panel["curves"]):
        own = errors[:, 1 + k * CROWD : 1 + (k + 1) * CROWD]
        np.testing.assert_allclose(curve["y"], np.median(own, axis=1), rtol=DIGITS)
        np.testing.assert_allclose(curve["high"], own.max(axis=1), rtol=DIGITS)


def small_crowd(names: dict[str, list[str]], rng: np.random.Generator) -> Recording:
    from recordings import synthetic_recording

    robots = ("leader", *(name for group in names.values() for name in group))
    recording = synthetic_recording(len(robots) - 1, samples=51)
    recording["error"].values[:, 1:] *= rng.uniform(0.5, 2.0, len(robots) - 1)[:, None]
    dataset = recording.dataset.assign_coords(robot=np.array(robots, dtype=object))
    parents = {name: [] if name == "leader" else ["leader"] for name in robots}
    return Recording(dataset.assign_attrs(groups=json.dumps(names), parents=json.dumps(parents)))


def row(label: str, **figures: Any) -> dict[str, Any]:
    plain = dict.fromkeys(MEASURES, 1.0)
    return {"label": label, "outcome": "completed", "end": 20.0} | plain | figures


def test_who_is_best_is_told_with_by_how_much() -> None:
    laws = [row("a", settling_time=4.0), row("b", settling_time=9.0), row("c", outcome="diverged: ran away", end=1.5)]
    told = compare_verdicts({"laws": laws, "best": {"settling_time": "a"}})
    assert told[0] == "2 of 3 laws completed their runs of 20 s: a and b."
    assert "c did not: it diverged, ran away, and what it recorded ends at 1.5 s." in told
    assert told[-1] == "a settles first: 4 s, where the next, b, has 9 s."


def test_who_does_not_settle_is_told() -> None:
    laws = [row("a"), row("b", settling_time=None, late_position_error=0.5)]
    told = compare_verdicts({"laws": laws, "best": {}})
    assert told == [
        "All 2 laws completed their runs of 20 s.",
        "b did not settle: its worst follower was off by up to 500 mm and 1 rad late in the run.",
    ]


@pytest.mark.parametrize(
    ("outcomes", "alarm"),
    [(("completed", "diverged: ran away"), ""), (("diverged: ran away",), "No law completed its run.")],
)
def test_what_went_wrong_stands_first(
    found: Comparison, merged: Recording, outcomes: tuple[str, ...], alarm: str
) -> None:
    labels = list(found.recordings)
    laws = [row | {"outcome": outcome} for row, outcome in zip(found.tree["laws"], outcomes, strict=False)]
    tree = found.tree | {"laws": laws, "warnings": [], "best": {}}
    shown = compare_page(tree, {label: found.recordings[label] for label in labels}, merged, (), Extras())
    assert shown.alarm == alarm


def test_an_ideal_comparison_shows_no_slip(found: Comparison) -> None:
    keys = {panel["key"] for panel in json.loads(Elements(page_of(found)).texts["script"][0])["panels"]}
    assert {"position", "heading", "u_x", "torque_left", "utilisation"} <= keys
    assert not {"sideways", "rolling", "gap"} & keys


def test_the_command_on_the_page_names_recordings_that_are_there(found: Comparison) -> None:
    (command,) = [text for text in Elements(page_of(found)).texts["pre"] if text.startswith("nhtrack compare ")]
    files = command.removeprefix("nhtrack compare ").split()
    assert [Path(file).parent.name for file in files] == list(found.recordings)
    assert all((found.folder / file).is_file() for file in files)


def test_no_text_of_a_scenario_is_markup(found: Comparison) -> None:
    page = Elements(page_of(found))
    assert [tag for tag, _ in page.found].count("script") == 3
    assert HOSTILE in page.texts["p"]
