"""The report of the paper's examples: figures of merit from recordings, claims judged by them, sentences."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from elements import Elements
from nhtrack.analysis.metrics import follower_figures, late_rows
from nhtrack.experiment.load import load
from nhtrack.presentation.numbers import quantity
from nhtrack.recording import Recording
from nhtrack.report.page import render_page
from nhtrack.studies.paper.examples import EXAMPLES, Example
from nhtrack.studies.paper.page import page
from nhtrack.studies.paper.report import ExampleSection, WordTable, paper_page, paper_verdicts
from nhtrack.studies.paper.report_sections import CLAIMS, Merit, merit, paper_command, sections
from nhtrack.studies.paper.result import ExampleRuns
from recordings import synthetic_recording
from reports import HOSTILE, whole_recording

SCALE = 1e-9  # relative: sums and square roots of a few numbers


def with_errors(errors: np.ndarray, headings: np.ndarray) -> Recording:
    """Returns a run of one follower with position errors [m] along x and heading errors [rad]."""
    recording = synthetic_recording(1, samples=len(errors))
    recording["error"].values[:, 1] = np.stack([errors, 0 * errors, headings], axis=-1)
    return recording


def test_figures_of_merit_are_the_worst_of_their_times() -> None:
    errors = np.linspace(2.0, 0.0, 101)
    found = merit(with_errors(errors, -0.1 * errors))
    late = late_rows(synthetic_recording(1, samples=101)).start
    assert found == pytest.approx((2.0, errors[late], errors[2 * late - 101], 0.1 * errors[late], False), rel=SCALE)
    assert merit(with_errors(1e-4 * errors, 0.02 * errors)).settled
    assert not merit(with_errors(0.0 * errors, errors)).settled


@pytest.mark.parametrize(
    ("late", "settled", "mark"),
    [
        (0.001, True, "reached"),
        (0.001, False, "near"),
        (0.049, False, "near"),
        (0.051, False, "missed"),
        (np.nan, False, "missed"),
    ],
)
def test_claims_are_judged_by_what_is_left(late: float, settled: bool, mark: str) -> None:
    assert Merit(1.0, late, 1.0, 0.0, settled).mark == mark


def run_of(name: str, backend: str) -> Recording:
    """Returns a run of formulas that carries a scenario of the paper."""
    scenario = load(f"paper/{name}")
    attributes = {"name": name, "scenario": scenario.model_dump(mode="json")}
    recording = whole_recording(len(scenario.followers), samples=101, **attributes)
    return Recording(recording.dataset.assign_attrs(backend=backend))


def runs_of(example: Example, *, wheels: bool = True) -> ExampleRuns:
    on_wheels, ideal = ({name: run_of(name, each) for name in example.scenarios} for each in ("mujoco", "ideal"))
    return ExampleRuns(example, on_wheels if wheels else {}, ideal)


@pytest.mark.slow
def test_the_page_tells_the_worst_follower() -> None:
    runs = runs_of(EXAMPLES[5])
    ((name, ideal),) = runs.ideal.items()
    ideal["error"].values[:, 1:, 2] *= [1.0, 3.0, 2.0]
    late = [f["late_heading_error"] for f in follower_figures(ideal).values()]
    assert max(late) == late[1]
    (row,) = re.findall(rf"\| \[{name}\].*", page([runs], "paper"))
    assert row.split(" | ")[3].startswith(f"{quantity(max(late), 'rad')} / ")


def test_an_example_is_told_from_its_runs() -> None:
    runs = runs_of(EXAMPLES[3])
    for name, turn in (("example3_pi", -np.pi), ("example3_minus_pi", np.pi)):
        recording = runs.wheels[name]
        led = recording["leader_pose"].values[:, 1, 2]
        recording["pose"].values[:, 1, 2] = led + np.linspace(-turn, 0.0, len(led))
    (section,) = sections([runs], Path("paper"))
    told = " ".join(section.verdicts)
    assert "In example3_pi the follower turns clockwise by 1 pi." in told
    assert "In example3_minus_pi the follower turns anticlockwise by 1 pi." in told
    assert [row[0] for row in section.merits] == ["example3_pi", "example3_minus_pi"]
    found = merit(runs.wheels["example3_pi"])
    scale = runs.wheels["example3_pi"].length_scale
    within = re.search(r"In example3_pi followers (?:do not )?settle within .*?: they are within ([\d.]+) mm", told)
    assert within is not None
    assert float(within[1]) == pytest.approx(1e3 * found.late / scale, rel=5e-3)
    assert section.mark == found.mark


def test_an_error_that_no_longer_shrinks_is_told() -> None:
    recording = runs_of(EXAMPLES[1]).ideal["example1"]
    for tail, told in ((np.full(30, 0.1), "has stopped shrinking"), (0.1 * 0.8 ** np.arange(30), "still shrinks")):
        recording["error"].values[-30:, 1, :2] = np.stack([tail, 0 * tail], axis=-1)
        (section,) = sections([ExampleRuns(EXAMPLES[1], {}, {"example1": recording})], Path("paper"))
        assert told in section.verdicts[0]


@pytest.mark.slow
def test_a_report_without_wheels_speaks_of_none() -> None:
    runs = runs_of(EXAMPLES[5], wheels=False)
    (section,) = sections([runs], Path("paper"))
    assert section.merits[0][3] == section.merits[0][5] == section.merits[0][6] == "-"
    assert "Wheels" not in " ".join(section.verdicts)
    assert paper_command([runs]) == "nhtrack paper --examples 5 --backend ideal"
    assert paper_command([runs_of(EXAMPLES[1])]) == "nhtrack paper --examples 1"


def test_every_example_has_a_claim() -> None:
    assert set(CLAIMS) == set(EXAMPLES)


def section(number: int, mark: str, text: str = "text") -> ExampleSection:
    table = WordTable(text, (text, text), [(text, text)])
    return ExampleSection(number, text, text, text, mark, [text], [], [[text] * 7], [table], [text])


def test_examples_are_summed_up() -> None:
    told = paper_verdicts([section(1, "near"), section(2, "reached"), section(3, "near")])
    assert told[0].startswith("In Example 2 it is as claimed")
    assert told[1].startswith("In Examples 1 and 3 followers come near")


def test_texts_stay_text() -> None:
    page = Elements(render_page(paper_page([section(1, "near", HOSTILE)], HOSTILE, {HOSTILE: HOSTILE})))
    assert [tag for tag, _ in page.found].count("script") == 2
    assert page.rows[-1] == [HOSTILE] * 2
