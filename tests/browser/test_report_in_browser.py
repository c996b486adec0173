"""What people do with a report, done by a browser: slide, play, press keys, choose, switch colours, print."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from nhtrack.recording import Recording
from opened import Opened, Opener
from reports import whole_recording, write_pictures, write_report

pytestmark = pytest.mark.slow

SIZES = [(640, 480), (1280, 720)]
MOST_BYTES = 15e6  # of 64 robots without a film
FIRST_PLOT = 3.0  # [s] that 64 robots may take on a machine with nothing else to do, as processor time of the page
SLACK = 3.0  # processors differ, and lose time to each other on a busy machine
PIXEL = 0.6  # [px] Plotly rounds to whole pixels where it draws
HOSTILE = "<img src=x onerror=alert(1)>"

# Where Plotly itself puts a place of the floor, in pixels from the plot's corner.
PLACE = """([x, y]) => {
    const {xaxis, yaxis} = document.getElementById('floor')._fullLayout;
    return [xaxis.l2p(x), yaxis.l2p(y)];
}"""
CURSORS = "nodes => nodes.map(node => new DOMMatrix(node.style.transform).e)"
OVERFLOW = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


def cursors(opened: Opened) -> np.ndarray:
    """Returns how far right of its panel's left edge every cursor is [px]."""
    return np.array(opened.page.locator(".cursor").evaluate_all(CURSORS))


def numbers_in(transform: str | None) -> list[float]:
    assert transform is not None
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", transform)]


def test_slider_moves_robots_cursors_and_figures_together(
    open_report: Opener, report: Path, recording: Recording
) -> None:
    opened = open_report(report)
    for frame in (0, 200, 400):
        opened.slide(frame)
        assert opened.time() == pytest.approx(recording.time[frame], abs=0.006)
        for place, robot in enumerate(recording.robots):
            x, y, theta = recording["pose"].values[frame, place]
            across, down, *_, turn = numbers_in(opened.glyph(robot))
            assert [across, down] == pytest.approx(opened.page.evaluate(PLACE, [x, y]), abs=PIXEL)
            assert turn == pytest.approx(np.degrees(theta), abs=1e-3)
        widths = opened.page.locator(".overlay:has(.cursor)").evaluate_all("nodes => nodes.map(n => n.clientWidth)")
        expected = np.array(widths) * recording.time[frame] / recording.time[-1]
        np.testing.assert_allclose(cursors(opened), expected, atol=1.5)
        assert len(expected) == 11
        shown = opened.page.locator(".readouts tbody tr").nth(1).locator("td").first.inner_text()
        error = np.hypot(*recording["error"].values[frame, 1, :2])
        assert float(shown) == pytest.approx(error, rel=5e-2)


def test_keys_move_time_and_play(open_report: Opener, report: Path) -> None:
    opened = open_report(report)
    press, frame = opened.page.keyboard.press, lambda: int(opened.page.locator("#time").input_value())
    for key, expected in (("ArrowRight", 1), ("Shift+ArrowRight", 11), ("ArrowLeft", 10), ("End", 400), ("Home", 0)):
        press(key)
        assert frame() == expected, key
    press(" ")
    assert opened.page.locator("#play").get_attribute("aria-label") == "Pause"
    opened.page.wait_for_selector('#time[aria-valuetext]:not([aria-valuetext="0.00 seconds"])')
    press(" ")
    assert opened.page.locator("#play").get_attribute("aria-label") == "Play"
    assert frame() > 0
    stopped = frame()
    opened.page.wait_for_timeout(300)
    assert frame() == stopped
    opened.page.locator("#time").focus()
    press("End")
    assert frame() == 400


def test_everything_is_reached_with_the_tab_key(open_report: Opener, report: Path) -> None:
    opened = open_report(report)
    reached = set()
    for _ in range(60):
        opened.page.keyboard.press("Tab")
        reached.add(opened.page.evaluate("document.activeElement.id || document.activeElement.className"))
    assert {"theme", "play", "time", "speed", "readouts", "scroll"} <= reached
    nameless = opened.page.locator("button, input, select, video, [role=img], [role=group], [tabindex]").evaluate_all(
        "nodes => nodes.filter(n => !n.ariaLabel && !n.labels?.length && !n.closest('.modebar')).map(n => n.outerHTML)"
    )
    assert nameless == []


def test_a_choice_shows_wheels_or_twin_or_both(open_report: Opener, report: Path) -> None:
    opened = open_report(report)
    for choice, kinds in (("both", {"pose", "twin"}), ("main", {"pose"}), ("twin", {"twin"})):
        opened.page.check(f'input[name="shown"][value="{choice}"]')
        drawn = opened.page.evaluate(
            "document.getElementById('floor').data.filter(d => d.visible !== false).map(d => d.meta)"
        )
        seen = opened.page.locator(".robot").evaluate_all(
            "nodes => nodes.filter(n => n.style.display !== 'none').map(n => n.dataset.kind)"
        )
        assert set(drawn) == set(seen) == kinds
        assert len(drawn) == len(seen) == 4 * len(kinds)


def test_axes_of_errors_are_logarithmic_or_linear(open_report: Opener, report: Path) -> None:
    opened = open_report(report)
    kind = "['position', 'heading'].map(key => document.getElementById(`panel-${key}`)._fullLayout.yaxis.type)"
    assert opened.page.evaluate(kind) == ["log", "log"]
    opened.page.check('input[name="axis"][value="linear"]')
    assert opened.page.evaluate(kind) == ["linear", "linear"]


def test_zooming_one_plot_zooms_all_of_them(open_report: Opener, report: Path, recording: Recording) -> None:
    opened = open_report(report)
    opened.slide(200)
    panel = opened.page.locator("#panel-u_x")
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    assert box is not None
    opened.page.mouse.move(box["x"] + 150, box["y"] + 80)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + 450, box["y"] + 84, steps=4)
    opened.page.mouse.up()
    ranges = "[...document.querySelectorAll('.panel')].map(div => div.layout.xaxis.range)"
    opened.page.wait_for_timeout(500)
    zoomed = np.array(opened.page.evaluate(ranges), dtype=float)
    assert np.ptp(zoomed, axis=0).max() == 0.0
    assert np.diff(zoomed[0])[0] < 0.8 * recording.time[-1]
    widths = np.array(
        opened.page.locator(".overlay:has(.cursor)").evaluate_all("nodes => nodes.map(n => n.clientWidth)")
    )
    share = (recording.time[200] - zoomed[0, 0]) / np.diff(zoomed[0])[0]
    np.testing.assert_allclose(cursors(opened), share * widths, atol=1.5)


@pytest.mark.parametrize("dark", [False, True])
def test_a_button_switches_light_and_dark(open_report: Opener, report: Path, dark: bool) -> None:
    opened = open_report(report, dark=dark)
    look = """() => [
        getComputedStyle(document.body).backgroundColor,
        getComputedStyle(document.querySelector('#floor .xtick text')).fill,
        getComputedStyle(document.querySelector('#panel-u_x .xtick text')).fill,
    ].map(colour => Number(colour.match(/\\d+/)[0]) > 127)"""
    assert opened.page.evaluate(look) == [not dark, dark, dark]
    opened.page.click("#theme")
    assert opened.page.evaluate(look) == [dark, not dark, not dark]


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_wider_than_the_window(open_report: Opener, report: Path, size: tuple[int, int]) -> None:
    opened = open_report(report, size=size)
    assert opened.page.evaluate(OVERFLOW) == 0
    opened.page.set_viewport_size({"width": 900, "height": 600})
    opened.page.wait_for_timeout(1000)
    assert opened.page.evaluate(OVERFLOW) == 0
    drawn, room = opened.page.evaluate(
        "[document.querySelector('#floor .main-svg').clientWidth, document.getElementById('floor').clientWidth]"
    )
    assert drawn == room


def test_the_film_plays(open_report: Opener, recording: Recording, tmp_path: Path) -> None:
    film = write_pictures(tmp_path / "video.mp4", 100)
    opened = open_report(write_report(recording, tmp_path / "report.html", film=film))
    if not has_h264(opened):
        pytest.skip("this browser was built without H.264")
    times = opened.page.locator("video").evaluate(
        """async (video) => {
            video.muted = true;
            await video.play();
            const start = video.currentTime;
            await new Promise((resolve) => { video.ontimeupdate = () => video.currentTime > start && resolve(); });
            return [start, video.currentTime, video.duration, video.videoWidth];
        }"""
    )
    assert times[1] > times[0]
    assert times[2:] == pytest.approx([4.0, 160], abs=0.1)


def has_h264(opened: Opened) -> bool:
    kind = 'video/mp4; codecs="avc1.42E01E"'
    return bool(opened.page.evaluate("kind => document.createElement('video').canPlayType(kind)", kind))


def test_film_and_slider_move_each_other(open_report: Opener, recording: Recording, tmp_path: Path) -> None:
    """80 s of the robot in 101 frames at 25 a second: 4 s of film, at 20 times the robot's speed."""
    film = write_pictures(tmp_path / "video.mp4", 101)
    scenario = recording.scenario | {"video": {"camera": "group", "fps": 25, "speed": 20.0}}
    dataset = recording.dataset.assign_attrs(scenario=json.dumps(scenario))
    opened = open_report(write_report(Recording(dataset), tmp_path / "report.html", film=film))
    if not has_h264(opened):
        pytest.skip("this browser was built without H.264")
    page, clip = opened.page, opened.page.locator("video")
    opened.until("document.getElementById('video').readyState >= 2")
    shown = "Math.abs(document.getElementById('video').currentTime - {}) < 0.03"
    opened.slide(200)
    opened.until(shown.format(2.0))
    page.keyboard.press("End")
    opened.until(shown.format(4.0))
    clip.evaluate("video => { video.currentTime = 1.0; }")
    opened.until("Math.abs(parseFloat(document.getElementById('clock').textContent) - 20) < 0.5")
    clip.evaluate("video => video.play()")
    opened.until("parseFloat(document.getElementById('clock').textContent) > 30")
    clip.evaluate("video => video.pause()")
    page.wait_for_timeout(100)
    assert opened.time() == pytest.approx(20 * clip.evaluate("video => video.currentTime"), abs=1.0)
    caption = page.locator("#film figcaption").inner_text()
    assert "a second of film is 20 s of the robot" in caption


def test_a_film_that_ends_early_stays_at_its_end(open_report: Opener, recording: Recording, tmp_path: Path) -> None:
    film = write_pictures(tmp_path / "video.mp4", 50)
    scenario = recording.scenario | {"video": {"camera": "group", "fps": 25, "speed": 20.0}}  # 40 of 80 s
    dataset = recording.dataset.assign_attrs(scenario=json.dumps(scenario))
    opened = open_report(write_report(Recording(dataset), tmp_path / "report.html", film=film))
    if not has_h264(opened):
        pytest.skip("this browser was built without H.264")
    opened.until("document.getElementById('video').readyState >= 2")
    opened.slide(400)
    opened.until("document.getElementById('video').currentTime > 1.9")
    opened.page.wait_for_timeout(300)
    assert opened.time() == pytest.approx(80.0)


def test_names_stay_text(open_report: Opener, tmp_path: Path) -> None:
    recording = whole_recording(1, samples=51, name=HOSTILE, scenario={"name": HOSTILE, "description": HOSTILE})
    names = np.array(["<img src=x onerror=alert(2)>", "</script><script>alert(3)</script>"], dtype=object)
    dataset = recording.dataset.assign_coords(robot=names)
    dataset.attrs["parents"] = json.dumps({names[0]: [], names[1]: [names[0]]})
    opened = open_report(write_report(Recording(dataset), tmp_path / "report.html", no_film=HOSTILE))
    assert opened.page.locator("h1").inner_text() == HOSTILE
    assert opened.page.title() == f"{HOSTILE} - nhtrack"
    assert opened.page.locator(".readouts tbody th").all_inner_texts() == list(names)
    box = opened.page.locator("#panel-u_x").bounding_box()
    assert box is not None
    opened.page.locator("#panel-u_x").hover(position={"x": 200, "y": 80})  # Plotly writes names beside the pointer
    opened.page.wait_for_timeout(500)
    assert opened.page.locator("img").count() == 0


def test_a_run_that_hardly_began_and_one_gone_wild_are_shown(open_report: Opener, tmp_path: Path) -> None:
    short = open_report(write_report(whole_recording(1, stop=0.0), tmp_path / "short.html"))
    assert short.time() == 0.0
    short.page.keyboard.press("End")
    assert np.isfinite(cursors(short)).all()
    recording = whole_recording(1, samples=101)
    recording["pose"].values[90:, 1, 0] = 1e30
    recording["ideal_pose"].values[50:] = np.nan
    wild = open_report(write_report(recording, tmp_path / "wild.html"))
    wild.slide(100)
    twin = wild.page.locator('.robot[data-robot="follower"][data-kind="twin"]')
    assert not twin.is_visible()  # it is not known any more
    wild.slide(0)
    assert twin.evaluate("node => node.style.display") == ""


def test_64_robots_are_small_enough_and_soon_there(open_report: Opener, tmp_path: Path) -> None:
    path = write_report(whole_recording(63, samples=8001), tmp_path / "report.html")
    assert path.stat().st_size < MOST_BYTES
    opened = open_report(path)
    wall = float(opened.page.locator("html").get_attribute("data-first-plot") or "nan") / 1000
    browser = opened.page.context.browser
    assert browser is not None
    processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    busy = max(process["cpuTime"] for process in processes if process["type"] == "renderer")
    size = f"{path.stat().st_size / 1e6:.1f} MB"
    print(f"\n64 robots: {size}, first plot after {wall:.1f} s, all plots with {busy:.1f} s of the processor")
    assert busy < SLACK * FIRST_PLOT
    assert opened.page.locator(".robot").count() == 2 * 64
    assert opened.page.locator(".readouts tbody tr").count() == 64


@pytest.mark.parametrize("dark", [False, True])
def test_paper_is_light_and_as_wide_as_a_sheet(open_report: Opener, report: Path, dark: bool) -> None:
    opened = open_report(report, size=(794, 1123), dark=dark)  # A4 at 96 dots per inch
    opened.page.emulate_media(media="print")
    opened.page.wait_for_selector("html.printing", state="attached")
    assert not opened.page.locator(".player").is_visible()
    assert opened.page.evaluate(OVERFLOW) == 0
    assert opened.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    wide = "[...document.querySelectorAll('.plot')].map(d => d.querySelector('.main-svg').clientWidth - d.clientWidth)"
    assert set(opened.page.evaluate(wide)) == {0}
    paper = opened.page.pdf(format="A4", print_background=True)
    assert paper.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", paper)) in range(2, 9)
    opened.page.emulate_media(media="screen")
    opened.page.wait_for_selector("html:not(.printing)", state="attached")
    assert opened.page.locator(".player").is_visible()
