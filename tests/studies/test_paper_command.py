"""`nhtrack paper` from the outside."""

from __future__ import annotations

import base64
import re
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from elements import Elements
from nhtrack.cli import app
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.simulation.columns import SCALARS
from nhtrack.studies.paper.examples import EXAMPLES
from recordings import synthetic_recording

VERSIONS = {"nhtrack": "0", "mujoco": "0"}
FIFTH = ("--examples", 5, "--backend", "ideal")
FIGURES = [figure.name for example in EXAMPLES.values() for figure in example.figures]


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["paper", *(str(argument) for argument in arguments)])


def stand_in(name: str, backend: str, **changes: object) -> Recording:
    """Returns a run of formulas that carries a scenario of the paper."""
    scenario = load(f"paper/{name}", [f"backend={backend}"])
    similarity = scenario.similarity
    return synthetic_recording(
        len(scenario.followers),
        backend=backend,
        samples=61,
        name=name,
        scenario=scenario.model_dump(mode="json"),
        length_scale=similarity.length,
        time_scale=similarity.time_scale,
        versions=VERSIONS,
        torque_limit=0.03,
        **changes,
    )


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder as `nhtrack paper` leaves it, of stand-ins."""
    folder = tmp_path_factory.mktemp("recorded")
    for example in EXAMPLES.values():
        for name in example.scenarios:
            for backend in ("mujoco", "ideal"):
                run = stand_in(name, backend)
                run.dataset["torque_saturation"] = run["wheel_speed"] * 0
                wheels = ("friction_utilisation", "friction_utilisation_predicted", "lateral_slip", "wheel_load")
                unknown = run["wheel_speed"] * np.nan
                for missing in set(wheels) - set(run.dataset):  # formulas of the ideal backend leave them out
                    one = missing in SCALARS
                    run.dataset[missing] = unknown.isel(wheel=0, drop=True) if one else unknown
                run.save(folder / "recordings" / f"{name}-{backend}.nc")
    return folder


@pytest.fixture(scope="module")
def fifth(recorded: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns what is drawn of one example without MuJoCo."""
    folder = tmp_path_factory.mktemp("drawn") / "page"
    result = invoke("--from", recorded, "--out", folder, *FIFTH)
    assert result.exit_code == 0, result.output
    return folder


@pytest.mark.slow
def test_page_and_report_have_every_example_and_every_figure(recorded: Path, tmp_path: Path) -> None:
    result = invoke("--from", recorded, "--out", "page")
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith("wrote page/report.html\n")
    page = (tmp_path / "page" / "paper.md").read_text(encoding="utf-8")
    assert re.findall(r"^## Example (\d)", page, re.MULTILINE) == ["1", "2", "3", "4", "5"]
    linked = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)
    assert linked == [f"paper/{name}.png" for name in FIGURES]
    assert all(np.std(iio.imread(tmp_path / "page" / link)[::20]) > 1 for link in linked)
    for robot in ("| robot3 | pi | -30 | -5 | 0 | 0 |", "| robot3 | pi | -70 | -10 | 0 | 0 |"):
        assert robot in page
    assert "Written by `nhtrack paper`" in page
    assert not (tmp_path / "page" / "recordings").exists()

    report = Elements((tmp_path / "page" / "report.html").read_text(encoding="utf-8"))
    ids = [attributes["id"] for tag, attributes in report.found if tag == "section"]
    assert ids[2:-1] == [f"example-{number}" for number in EXAMPLES]
    sources = [str(attributes["src"]) for tag, attributes in report.found if tag == "img"]
    shown = [base64.b64decode(source.removeprefix("data:image/png;base64,")) for source in sources]
    assert shown == [(tmp_path / "page" / link).read_bytes() for link in linked]
    rows = {row[2]: row for row in report.rows if len(row) == 9}
    assert set(rows) == {"scenario", *(name for example in EXAMPLES.values() for name in example.scenarios)}
    assert "nhtrack paper --examples 1,2,3,4,5" in report.texts["pre"]


@pytest.mark.slow
def test_some_examples_without_mujoco_and_pdf(fifth: Path) -> None:
    assert {path.name for path in fifth.rglob("*.*")} == {"paper.md", "report.html", "example5_trajectories.png"}
    page = (fifth / "paper.md").read_text(encoding="utf-8")
    assert "## Example 5" in page
    assert "## Example 4" not in page
    assert "| MuJoCo |" not in page
    assert "robot0 -> robot1, robot0 -> robot2, robot1 -> robot3, robot2 -> robot3" in page


@pytest.mark.slow
def test_figures_are_for_print_if_asked_and_a_report_can_be_left_out(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr("nhtrack.plots.files.save_figure", lambda figure, stem, *, pdf: asked.append(pdf) or [stem])
    assert invoke("--from", recorded, "--out", "page", *FIFTH, "--pdf", "--no-report").exit_code == 0
    assert asked == [True]
    assert [path.name for path in (tmp_path / "page").iterdir()] == ["paper.md"]


@pytest.mark.slow
def test_a_folder_with_files_is_written_into_if_told_and_gets_the_same_bytes(
    recorded: Path, fifth: Path, tmp_path: Path
) -> None:
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "precious").write_text("")
    result = invoke("--from", recorded, "--out", "page", *FIFTH)
    assert result.exit_code == 1
    assert "--force" in result.stderr
    assert invoke("--from", recorded, "--out", "page", *FIFTH, "--force").exit_code == 0
    assert (tmp_path / "page" / "precious").exists()
    for path in fifth.rglob("*.*"):
        assert (tmp_path / "page" / path.relative_to(fifth)).read_bytes() == path.read_bytes(), path


@pytest.mark.parametrize(
    "arguments",
    [
        ("--examples", "6"),
        ("--examples", "one"),
        ("--examples", ""),
        ("--examples", "1,,2"),
        ("--backend", "gazebo"),
        ("--from", "nowhere"),
    ],
)
def test_a_wrong_command_line_exits_2(arguments: tuple[str, ...], tmp_path: Path) -> None:
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_example_is_told_the_known_ones() -> None:
    assert "no Example 7" in " ".join(invoke("--examples", "7").stderr.split())


@pytest.mark.slow
def test_a_missing_or_partial_recording_is_named(tmp_path: Path) -> None:
    result = invoke("--from", tmp_path, "--out", "page", "--examples", "4")
    assert result.exit_code == 2
    assert "example4-ideal.nc: no such recording" in result.stderr
    stand_in("example4", "ideal", stop=30.0).save(tmp_path / "recordings" / "example4-ideal.nc")
    result = invoke("--from", tmp_path, "--out", "page", "--examples", "4")
    assert result.exit_code == 2
    assert "example4-ideal.nc: this run is interrupted" in result.stderr
    assert not (tmp_path / "page").exists()


@pytest.mark.slow
def test_the_command_runs_what_it_draws(tmp_path: Path) -> None:
    result = invoke("--examples", "3", "--backend", "ideal", "--no-report")
    assert result.exit_code == 0, result.output
    for name in ("example3_pi", "example3_minus_pi"):
        recording = Recording.load(tmp_path / "runs" / "paper-1" / "recordings" / f"{name}-ideal.nc")
        assert (recording.name, recording.backend, recording.outcome) == (name, "ideal", "completed")
    assert (tmp_path / "runs" / "paper-1" / "paper" / "example3_trajectories.png").stat().st_size > 10_000
