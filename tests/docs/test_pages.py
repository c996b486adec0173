"""The scripts that write pages of docs/: markers, and the tables of campaigns."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from campaign_tables import FAMILIES, LAWS, campaign_cells, campaign_starts
from nhtrack.config.families import FAMILIES as BUNDLED
from nhtrack.config.families import QUICK

DOCS = Path(__file__).resolve().parents[2] / "docs"
SIZES = (("position", "m"), ("heading", "rad"))
PAGE = "# Title\n\n<!-- begin: one -->\nold\n<!-- end: one -->\n\nprose\n\n<!-- begin: two -->\n<!-- end: two -->\n"


@pytest.fixture
def pages(monkeypatch):
    """The module that the scripts share, found as they find it: beside them."""
    monkeypatch.syspath_prepend(DOCS / "_generate")
    return importlib.import_module("pages")


@pytest.fixture
def convergence(monkeypatch, tmp_path):
    """The script of docs/convergence.md, turned to an empty page and a folder of campaigns of their own."""
    monkeypatch.syspath_prepend(DOCS / "_generate")
    script = importlib.import_module("generate_convergence")
    monkeypatch.setattr(script, "PAGE", tmp_path / "convergence.md")
    monkeypatch.setattr(script, "README", tmp_path / "README.md")
    monkeypatch.setattr(script, "CAMPAIGNS", tmp_path / "campaigns")
    script.README.write_text("<!-- begin: laws -->\n<!-- end: laws -->")
    markers = ("families", "quick_families", script.MAPS, *script.FOLDERS)
    script.PAGE.write_text("\n".join(f"<!-- begin: {name} -->\n<!-- end: {name} -->" for name in markers))
    return script


def between(page: Path, marker: str) -> str:
    """Returns what stands between a pair of markers."""
    found = re.search(f"<!-- begin: {marker} -->\n(.*?)<!-- end: {marker} -->", page.read_text(), re.DOTALL)
    assert found is not None
    return found.group(1)


def tables(text: str) -> list[list[dict[str, str]]]:
    """Returns the Markdown tables of a text, their rows by their headings."""
    found = []
    for block in re.findall(r"(?:^\|.*\|\n?)+", text, re.MULTILINE):
        header, _, *rows = [[cell.strip() for cell in line.strip("| \n").split(" | ")] for line in block.splitlines()]
        found.append([dict(zip(header, row, strict=True)) for row in rows])
    return found


def measured(script, name: str, laws: tuple[str, ...], count: int = 40, **draw):
    """Writes the table of a campaign that was made up, and returns its cells."""
    cells = campaign_cells(campaign_starts(laws, FAMILIES, count, **draw))
    folder = script.CAMPAIGNS / name
    folder.mkdir(parents=True)
    cells.to_csv(folder / "cells.csv", index=False, float_format="%.6g")
    return cells


@pytest.mark.parametrize("script", sorted(path.stem for path in (DOCS / "_generate").glob("generate_*.py")))
def test_every_script_finds_what_it_takes_from_the_package(monkeypatch, script):
    monkeypatch.syspath_prepend(DOCS / "_generate")
    assert callable(importlib.import_module(script).main)


# -- markers ----------------------------------------------------------------------------------------


def test_what_stands_between_markers_is_replaced_and_nothing_else(pages, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    pages.fill(page, {"one": r"new \1", "two": "| a |"})
    assert page.read_text() == PAGE.replace("old", r"new \1").replace("two -->\n", "two -->\n| a |\n", 1)
    once = page.read_text()
    pages.fill(page, {"one": r"new \1", "two": "| a |"})
    assert page.read_text() == once


@pytest.mark.parametrize("text", ["nothing", PAGE + PAGE, PAGE.replace("end: two", "end: too")])
def test_a_page_without_its_markers_is_refused_and_left_alone(pages, tmp_path, text):
    page = tmp_path / "page.md"
    page.write_text(text)
    with pytest.raises(ValueError, match=r"page\.md: expected one <!-- begin: (one|two) -->"):
        pages.fill(page, {"one": "new", "two": "new"})
    assert page.read_text() == text


def test_tables_are_markdown(pages):
    assert pages.table(["a", "b"], [["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


# -- convergence ------------------------------------------------------------------------------------


def test_what_was_not_measured_is_said_to_be_missing(convergence):
    measured(convergence, "mujoco", LAWS[:1])
    convergence.main()
    for name in convergence.FOLDERS:
        text = between(convergence.PAGE, name)
        assert (f"Not measured yet: `docs/campaigns/{name}/cells.csv` is missing" in text) == (name != "mujoco")
        assert bool(tables(text)) == (name == "mujoco")


def test_a_law_alone_has_every_figure_of_its_table(convergence):
    cells = measured(convergence, "ideal", LAWS[:1], share=0.9)
    convergence.main()
    text = between(convergence.PAGE, "ideal")
    assert "`universal`: 360 of 400 runs converge." in text
    assert "Ideal model, 40 starts for every law and reference; converged: within 10 mm and 20 mrad" in text
    rows = tables(text)[0]
    assert [row["reference"] for row in rows] == list(FAMILIES)
    for row, (_, cell) in zip(rows, cells.iterrows(), strict=True):
        assert row["converged"] == "36 of 40"
        assert row["95 % interval [%]"] == "[76.9, 96]"
        times = [float(value) for value in re.findall(r"\d+", row["settled (99 %, last)"])]
        expected = [cell["settling_median"], cell["settling_p99"], cell["settling_max"]]
        assert times == [round(value) for value in expected]
        assert row["switches"] == f"{cell['switches_median']:.0f} ({cell['switches_max']:.0f})"
        assert row["worst start"] == str(cell["worst_start"])


@pytest.mark.slow
def test_many_laws_are_compared_first_and_folded_away(convergence):
    cells = measured(convergence, "rivals_ideal", LAWS, lost=0.2)
    convergence.main()
    text = between(convergence.PAGE, "rivals_ideal")
    shares, errors, times, *each, gains = tables(text)
    for table in (shares, errors, times):
        assert [next(iter(row.values())) for row in table] == list(FAMILIES)
        assert [heading.strip("`") for heading in table[0]][1:] == list(LAWS)
    for _, cell in cells.iterrows():
        row = FAMILIES.index(cell["family"])
        said = shares[row][f"`{cell['law']}`"]
        assert float(said.split(" %")[0]) == pytest.approx(100 * cell["share"])
        assert (f", {cell['lost']} lost" in said) == (cell["lost"] > 0)
        assert (times[row][f"`{cell['law']}`"] == "-") == (cell["converged"] == 0)
        late = [convergence.quantity(cell[f"late_{name}_median"], unit) for name, unit in SIZES]
        assert errors[row][f"`{cell['law']}`"] == ", ".join(late)
    assert text.count("<details>") == len(LAWS) + 1
    assert [len(table) for table in each] == [len(FAMILIES)] * len(LAWS)
    assert len(gains) == len(cells)
    assert gains[0]["gains"] == "`k_x=1.2 k_y=0.5`"


def test_only_laws_that_were_tuned_have_gains(convergence):
    cells = measured(convergence, "ideal", LAWS[:2])
    cells.assign(gains=np.where(cells["law"] == LAWS[1], "k=1", "")).to_csv(
        convergence.CAMPAIGNS / "ideal" / "cells.csv", index=False
    )
    convergence.main()
    gains = tables(between(convergence.PAGE, "ideal"))[-1]
    assert [(row["law"], row["gains"]) for row in gains] == [(f"`{LAWS[1]}`", "`k=1`")] * len(FAMILIES)


def test_only_figures_that_are_there_are_shown(convergence):
    measured(convergence, "ideal", LAWS[:1])
    figures = convergence.CAMPAIGNS / "ideal" / "figures"
    figures.mkdir()
    for name in ("share_map.png", "start_map_universal.png", "start_map_universal.pdf"):
        (figures / name).touch()
    convergence.main()
    shown = re.findall(r"!\[.+\]\((.+)\)", between(convergence.PAGE, "ideal"))
    assert shown == [f"campaigns/ideal/figures/{name}.png" for name in ("share_map", "start_map_universal")]


def test_a_campaign_over_grids_is_shown_by_its_maps(convergence):
    cells = measured(convergence, convergence.MAPS, LAWS[:3])
    assert set(cells["law"]) == set(LAWS[:3])
    grids = np.where(cells["family"].isin(FAMILIES[:4]), "one", "two")
    cells.assign(grid=grids).to_csv(convergence.CAMPAIGNS / convergence.MAPS / "cells.csv", index=False)
    convergence.main()
    text = between(convergence.PAGE, convergence.MAPS)
    assert text.startswith("Ideal model, 40 starts of each point; converged: within 10 mm and 20 mrad.")
    shown = re.findall(r"!\[.+?\]\((.+?)\)", text)
    assert shown == [
        f"campaigns/{convergence.MAPS}/figures/grid_map_{grid}_{law}.png" for grid in ("one", "two") for law in LAWS[:3]
    ]
    shares = tables(text)[-1]
    for row, law in zip(shares, LAWS, strict=False):
        for grid in ("one", "two"):
            own = cells[(cells["law"] == law) & (grids == grid)]
            expected = own["converged"].sum() / own["starts"].sum()
            assert float(row[grid].removesuffix(" %")) == pytest.approx(100 * expected, abs=0.06)


def test_every_bundled_reference_is_described(convergence):
    convergence.main()
    (rows,), (quick,) = (tables(between(convergence.PAGE, name)) for name in ("families", "quick_families"))
    assert [row["reference"] for row in rows] == [*BUNDLED, "random"]
    assert [row["reference"] for row in quick] == [*QUICK, "random-walk"]
    park = next(row for row in rows if row["reference"] == "park")
    assert park["u_x [m/s^2]"] == "0.5 until 2 s, 0 until 20 s, -0.5 until 22 s, then 0"


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (2.34, "2.3 m"), (12.3, "12 m"), (0.00892, "8.9 mm"), (0.01, "10 mm"), (4e-6, "4.0 um"), (9.97e-4, "1.0 mm"),
        (2e-10, "< 1 nm"), (0.0, "< 1 nm"), (np.nan, "-"), (np.inf, "-"), (0.1, "100 mm"),
    ],
)  # fmt: skip
def test_lengths_are_read_in_the_unit_that_suits_them(convergence, value, said):
    assert convergence.quantity(value, "m") == said


def test_a_wheel_without_load_has_no_utilisation(convergence):
    assert convergence.utilisation(0.4321) == "43 %"
    assert convergence.utilisation(np.inf) == "no load"


def test_the_readme_has_the_shares_of_every_law(convergence):
    convergence.main()
    assert "Not measured yet" in between(convergence.README, "laws")
    ideal = measured(convergence, "ideal", LAWS[:2])
    wheels = measured(convergence, "rivals_mujoco", LAWS[1:2])
    convergence.main()
    (rows,) = tables(between(convergence.README, "laws"))
    assert [row["law"] for row in rows] == [f"`{law}`" for law in LAWS[:2]]
    for row, law in zip(rows, LAWS, strict=False):
        cells = ideal[ideal["law"] == law]
        whole = cells[cells["converged"] == cells["starts"]]["family"]
        assert row["every start arrives at"] == (", ".join(whole) if len(whole) < len(cells) else "all") or "none"
        share, count = re.fullmatch(r"([\d.]+) % of (\d+)", row["of all starts, ideal"]).groups()
        assert int(count) == cells["starts"].sum()
        assert float(share) == pytest.approx(100 * cells["converged"].sum() / cells["starts"].sum(), abs=0.06)
    assert rows[0]["on wheels"] == "-"
    assert rows[1]["on wheels"].endswith(f"% of {wheels['starts'].sum()}")


# -- curves -----------------------------------------------------------------------------------------


def test_curves_have_every_reference_at_every_place_and_ask_a_law_ahead_by_the_delay(monkeypatch):
    monkeypatch.syspath_prepend(DOCS / "_generate")
    script = importlib.import_module("generate_curves")
    campaign = script.base(2)
    assert len(campaign.family_names) == 32
    for panel in script.PANELS:
        asked = list(script.tasks(panel, campaign))
        assert [task.place for task in asked] == [place for place in range(len(panel.values)) for _ in range(32)]
        for task in asked[::32]:
            set_to = task.campaign.control_rate, task.campaign.delay, 1e3 * task.campaign.noise.position
            expected = dict(zip(("control rate", "delay", "noise"), (100, 0, 0), strict=True))
            assert set_to == tuple((expected | {panel.title: panel.values[task.place]}).values())
            ahead = {law: section.delay_periods for law, section in task.campaign.laws.items()}
            assert all(periods == (task.campaign.delay if "ahead" in law else 0) for law, periods in ahead.items())
    assert [len(panel.laws) for panel in script.PANELS] == [4, 5, 4]
