"""What people do with a report, done by a browser: slide, zoom, play, press keys, choose."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from nhtrack.config.video import Video
from nhtrack.recording import Recording
from opened import Opened, Opener
from reports import scenario_tree, whole_recording, write_pictures, write_report

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.slow, pytest.mark.browser]

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


def cursors(opened: Opened) -> np.ndarray:
    """Returns how far right of its panel's left edge every cursor is [px]."""
    return np.array(opened.page.locator(".cursor").evaluate_all(CURSORS))


def numbers_in(transform: str | None) -> list[float]:
    assert transform is not None
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", transform)]


def test_slider_moves_robots_cursors_and_figures_together(
    open_report: Opener, run_report: Path, recording: Recording
) -> None:
    opened = open_report(run_report)
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


def test_keys_reach_everything_move_time_and_play(open_report: Opener, run_report: Path) -> None:
    opened = open_report(run_report)
    press, frame = opened.page.keyboard.press, lambda: int(opened.page.locator("#time").input_value())
    assert frame() == 400
    press("Home")
    for key, expected in (("ArrowRight", 1), ("Shift+ArrowRight", 11), ("ArrowLeft", 10), ("End", 400), ("Home", 0)):
        press(key)
        assert frame() == expected, key
    press(" ")
    assert opened.page.locator("#play").get_attribute("aria-label") == "Pause"
    opened.until("document.getElementById('time').value > 0")
    press(" ")
    assert opened.page.locator("#play").get_attribute("aria-label") == "Play"
    stopped = frame()
    opened.page.wait_for_timeout(150)  # four frames, if it still played
    assert frame() == stopped > 0
    opened.page.locator("#time").focus()
    press("End")
    assert frame() == 400
    missing = {"theme", "play", "time", "speed", "readouts", "scroll"}
    for _ in range(60):
        missing.discard(opened.page.evaluate("document.activeElement.id || document.activeElement.className"))
        if not missing:
            break
        press("Tab")
    assert not missing


def test_choices_show_wheels_twin_and_axes_and_zooming_one_plot_zooms_all(
    open_report: Opener, run_report: Path, recording: Recording
) -> None:
    opened = open_report(run_report)
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
    kind = "['position', 'heading'].map(key => document.getElementById(`panel-${key}`)._fullLayout.yaxis.type)"
    assert opened.page.evaluate(kind) == ["log", "log"]
    opened.page.check('input[name="axis"][value="linear"]')
    assert opened.page.evaluate(kind) == ["linear", "linear"]

    opened.slide(200)
    panel = opened.page.locator("#panel-u_x")
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    assert box is not None
    cursor = opened.page.locator(".cursor").first
    before = cursor.get_attribute("style")
    opened.page.mouse.move(box["x"] + 150, box["y"] + 80)
    opened.page.mouse.down()
    opened.page.mouse.move(box["x"] + 450, box["y"] + 84, steps=4)
    opened.page.mouse.up()
    ranges = "[...document.querySelectorAll('.panel')].map(div => div.layout.xaxis.range)"
    opened.until(f"new Set({ranges}.map(String)).size === 1 && {ranges}[0][0] > 0")
    cursor.locator(f"xpath=self::*[@style != '{before}']").wait_for(state="attached")
    zoomed = np.array(opened.page.evaluate(ranges), dtype=float)
    assert np.diff(zoomed[0])[0] < 0.8 * recording.time[-1]
    widths = np.array(
        opened.page.locator(".overlay:has(.cursor)").evaluate_all("nodes => nodes.map(n => n.clientWidth)")
    )
    share = (recording.time[200] - zoomed[0, 0]) / np.diff(zoomed[0])[0]
    np.testing.assert_allclose(cursors(opened), share * widths, atol=1.5)


def test_floors_show_paths_so_far_and_curves_their_names(open_report: Opener, run_report: Path) -> None:
    opened = open_report(run_report)
    lengths = "document.getElementById('floor').data.map(({x}) => x.length)"
    assert set(opened.page.evaluate(lengths)) == {401}
    opened.slide(100)
    opened.until(f"{lengths}.every((length) => length === 101) && !document.querySelector('#floor.moving')")
    for panel in opened.page.locator(".panel").all():
        places = "nodes => nodes.map(n => [n.textContent, n.getBoundingClientRect().y])"
        names = panel.locator(".name").evaluate_all(places)
        assert {name for name, _ in names} == set(panel.evaluate("div => div.data.map(({name}) => name)"))
        assert np.diff(sorted(height for _, height in names)).min(initial=99) > 12.0


def test_no_button_sends_anything_anywhere(open_report: Opener, run_report: Path) -> None:
    opened = open_report(run_report)
    titles = opened.page.locator(".modebar-btn").evaluate_all("nodes => nodes.map(n => n.dataset.title)")
    assert titles == ["Download plot as a PNG", "Zoom", "Pan", "Zoom in", "Zoom out", "Reset axes"]
    contexts = opened.page.evaluate("[...document.querySelectorAll('.plot')].map(({_context: c}) => c.plotlyServerURL)")
    assert set(contexts) == {""}


def has_h264(opened: Opened) -> bool:
    kind = 'video/mp4; codecs="avc1.42E01E"'
    return bool(opened.page.evaluate("kind => document.createElement('video').canPlayType(kind)", kind))


def test_the_film_moves_with_the_slider_and_plays_with_the_plots(open_report: Opener, tmp_path: Path) -> None:
    """40 of 80 s of the robot in 51 frames at 25 a second: 2 s of film, at 20 times the robot's speed."""
    film = write_pictures(tmp_path / "video.mp4", 51)
    recording = whole_recording(3, samples=401, scenario=scenario_tree(video=Video(fps=25, speed=20.0)))
    opened = open_report(write_report(recording, tmp_path / "report.html", film=film))
    if not has_h264(opened):
        pytest.skip("this browser was built without H.264")
    page, clip = opened.page, opened.page.locator("video")
    opened.until("document.getElementById('video').readyState >= 2")
    assert clip.evaluate("video => [video.duration, video.videoWidth]") == pytest.approx([2.04, 160], abs=0.05)
    shown = "Math.abs(document.getElementById('video').currentTime - {}) < 0.03"
    opened.until(shown.format(2.04))  # the page opens at the end of the run, where the film has ended
    opened.slide(150)
    opened.until(shown.format(1.5))
    page.keyboard.press("Home")
    opened.until(shown.format(0.0))
    assert not clip.evaluate("video => video.controls")  # one control for all that plays, at the film's own speed
    assert page.locator("#speed").input_value() == "20"
    page.click("#play")
    opened.until("parseFloat(document.getElementById('clock').textContent) > 10")
    assert clip.evaluate("video => [video.paused, video.playbackRate]") == [False, pytest.approx(1.0, abs=0.01)]
    page.click("#play")
    opened.until("document.getElementById('video').paused && !document.getElementById('video').seeking")
    page.wait_for_timeout(100)
    shown_time = 20 * clip.evaluate("video => video.currentTime")
    assert min(opened.time(), 40.8) == pytest.approx(shown_time, abs=1.0)
    assert "a second of film is 20 s of the robot" in page.locator("#film figcaption").inner_text()


def test_a_run_gone_wild_is_shown_and_names_stay_text(open_report: Opener, tmp_path: Path) -> None:
    recording = whole_recording(1, samples=101, name=HOSTILE, scenario=scenario_tree(description=HOSTILE))
    recording["pose"].values[90:, 1, 0] = 1e30
    recording["ideal_pose"].values[50:] = np.nan
    names = np.array(["<img src=x onerror=alert(2)>", "</script><script>alert(3)</script>"], dtype=object)
    dataset = recording.dataset.assign_coords(robot=names)
    dataset.attrs["parents"] = json.dumps({names[0]: [], names[1]: [names[0]]})
    opened = open_report(write_report(Recording(dataset), tmp_path / "report.html", no_film=HOSTILE))
    assert opened.page.locator("h1").inner_text() == HOSTILE
    assert opened.page.title() == f"{HOSTILE} - nhtrack"
    assert opened.page.locator(".readouts tbody th").all_inner_texts() == list(names)
    opened.slide(100)
    twin = opened.page.locator('.robot[data-kind="twin"]').last
    assert not twin.is_visible()  # it is not known any more
    opened.slide(0)
    assert twin.evaluate("node => node.style.display") == ""
    panel = opened.page.locator("#panel-u_x")
    panel.hover(position={"x": 200, "y": 80})  # Plotly writes names beside the pointer
    panel.locator(".hoverlayer .legend").wait_for()
    assert names[1] in panel.locator(".hoverlayer").text_content()
    assert opened.page.locator("img").count() == 0


def test_a_run_that_hardly_began_is_shown(open_report: Opener, tmp_path: Path) -> None:
    opened = open_report(write_report(whole_recording(1, stop=0.0), tmp_path / "report.html"))
    assert opened.time() == 0.0
    opened.page.keyboard.press("End")
    assert np.isfinite(cursors(opened)).all()


def test_64_robots_are_small_enough_and_soon_there(browser: Browser, tmp_path: Path) -> None:
    path = write_report(whole_recording(63, samples=2001), tmp_path / "report.html")
    assert path.stat().st_size < MOST_BYTES
    before = renderers(browser)
    opened = Opened(browser.new_page()).show(path)  # in a process of its own, which has not read Plotly yet
    wall = float(opened.page.locator("html").get_attribute("data-first-plot") or "nan") / 1000
    busy = max(time for process, time in renderers(browser).items() if process not in before)
    size = f"{path.stat().st_size / 1e6:.1f} MB"
    print(f"\n64 robots: {size}, first plot after {wall:.1f} s, all plots with {busy:.1f} s of the processor")
    assert busy < SLACK * FIRST_PLOT
    assert opened.page.locator(".robot").count() == 2 * 64
    assert opened.page.locator(".readouts tbody tr").count() == 64
    opened.page.close()
    assert opened.problems == []


def renderers(browser: Browser) -> dict[int, float]:
    """Returns what the processes that draw pages have cost so far [s], by their numbers."""
    every = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    return {process["id"]: process["cpuTime"] for process in every if process["type"] == "renderer"}
