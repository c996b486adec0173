"""The report of the fidelity suite: shares of budgets, sentences, a row for every finding."""

from __future__ import annotations

import math
from typing import Any

import pytest

from elements import Elements
from nhtrack.report.page import render_page
from nhtrack.studies.fidelity.bench import Finding
from nhtrack.studies.fidelity.report import fidelity_page, fidelity_verdicts, used
from nhtrack.studies.fidelity.suite import CHECKS, GROUPS, command, tasks
from reports import HOSTILE


def finding(value: float = 2e-10, budget: float = 1e-9, **rest: Any) -> dict[str, Any]:
    told = {"robot": "nh_mini", "check": "drift at rest", "unit": "m/s", "cause": "rounding", "group": "Rest"} | rest
    return Finding(value=value, budget=budget, **told).row


def page_of(*rows: dict[str, Any]) -> Elements:
    return Elements(render_page(fidelity_page(rows, "nhtrack fidelity", {"nhtrack": "0"})))


@pytest.mark.parametrize(
    ("value", "budget", "sense", "share"),
    [
        (2e-10, 1e-9, "at most", 0.2),
        (3e-9, 1e-9, "at most", 3.0),
        (2.0, 1.6, "at least", 0.8),
        (1.0, 1.6, "at least", 1.6),
        (0, 0, "at most", 0.0),
        (1, 0, "at most", None),
        (0, 0.9, "at least", None),
        (math.inf, 1.0, "at most", None),
        (math.nan, 1.0, "at most", None),
    ],
)
def test_a_figure_uses_a_share_of_its_budget(value: float, budget: float, sense: str, share: float | None) -> None:
    row = finding(value, budget, sense=sense)
    assert used(row) == (None if share is None else pytest.approx(share))
    assert row["ok"] == (share is not None and share <= 1)


def test_every_finding_has_a_row_under_its_group() -> None:
    page = page_of(finding(), finding(2.0, 1.6, sense="at least", check="order", unit="1", group="Steps"))
    assert page.texts["h3"] == ["Rest", "Steps"]
    assert page.rows[1] == ["drift at restrounding", "nh_mini", "2e-10 m/s", "≤ 1e-09 m/s", "20 %", "kept"]
    assert page.rows[3] == ["orderrounding", "nh_mini", "2", "≥ 1.6", "80 %", "kept"]


def test_what_is_not_finite_is_broken_beyond_all_bounds() -> None:
    assert page_of(finding(1e-6)).rows[1][4:] == ["1e+03 times", "broken"]
    page = page_of(finding(math.inf, cause="diverged: tipped over"))
    assert page.rows[1][2:6] == ["-", "≤ 1e-09 m/s", "beyond", "broken"]


def test_budgets_kept_and_broken_are_told() -> None:
    one, other = finding(), finding(9e-10, check="creep", robot="burger")
    assert fidelity_verdicts([one, other]) == [
        "All 2 budgets are kept by 2 robots, nh_mini and burger.",
        "Of those kept, creep of burger is nearest to its budget and uses 90 % of it.",
    ]
    bad, odd = finding(1.0, cause="somebody pushed it"), finding(1.0, check="energy", explained=True)
    told = fidelity_verdicts([one, bad, odd])
    assert told[0] == "1 of 3 budgets are kept by robot nh_mini."
    assert told[1] == "One budget is broken for a reason that docs/fidelity.md gives."
    assert "nh_mini, drift at rest: 1 m/s where the budget is at most 1e-09 m/s; somebody pushed it." in told
    alarms = [text for text in page_of(one, bad, odd).texts["p"] if "nothing explains" in text]
    assert alarms == ["One budget is broken, and nothing explains it."]
    assert not [text for text in page_of(one, odd).texts["p"] if "nothing explains" in text]


def test_names_stay_text() -> None:
    page = page_of(finding(robot=HOSTILE, check=HOSTILE, cause=HOSTILE, group=HOSTILE))
    assert [tag for tag, _ in page.found].count("script") == 2  # numbers and the page's own
    assert page.rows[1][:2] == [HOSTILE + HOSTILE, HOSTILE]


def test_the_command_measures_the_same() -> None:
    assert command(tasks(["burger"])) == "nhtrack fidelity --robot burger"
    assert command(tasks(["a b.xml"], ["rest"])) == "nhtrack fidelity --robot 'a b.xml' --check rest"


def test_every_check_has_a_group() -> None:
    assert {check.__module__ for check in CHECKS.values()} == {module.__name__ for module in GROUPS}
