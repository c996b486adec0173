"""What every report can do, and what people do with those of comparisons, campaigns, the paper and fidelity."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from campaign_tables import campaign_starts
from nhtrack.experiment.load import load_campaign
from nhtrack.studies.campaign.report import Account, write_campaign_page
from nhtrack.studies.campaign.tables import cells_of
from opened import FITS, PLOTS_FIT, Opened, Opener

pytestmark = [pytest.mark.slow, pytest.mark.browser]

PAGES = ("run", "comparison", "campaign", "sweep", "paper", "fidelity")
SMALL, USUAL, SHEET = (640, 480), (1280, 720), (794, 1123)  # A4 at 96 dots per inch
NAMELESS = """nodes => nodes
    .filter(n => !n.ariaLabel && !n.labels?.length && !n.alt && !n.textContent.trim() && !n.closest('.modebar'))
    .map(n => n.outerHTML)"""
# Whether paper, text and the numbers on axes are as bright as on a page that is `light`.
LOOKS = """(light) => {
    const bright = (colour) => Number(colour.match(/\\d+/)[0]) > 127;
    const {backgroundColor, color} = getComputedStyle(document.body);
    const ticks = [...document.querySelectorAll('.plot .xtick text')].map((text) => getComputedStyle(text).fill);
    return bright(backgroundColor) === light && [color, ...ticks].every((ink) => bright(ink) !== light);
}"""
LIGHT, DARK = f"({LOOKS})(true)", f"({LOOKS})(false)"
MOST_BYTES = 15e6
PIXEL = 0.6  # [px] Plotly rounds to whole pixels where it draws


def data_of(opened: Opened) -> dict:
    return json.loads(opened.page.locator("#data").evaluate("node => node.textContent"))


@pytest.mark.parametrize("name", PAGES)
def test_every_page_is_light_and_dark_fits_prints_and_says_what_things_are(
    open_report: Opener, name: str, request: pytest.FixtureRequest
) -> None:
    path: Path = request.getfixturevalue(f"{name}_report")
    assert path.stat().st_size < MOST_BYTES
    opened = open_report(path, size=SMALL, dark=True)
    page, player = opened.page, opened.page.locator(".player")
    opened.until(DARK)
    page.emulate_media(color_scheme="light")
    opened.until(LIGHT)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "theme"
    page.keyboard.press("Enter")
    opened.until(DARK)

    assert page.locator("button, input, select, video, img, [role=img], [role=group], [tabindex]").evaluate_all(
        NAMELESS
    ) == []  # fmt: skip
    links = page.locator("nav a").evaluate_all("nodes => nodes.map(n => n.getAttribute('href'))")
    assert {"#verdict", "#provenance"} < set(links)
    assert all(page.locator(link).count() == 1 for link in links)
    assert page.locator(".verdicts li").count() > 0
    assert "nhtrack " in page.locator("#provenance pre").first.inner_text()

    for size in (SMALL, USUAL, SHEET):
        opened.resize(size)
        opened.until(PLOTS_FIT)
        opened.until(FITS)
    opened.print_out()
    assert page.evaluate(FITS)
    opened.until(LIGHT)
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not player.is_visible()
    paper = page.pdf(format="A4", print_background=True)
    assert paper.startswith(b"%PDF")
    assert len(re.findall(rb"/Type\s*/Page\b", paper)) in range(2, 9)
    page.emulate_media(media="screen")
    page.wait_for_selector("html:not(.printing)", state="attached")
    opened.until(DARK)
    assert player.count() == player.is_visible()


# Comparisons ----------------------------------------------------------------------------------------------------------


def test_all_laws_move_with_one_slider_on_axes_that_fit_those_that_completed(
    open_report: Opener, comparison_report: Path
) -> None:
    opened = open_report(comparison_report)
    frames = data_of(opened)["frames"]
    robots = ("leader", "follower-published", "follower-kanayama-1", "follower-kanayama-2")
    place = """([x, y]) => {
        const {xaxis, yaxis} = document.getElementById('floor')._fullLayout;
        return [xaxis.l2p(x), yaxis.l2p(y)];
    }"""
    for frame in (0, 40, 80):
        opened.slide(frame)
        for k, robot in enumerate(robots):
            numbers = re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", opened.glyph(robot) or "")
            x, y = (frames["pose"][side][k][frame] for side in "xy")
            spot = opened.page.evaluate(place, [x, y])
            assert [float(number) for number in numbers[:2]] == pytest.approx(spot, abs=PIXEL)
    cells = opened.page.locator(".readouts tbody tr").nth(3).locator("td")
    assert cells.first.inner_text() == "-"  # its run has ended
    opened.slide(2)
    assert float(cells.first.inner_text()) > 0

    drawn = opened.page.evaluate("document.getElementById('panel-u_x')._fullLayout.yaxis.range")
    curves = {curve["name"]: curve["y"] for panel in data_of(opened)["panels"] if panel["key"] == "u_x"
              for curve in panel["curves"]}  # fmt: skip
    largest = {name: np.abs([value for value in y if value is not None]).max() for name, y in curves.items()}
    assert largest["follower-kanayama-2"] > 10 * drawn[1]
    assert drawn[0] < 0 < largest["follower-kanayama-1"] < drawn[1]
    bold = opened.page.locator(".standings tbody tr").nth(2).locator("strong")
    assert bold.count() == 0  # a law whose run did not complete is best at nothing


# Campaigns ------------------------------------------------------------------------------------------------------------


def test_cells_and_lists_choose_law_and_reference_of_all_plots_and_the_pointer_tells(
    open_report: Opener, campaign_report: Path
) -> None:
    opened = open_report(campaign_report)
    page, data = opened.page, data_of(opened)
    drawn = "document.getElementById('map').data.slice(0, 3).map(trace => trace.x.length)"
    broad = """[...document.querySelectorAll('.panel')].map(
        div => div.data.filter(trace => trace.line.width > 2).map(trace => trace.name))"""
    for law, family in ((0, 1), (1, 0)):  # all of one arrive, and none of the other
        cell = page.locator(f'.cell[data-law="{law}"][data-family="{family}"]')
        cell.click()
        starts = data["starts"][law][family]
        fates = [starts["fate"].count(fate) for fate in ("arrived", "astray", "lost")]
        assert sum(fates) == 8
        assert page.evaluate(drawn) == fates
        assert cell.get_attribute("aria-pressed") == "true"
        assert page.locator('.cell[aria-pressed="true"]').count() == 1
        assert page.locator("#law").input_value() == str(law)
        assert page.locator("#told").inner_text() == cell.get_attribute("title")
        assert page.locator("#chosen").inner_text() == f"{fates[0]} of 8 arrive"
        names = [data["laws"][law]["name"]]
        assert [found for found in page.evaluate(broad) if found] == [names] * page.locator(".panel").count()

    starts = data["starts"][0][1]
    page.select_option("#family", label="sinus")
    page.select_option("#law", label="kanayama")
    assert page.evaluate(drawn) == [8, 0, 0]
    place = next(k for k, x in enumerate(starts["x"]) if 1 < abs(x))
    spot = page.evaluate(
        """([x, y]) => {
            const {xaxis, yaxis} = document.getElementById('map')._fullLayout;
            return [xaxis._offset + xaxis.l2p(x), yaxis._offset + yaxis.l2p(y)];
        }""",
        [starts["x"][place], starts["y"][place]],
    )
    page.locator("#map").scroll_into_view_if_needed()
    page.locator("#map").hover(position={"x": spot[0], "y": spot[1]})
    page.wait_for_selector("#map .hoverlayer .hovertext")
    assert f"start {starts['start'][place]}," in (page.locator("#map .hoverlayer").text_content() or "")
    page.locator('.cell[data-law="1"][data-family="0"]').hover()
    assert page.locator("#told").inner_text().startswith("samson against rest: ")
    page.mouse.move(5, 5)
    assert page.locator("#told").inner_text().startswith("kanayama against sinus: ")


def test_names_of_laws_and_references_stay_text(open_report: Opener, tmp_path: Path) -> None:
    hostile = "<img src=x onerror=alert(1)>"
    runs = campaign_starts((hostile,), ("</script><script>alert(2)</script>",), count=20)
    cells = cells_of(runs, {}, backend="ideal", position_limit=0.01, heading_limit=0.02)
    tree = load_campaign("campaign/small", []).model_dump(mode="json") | {"name": hostile, "description": hostile}
    opened = open_report(write_campaign_page(runs, cells, Account(tree, {}, {}, {}), tmp_path / "report.html"))
    assert opened.page.title() == f"{hostile} - nhtrack"
    assert opened.page.locator("#law option").inner_text() == hostile
    panel = opened.page.locator("#panel-effort_x")
    panel.scroll_into_view_if_needed()
    spot = opened.page.evaluate(
        """() => {
            const div = document.getElementById('panel-effort_x');
            const {xaxis, yaxis} = div._fullLayout;
            const {x, y} = div.data[0];
            return [xaxis._offset + xaxis.l2p(x[10]), yaxis._offset + yaxis.l2p(y[10])];
        }"""
    )
    panel.hover(position={"x": spot[0], "y": spot[1]})  # Plotly writes the law's name beside the pointer
    panel.locator(".hoverlayer .hovertext").wait_for()
    assert opened.page.locator("img").count() == 0


# The paper ------------------------------------------------------------------------------------------------------------


def test_figures_of_the_paper_are_seen_in_the_page(open_report: Opener, paper_report: Path) -> None:
    opened = open_report(paper_report)
    sizes = opened.page.locator("img").evaluate_all("nodes => nodes.map(n => [n.naturalWidth, n.clientWidth])")
    assert len(sizes) == 1
    natural, shown = sizes[0]
    assert natural > shown > 500
    verdict = opened.page.locator("#example-3 .claim dd").nth(1).inner_text()
    assert "In example3_pi the follower turns clockwise by 1 pi." in verdict
    assert "In example3_minus_pi the follower turns anticlockwise by 1 pi." in verdict


# The fidelity suite ---------------------------------------------------------------------------------------------------


def test_checks_are_filtered_and_ordered(open_report: Opener, fidelity_report: Path) -> None:
    opened = open_report(fidelity_report)
    page = opened.page
    shown = """[...document.querySelectorAll('.checks tbody tr')].filter(row => row.offsetParent)
        .map(row => [row.dataset.robot, Number(row.dataset.used), row.querySelector('.bar').clientWidth])"""
    before = page.evaluate(shown)
    assert [row[0] for row in before] == ["nh_mini"] * 3 + ["burger"] * 3
    page.select_option("#robot", "burger")
    assert [row[0] for row in page.evaluate(shown)] == ["burger"] * 3
    page.select_option("#robot", "")
    page.check('input[name="order"][value="used"]')
    uses = [row[1] for row in page.evaluate(shown)]
    assert uses == sorted(uses, reverse=True)
    assert len(uses) == 6
    page.check('input[name="order"][value="listed"]')
    assert page.evaluate(shown) == before


# Sweeps ---------------------------------------------------------------------------------------------------------------


def test_a_run_that_is_chosen_on_the_page_of_a_sweep_is_told_with_its_command(
    open_report: Opener, sweep_report: Path
) -> None:
    page = (opened := open_report(sweep_report)).page
    data, table = data_of(opened), pd.read_parquet(sweep_report.parent / "runs.parquet")

    def chosen() -> pd.Series:
        run = int(re.findall(r"^Run (\d+):", page.locator("#chosen").inner_text())[0])
        row, words = table.loc[run], shlex.split(page.locator("#command").inner_text())
        assert words[:3] == ["nhtrack", "run", "tour/lemniscate"]
        assert f"delay={row['delay']}" in words
        assert f"followers[0].start.pose[1]={float(row['followers[0].start.pose[1]'])!r}" in words
        assert row["law"] in page.locator("#chosen").inner_text()
        return row

    page.locator(".choose").last.click()
    assert chosen()["effort_x"] == table["effort_x"].max()
    assert page.locator("#file a").get_attribute("href") == "extremes/largest_effort_x.yaml"
    page.select_option("#pair", label="law by delay")
    page.locator("#heat .nsewdrag").click(position={"x": 9, "y": 9})
    opened.until("document.getElementById('command').textContent.includes('delay=0')")
    row = chosen()
    assert (row["law"], row["delay"]) == ("<b>another</b>", 0)
    page.select_option("#pair", label="delay by followers[0].start.pose[1]")
    page.locator("#slices select").first.select_option(label="a law")
    shown = page.evaluate("document.getElementById('heat').data[0].z.flat().filter((value) => value !== null).length")
    places = [axis["key"] for axis in data["axes"]].index("law")
    held = next(each for each in data["maps"] if each["axes"] == [1, 2])
    laws = data["rows"]["axes"][places]
    assert shown == len({cell for cell, law in zip(held["runs"], laws, strict=True) if law == 0})
    page.locator(".pair").click()
    front = page.evaluate("document.getElementById('scatter').data[1].x")
    assert front == sorted(front)
    assert f"{len(front)} on the front" in page.locator("#front-told").inner_text()
    page.locator("#dots").click(position={"x": 160, "y": 40})
    chosen()
    bars = page.evaluate("document.getElementById('bars').data.map(({x}) => x)")
    assert [len(each) for each in bars] == [3, 3]
