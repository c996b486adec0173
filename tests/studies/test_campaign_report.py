"""The report of a campaign: shares of its tables, distributions, starts that are left out, sentences."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaign_tables import FAMILIES, HEADING_LIMIT, LAWS, POSITION_LIMIT, campaign_starts
from elements import Elements
from nhtrack.config.campaign import Campaign
from nhtrack.config.documentation import json_schema
from nhtrack.experiment.load import load_campaign
from nhtrack.presentation.numbers import percent
from nhtrack.report.page import render_page
from nhtrack.studies.campaign.report import (
    CURVE_POINTS,
    DISTRIBUTIONS,
    LEAST_STARTS,
    MOST_STARTS,
    Account,
    campaign_page,
    campaign_payload,
    campaign_verdicts,
    distribution,
    kept_rows,
)
from nhtrack.studies.campaign.tables import cells_of
from reports import HOSTILE

DIGITS = 5e-5  # five significant digits: rounding moves a number by at most half a unit of the last one


def tree(**changes: Any) -> dict[str, Any]:
    return load_campaign("campaign/rivals", []).model_dump(mode="json") | changes


def cells(runs: pd.DataFrame) -> pd.DataFrame:
    limits = {"position_limit": POSITION_LIMIT, "heading_limit": HEADING_LIMIT}
    return cells_of(runs, {}, backend="ideal", **limits)


def page_of(runs: pd.DataFrame, **changes: Any) -> str:
    worst = {law: f"worst/{law}.yaml" for law in runs["law"].unique()}
    account = Account(tree(**changes), {"nhtrack": "0"}, worst, json_schema(Campaign))
    return render_page(campaign_page(runs, cells(runs), account))


@pytest.fixture(scope="module")
def runs() -> pd.DataFrame:
    return campaign_starts(LAWS[:3], FAMILIES[:4], count=60, lost=0.5)


def test_the_table_has_the_share_of_every_law_and_reference(runs: pd.DataFrame) -> None:
    table = Elements(page_of(runs))
    rows = [row for row in table.rows if row[0] in LAWS]
    assert [row[0] for row in rows] == list(LAWS[:3])
    expected = cells(runs).set_index(["law", "family"])
    for row in rows:
        for family, text in zip(FAMILIES[:4], row[1:], strict=True):
            cell = expected.loc[(row[0], family)]
            assert text == percent(cell["share"]) + f"{percent(cell['share_low'])} to {percent(cell['share_high'])}"
    titles = [str(attributes["title"]) for _, attributes in table.found if attributes.get("class") == "cell"]
    assert len(titles) == 12
    assert titles[0].startswith("universal against rest: 60 of 60 starts arrive (100 %; 95 % interval ")
    assert expected.loc[("universal", "rest"), "converged"] == 60


def test_distributions_are_those_of_the_runs(runs: pd.DataFrame) -> None:
    data = json.loads(json.dumps(campaign_payload(runs, tree()), allow_nan=False))
    part = runs[(runs["law"] == LAWS[1]) & (runs["family"] == FAMILIES[3])]
    curves = data["curves"][1][3]
    for figure, curve in zip(DISTRIBUTIONS, curves, strict=True):
        values = np.sort(part[figure.column].to_numpy(dtype=float))
        values = values[np.isfinite(values)]
        assert len(values) > 0
        np.testing.assert_allclose(curve["x"], values, rtol=DIGITS)
        np.testing.assert_allclose(curve["y"], 100 * np.arange(1, len(values) + 1) / 60, rtol=DIGITS)


def test_runs_without_a_figure_count_as_beyond_all_others() -> None:
    curve = distribution(pd.Series([3.0, math.nan, 1.0, math.inf]), logarithmic=False)
    assert curve == {"x": [1.0, 3.0], "y": [25.0, 50.0]}
    assert distribution(pd.Series([math.nan]), logarithmic=True) == {"x": [], "y": []}
    assert distribution(pd.Series([0.0]), logarithmic=True)["x"] == [1e-12]
    assert len(distribution(pd.Series(np.arange(10_000.0)), logarithmic=False)["x"]) == CURVE_POINTS


def test_starts_that_did_not_arrive_are_kept_first() -> None:
    converged = np.ones(1000, dtype=bool)
    converged[[3, 500, 999]] = False
    rows = kept_rows(converged, 100)
    assert len(rows) == 100
    assert {0, 3, 500, 998, 999} <= set(rows.tolist())
    assert kept_rows(converged, 1000).tolist() == list(range(1000))
    many = kept_rows(~converged, 100)  # three arrive: they all stay
    assert {3, 500, 999} <= set(many.tolist())
    assert len(many) == 100
    half = kept_rows(np.arange(1000) % 2 == 0, 100)
    assert (half % 2).sum() == 50


@pytest.mark.slow
def test_what_is_left_out_is_told() -> None:
    runs = campaign_starts(LAWS[:1], FAMILIES[:2], count=20_000)
    page = Elements(page_of(runs))
    starts = json.loads(page.texts["script"][0])["starts"][0]
    assert [len(each["start"]) for each in starts] == [MOST_STARTS // 2] * 2
    assert MOST_STARTS // 2 > LEAST_STARTS
    assert f"show {MOST_STARTS} of them, those that did not arrive first" in " ".join(page.texts["p"])


def test_laws_are_told_apart_in_words() -> None:
    runs = pd.concat([
        campaign_starts(("one",), ("rest", "line"), count=20, share=1.0),
        campaign_starts(("two",), ("rest",), count=20, share=0.5, lost=1.0),
        campaign_starts(("two",), ("line",), count=20, share=0.0),
    ])  # fmt: skip
    told = campaign_verdicts(runs, cells(runs), tree())
    assert told[0].startswith("2 laws against 2 references, 80 runs on the ideal integrator.")
    assert "stays within 10 mm and 20 mrad of its place until the end, at least over the last 15 s of 80 s" in told[0]
    assert told[1:] == [
        "one arrives from every start, against every reference: 40 of 40.",
        "two arrives from 10 of 40 starts: 10 of 20 against rest; none against line.",
        "two lost 10 followers: each ran away, tipped over, or was commanded no number.",
    ]


def test_friction_beyond_the_floor_s_is_told() -> None:
    runs = campaign_starts(("one",), ("rest",), count=4, share=1.0)
    runs["peak_utilisation"] = [0.2, 1.0, 3.0, math.inf]
    told = campaign_verdicts(runs, cells(runs), tree())
    assert "one asked for more friction than the floor has in 3 of 4 runs." in told
    title = next(a["title"] for _, a in Elements(page_of(runs)).found if a.get("class") == "cell")
    assert title is not None
    assert "Friction utilisation up to infinity: a wheel bears no load." in title


def test_a_reference_that_a_law_was_not_run_against_is_blank() -> None:
    parts = campaign_starts(("one",), ("rest", "line"), count=5), campaign_starts(("two",), ("line",), count=5)
    runs = pd.concat(parts)
    assert campaign_payload(runs, tree())["starts"][1][0] is None
    assert ["two", "not run"] == next(row for row in Elements(page_of(runs)).rows if row[0] == "two")[:2]


def test_no_text_of_a_user_is_markup(runs: pd.DataFrame) -> None:
    hostile = runs.assign(law=HOSTILE, family="</title><img src=x>")
    page = Elements(page_of(hostile, description=HOSTILE))
    tags = [tag for tag, _ in page.found]
    assert tags.count("script") == 3
    assert "img" not in tags
    assert json.loads(page.texts["script"][0])["laws"][0]["name"] == HOSTILE
