"""The report of a run: numbers of the recording, sentences of the summary, and no text of a user is markup."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elements import Elements
from nhtrack import assets
from nhtrack.analysis.metrics import heading_error, position_error, summary
from nhtrack.config.documentation import json_schema
from nhtrack.config.video import Video
from nhtrack.experiment.load import load
from nhtrack.presentation.numbers import cell, listed, quantity
from nhtrack.presentation.thinned import extreme_rows
from nhtrack.recording import Recording
from nhtrack.report.data import payload
from nhtrack.report.downsample import numbers
from nhtrack.report.film import duration_of, read_film
from nhtrack.report.graph import graph_svg
from nhtrack.report.scenario_listing import meanings, yaml_text
from nhtrack.report.summary_text import About, about, run_verdicts, tiles
from nhtrack.studies.run.report import Extras, render_run_page
from nhtrack.studies.run.run import run_scenario
from recordings import HALF_SEPARATION
from reports import scenario_tree, whole_recording, write_pictures

# Eight significant digits: rounding moves a number by at most half a unit of the last one.
DIGITS = 5e-8
MILLISECOND = 1e-3  # [s] an MP4 file's header counts milliseconds

HOSTILE = ("<script>alert(1)</script>", "<img src=x onerror=alert(1)>", '" onload="alert(1)', "</title>&amp;\u2028'")


def report(recording: Recording, **extras: Any) -> str:
    return render_run_page(recording, summary(recording) | {"warnings": []}, Extras(**extras))


def numbers_of(page_text: str) -> Any:
    return json.loads(Elements(page_text).texts["script"][0])


@pytest.fixture(scope="module")
def recording() -> Recording:
    return whole_recording(3, samples=201)


# Numbers --------------------------------------------------------------------------------------------------------------


def test_a_short_recording_is_shown_row_by_row(recording: Recording) -> None:
    shown = json.loads(json.dumps(payload(recording, ()), allow_nan=False))
    frames, pose, twin = shown["frames"], recording["pose"].values, recording["ideal_pose"].values
    np.testing.assert_allclose(frames["time"], recording.time, rtol=DIGITS)
    for place in range(4):
        for k, part in enumerate("xyh"):
            np.testing.assert_allclose(frames["pose"][part][place], pose[:, place, k], rtol=DIGITS)
            np.testing.assert_allclose(frames["twin"][part][place], twin[:, place, k], rtol=DIGITS)
    panels = {panel["key"]: panel for panel in shown["panels"]}
    for key, values in (("position", position_error(recording)), ("heading", np.abs(heading_error(recording)))):
        for place, curve in enumerate(panels[key]["curves"], start=1):  # the root has no error
            assert curve["name"] == recording.robots[place]
            np.testing.assert_allclose(curve["t"], recording.time, rtol=DIGITS)
            np.testing.assert_allclose(curve["y"], values[:, place], rtol=DIGITS)
    torque = 1e3 * recording["wheel_torque"].values[:, 0, 1]  # [mN m]
    np.testing.assert_allclose(panels["torque_right"]["curves"][0]["y"], torque, rtol=DIGITS)
    readouts = {each["name"]: each["values"] for each in frames["readouts"]}
    used = 100 * recording["friction_utilisation"].values.max(axis=-1)
    np.testing.assert_allclose(np.array(readouts["friction used"], float), used.T, rtol=1e-3)


def test_axes_are_labelled_in_the_unit_the_curves_are_in(recording: Recording) -> None:
    panels = {panel["key"]: panel for panel in payload(recording, ())["panels"]}
    largest = np.abs(recording["lateral_slip"].values).max()
    shown = max(abs(value) for curve in panels["sideways"]["curves"] for value in curve["y"])
    factor = {"m/s": 1.0, "mm/s": 1e3, "µm/s": 1e6, "nm/s": 1e9, "pm/s": 1e12}[panels["sideways"]["unit"]]
    assert shown == pytest.approx(factor * largest, rel=DIGITS)
    assert 1 <= shown < 1000


def test_thinning_keeps_extremes_ends_and_gaps() -> None:
    rng = np.random.default_rng(1)
    values = rng.standard_normal((50_001, 2))
    values[31_234, 0], values[777, 1] = 40.0, -60.0
    values[20_000:21_000, 1] = np.nan
    rows = extreme_rows(values, 400)
    assert len(rows) <= 404
    assert (np.diff(rows) > 0).all()
    assert {0, 50_000, 31_234, 777, 19_999, 20_000, 20_999, 21_000} <= set(rows.tolist())
    for column in values.T:
        for stretch in np.array_split(np.arange(len(values)), 99):
            inside = rows[(rows >= stretch[0]) & (rows <= stretch[-1])]
            part = column[stretch]
            if np.isfinite(part).all():
                assert {part.min(), part.max()} <= set(column[inside])


def test_numbers_that_json_does_not_know_are_none() -> None:
    values = np.array([[1.23456789123, np.nan], [np.inf, -0.0]])
    assert numbers(values, 8) == [[1.2345679, None], [None, 0.0]]


@pytest.mark.slow
def test_a_crowd_becomes_a_band_around_its_median() -> None:
    crowd = whole_recording(9, samples=4501)
    panel = payload(crowd, ())["panels"][0]
    (band,) = panel["curves"]
    errors = position_error(crowd)[:, 1:]
    assert len(band["t"]) < 4501
    rows = np.searchsorted(crowd.time, np.array(band["t"]) - 1e-4)
    np.testing.assert_allclose(band["low"], errors.min(axis=1)[rows], rtol=DIGITS)
    np.testing.assert_allclose(band["y"], np.median(errors, axis=1)[rows], rtol=DIGITS)
    assert max(band["high"]) == pytest.approx(errors.max(), rel=DIGITS)
    assert min(band["low"]) == pytest.approx(errors.min(), rel=DIGITS)


@pytest.mark.parametrize("stop", [0.0, 0.1])
def test_a_run_that_hardly_began_has_a_report(stop: float) -> None:
    text = report(whole_recording(1, stop=stop))
    assert "then the run was interrupted" in text
    assert len(numbers_of(text)["frames"]["time"]) == (1 if stop == 0.0 else 2)


@pytest.mark.parametrize("followers", [1, 9])
def test_a_run_gone_wild_has_a_report(followers: int) -> None:
    """Numbers too large to square, a twin that is lost, and not a word of warning from the libraries."""
    wild = whole_recording(followers, samples=101)
    wild["pose"].values[90:, 1, 0] = 1e200
    wild["error"].values[90:, 1, 0] = 1e200
    wild["ideal_pose"].values[50:] = np.nan
    with np.errstate(over="ignore", invalid="ignore"):  # as a run does while it makes its summary
        figures = summary(wild)
    text = render_run_page(wild, figures)
    frames = numbers_of(text)["frames"]
    assert frames["pose"]["x"][1][-1] == 1e200
    assert frames["twin"]["x"][1][49:51] == [pytest.approx(wild["ideal_pose"].values[49, 1, 0], rel=DIGITS), None]
    assert "is not known to the end" in text


@pytest.mark.slow
def test_an_ideal_run_has_no_wheels_and_no_twin(tmp_path: Path) -> None:
    outcome = run_scenario(
        load("tour/hello", ["backend=ideal", "duration=0.5"]), tmp_path / "run", figures=False, video=False
    )
    text = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "2 robots ran on the ideal integrator for 0.5\N{NO-BREAK SPACE}s" in text
    assert "twin" not in numbers_of(text)["frames"]
    assert not numbers_of(text)["twin"]
    assert outcome.files[-1].name == "report.html"


# Sentences ------------------------------------------------------------------------------------------------------------


@cache
def plain() -> dict[str, Any]:
    return summary(whole_recording(1))


def told(**changes: Any) -> str:
    return " ".join(run_verdicts(plain() | changes))


def follower(**changes: Any) -> dict[str, Any]:
    return {"followers": {"follower": plain()["followers"]["follower"] | changes}}


def robot(**changes: Any) -> dict[str, Any]:
    return {"robots": plain()["robots"] | {"follower": plain()["robots"]["follower"] | changes}}


def test_a_follower_that_converged_is_told_with_when_and_how_near() -> None:
    figures = {"initial_position_error": 2.8, "settling_time": 19.9}
    late = {"late_position_error": 0.004, "late_heading_error": 0.2}
    assert told(**follower(**figures, **late)) == told(**follower(**late, **figures))
    sentence = (
        "follower began 2.8 m from its place and settled after 19.9 s; in the last 15 % of the run it was off by at "
        "most 4 mm and 200 mrad."
    )
    assert sentence in told(**follower(**figures, **late))
    assert "No motor was at its limits." in told()


def test_lengths_stand_beside_shares() -> None:
    """45 mm are little for a follower that began 3 m away, and half a robot all the same."""
    figures = follower(settling_time=20.0, late_position_error=0.045, late_heading_error=0.1)
    run = About(track=0.09)
    text = " ".join(run_verdicts(plain() | figures, run))
    assert "once it stays within 40 µm and 20 mrad of its place until the end" in text
    assert "settled after 20 s" in text
    assert "off by at most 45 mm (50 % of its track width) and 100 mrad." in text
    wide = follower(settling_time=None, late_position_error=0.18)
    assert "180 mm (2 times its track width)" in " ".join(run_verdicts(plain() | wide, run))
    none = follower(settling_time=20.0, late_position_error=1e-14)
    assert "at most 0 m (0 % of its track width)" in " ".join(run_verdicts(plain() | none, run))


def test_sentences_know_sizes_and_roots_from_the_recording() -> None:
    recording = whole_recording(3, samples=201)
    known = about(recording)
    assert known.track == pytest.approx(2 * HALF_SEPARATION)
    assert not known.virtual_root
    text = " ".join(run_verdicts(summary(recording), known))
    assert "4 robots ran on MuJoCo's wheel contacts" in text


def test_a_virtual_leader_is_no_robot_that_ran() -> None:
    leader = load("tour/hello").leader.model_copy(update={"virtual": True})
    recording = whole_recording(1, samples=51, scenario=scenario_tree(leader=leader))
    text = " ".join(run_verdicts(summary(recording), about(recording)))
    assert "1 robot ran behind a virtual leader, which has no body, on MuJoCo's wheel contacts for 80 s" in text
    assert "came closest" not in text
    assert "came closest" in " ".join(run_verdicts(summary(recording)))
    assert "The leader is virtual" in report(recording)
    assert "The leader is virtual" not in report(whole_recording(1, samples=51))


def test_a_follower_that_did_not_settle_is_told_so() -> None:
    text = told(**follower(settling_time=None, late_position_error=0.5, final_position_error=0.25))
    assert "and did not settle" in text
    assert "off by up to 500 mm" in text
    assert "by 250 mm" in text
    assert "settled after" not in text


def test_a_run_that_diverged_is_told_so() -> None:
    text = told(outcome="diverged: tipped over: robot 'follower' at t = 1.250 s", duration=1.24)
    assert "for 1.24 s; then the run diverged, tipped over: robot 'follower' at t = 1.250 s." in text
    assert "completed" not in text
    assert "interrupted" in told(outcome="interrupted")


def test_a_robot_that_slid_is_told_with_how_often() -> None:
    event = {"kind": "slipping", "robot": "follower", "wheel": "left", "start": 1.0, "end": 1.5, "touch": None}
    text = told(events=[event, event | {"start": 3.0}], **robot(peak_utilisation=1.0, torque_saturation_share=0.25))
    assert "slipping twice (follower)" in text
    assert "at the limit of what the floor holds" in text
    assert "limits for 25 % of the run" in text
    assert "No wheel slid" not in text
    assert "No wheel slid" in told()


def test_a_gap_is_told_in_its_units_and_not_made_up() -> None:
    parted = robot(gap_position_max=3e-3, gap_position_rms=1e-3, gap_heading_max=2e-3)
    assert "by at most 3 mm (follower; 1 mm RMS), their headings by at most 2 mrad (follower)." in told(**parted)
    unknown = {"gap_position_max": None, "gap_position_rms": None, "gap_heading_max": None}
    robots = {name: figures | unknown for name, figures in plain()["robots"].items()}
    assert "is not known to the end" in told(robots=robots)
    assert "largest gap to the ideal twin" not in dict(tiles(plain() | {"robots": robots}))


def test_a_crowd_is_told_in_one_go() -> None:
    crowd = summary(whole_recording(9))
    for k, figures in enumerate(crowd["followers"].values()):
        figures["settling_time"] = None if k < 2 else float(k)
    text = " ".join(run_verdicts(crowd))
    assert "7 of 9 followers settled, which is to stay within 40 µm and 20 mrad of their places, the first" in text
    assert "the first after 2 s, half of them after 5 s, the last after 8 s." in text
    assert "f1 and f2 did not settle." in text
    assert dict(tiles(crowd))["followers settled"] == "7 of 9"


def test_quantities_read_as_people_write_them() -> None:
    values = {0.0: "0 m", 2.83: "2.83 m", 0.0041: "4.1 mm", 6.1e-7: "610 nm", None: "unknown", 0.9999: "1 m"}
    values |= {2.56e-12: "2.56 pm", 9e-13: "0 m"}
    assert {value: quantity(value, "m") for value in values} == values
    units = {"1": "0.0041", "rad/s^2": "4.1 mrad/s²", "kg m²": "0.0041 kg m²", "%": "0.41 %", "s": "0.0041 s"}
    assert {unit: cell(0.0041, unit) for unit in units} == units
    assert cell(None, "m") == cell(np.nan, "%") == "-"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed(list("abcdefg")) == "a, b, c, d and 3 others"


# The page -------------------------------------------------------------------------------------------------------------


def test_no_text_of_a_user_is_markup() -> None:
    text = "".join(HOSTILE)
    harmless = whole_recording(1, samples=51)
    told_of = {"scenario": scenario_tree(description=text), "outcome": f"diverged: {text}"}
    hostile = whole_recording(1, samples=51, name=text, **told_of)
    skipped = {"no_film": text, "schema": json_schema()}
    one = Elements(report(harmless, **skipped | {"no_film": "none"}))
    other = Elements(render_run_page(hostile, summary(hostile) | {"warnings": [text]}, Extras(**skipped)))
    tags = [tag for tag, _ in other.found]
    assert tags.count("script") == 3
    assert set(tags) == {tag for tag, _ in one.found} | {"ul", "li"}
    assert not any(name.startswith("on") for _, attributes in other.found for name in attributes)
    assert other.texts["h1"] == [text]
    assert other.texts["title"][0] == f"{text} - nhtrack"


def test_names_of_robots_stay_text() -> None:
    names = ["<b>", "</script>"]
    dataset = whole_recording(1, samples=51).dataset.assign_coords(robot=np.array(names, dtype=object))
    dataset.attrs["parents"] = json.dumps({names[0]: [], names[1]: [names[0]]})
    text = report(Recording(dataset))
    found = Elements(text)
    assert [robot["name"] for robot in numbers_of(text)["robots"]] == names
    assert "b" not in {tag for tag, _ in found.found}
    assert len(found.texts["script"]) == 3
    assert "&lt;b&gt;" in graph_svg({"<b>": (), "x": ("<b>",)})


def test_only_its_own_scripts_run_and_nothing_is_loaded(recording: Recording) -> None:
    found = Elements(report(recording))
    policy = next(
        attributes["content"] for tag, attributes in found.found
        if tag == "meta" and attributes.get("http-equiv") == "Content-Security-Policy"
    )  # fmt: skip
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    for script in found.texts["script"][1:]:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    links = [attributes[name] for _, attributes in found.found for name in ("src", "href") if name in attributes]
    assert links
    assert all(link is not None and link.startswith(("#", "data:")) for link in links)
    assert "eval(" not in found.texts["script"][2]


def test_the_film_is_carried_whole(recording: Recording, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    film.write_bytes(bytes(range(256)))
    found = Elements(report(recording, film=film))
    (source,) = [attributes["src"] for tag, attributes in found.found if tag == "video"]
    assert source is not None
    assert base64.b64decode(source.removeprefix("data:video/mp4;base64,")) == film.read_bytes()
    assert "No film: no headless OpenGL." in report(recording, no_film="no headless OpenGL")


@pytest.mark.slow
def test_the_same_run_gives_the_same_bytes(recording: Recording, tmp_path: Path) -> None:
    recording.save(tmp_path / "recording.nc")
    assert report(recording) == report(Recording.load(tmp_path / "recording.nc"))


# The scenario ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in assets.bundled_scenarios() if name != "stress/formation1000"])
def test_every_key_of_every_scenario_is_explained(name: str) -> None:
    tree = load(name).model_dump(mode="json")
    explained = dict(meanings(tree, json_schema()))
    missing = _keys(tree) - set(explained)
    assert not missing
    assert all(explained.values())


def _keys(tree: dict[str, Any], prefix: str = "") -> set[str]:
    keys = set()
    for key, value in tree.items():
        keys.add(prefix + key)
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, dict):
                keys |= _keys(item, prefix + key + ("[]." if isinstance(value, list) else "."))
    return keys


def test_laws_that_share_a_key_are_told_apart() -> None:
    tree = load("tour/universal").model_dump(mode="json")
    law = next(section for section in json_schema()["$defs"].values()
               if section.get("properties", {}).get("name", {}).get("const") == "universal")  # fmt: skip
    explained = dict(meanings(tree, json_schema()))
    for key, value in law["properties"].items():
        assert explained[f"law.{key}"] == value["description"]


@pytest.mark.parametrize("name", ["paper/example1", "stress/ice_patch", "tour/universal"])
def test_the_scenario_shown_is_the_one_that_ran(name: str, tmp_path: Path) -> None:
    file = tmp_path / "scenario.yaml"
    file.write_text(yaml_text(load(name).model_dump(mode="json")), encoding="utf-8")
    assert load(file) == load(name)


def test_the_graph_has_every_robot_and_every_edge() -> None:
    parents: dict[str, tuple[str, ...]] = {"r0": (), "r1": ("r0",), "r2": ("r0",), "r3": ("r1", "r2")}
    found = Elements(graph_svg(parents))
    tags = [tag for tag, _ in found.found]
    assert (tags.count("circle"), tags.count("path")) == (4, 4 + 1)  # and the tip of arrows
    assert found.texts["title"] == list(parents)
    assert set(parents) < set(found.texts["text"])
    xs = [float(attributes["cx"] or "nan") for tag, attributes in found.found if tag == "circle"]
    assert xs[0] < xs[1] == xs[2] < xs[3]


# The film -------------------------------------------------------------------------------------------------------------


def test_a_film_tells_how_long_it_lasts_and_how_fast_it_is(tmp_path: Path) -> None:
    """The first and the last of 51 frames show the first and the last row: 80 s in 2 s."""
    film = write_pictures(tmp_path / "film.mp4", 51)
    assert duration_of(film.read_bytes()) == pytest.approx(51 / 25, abs=MILLISECOND)
    video = Video(camera="chase", fps=25)
    read = read_film(film, whole_recording(1, samples=51, scenario=scenario_tree(video=video)))
    assert read.speed == pytest.approx(40, rel=MILLISECOND)
    assert read.caption.startswith("The camera follows the first follower; a second of film is 40 s of the robot.")
    slowly = scenario_tree(video=video.model_copy(update={"speed": 1.0}))
    wanted = read_film(film, whole_recording(1, samples=51, scenario=slowly))
    assert (wanted.speed, "a second of film is a second of the robot" in wanted.caption) == (1.0, True)


@pytest.mark.parametrize("content", [b"", b"mvhd", b"....mvhd" + bytes(40), bytes(range(256))])
def test_a_film_that_does_not_tell_is_shown_all_the_same(content: bytes, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    film.write_bytes(content)
    assert duration_of(content) is None
    assert read_film(film, whole_recording(1, samples=51)).speed is None


@pytest.mark.parametrize(("version", "size"), [(0, 4), (1, 8)])
def test_movie_headers_of_both_versions_are_read(version: int, size: int) -> None:
    times, duration = bytes(2 * size), (2500).to_bytes(size)
    content = b"....mvhd" + bytes([version, 0, 0, 0]) + times + (1000).to_bytes(4) + duration + bytes(80)
    assert duration_of(content) == 2.5
