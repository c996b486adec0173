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
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.paper.run import EXAMPLES
from nhtrack.terminal import app
from recordings import synthetic_recording

VERSIONS = {"nhtrack": "0", "mujoco": "0"}
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
                for missing in set(wheels) - set(run.dataset):  # formulas of the ideal backend leave them out
                    run.dataset[missing] = run["wheel_speed"] * np.nan
                run.save(folder / "recordings" / f"{name}-{backend}.nc")
    return folder


@pytest.mark.slow
def test_the_page_has_every_example_and_every_figure(recorded: Path, tmp_path: Path) -> None:
    result = invoke("--from", recorded, "--out", "page", "--pdf")
    assert result.exit_code == 0, result.output
    page = (tmp_path / "page" / "paper.md").read_text(encoding="utf-8")
    assert re.findall(r"^## Example (\d)", page, re.MULTILINE) == ["1", "2", "3", "4", "5"]
    linked = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)
    assert linked == [f"paper/{name}.png" for name in FIGURES]
    for link in linked:
        image = iio.imread(tmp_path / "page" / link)
        assert np.std(image) > 1
        assert (tmp_path / "page" / link).with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    for robot in ("| robot3 | pi | -30 | -5 | 0 | 0 |", "| robot3 | pi | -70 | -10 | 0 | 0 |"):
        assert robot in page
    assert "Written by `nhtrack paper`" in page
    assert not (tmp_path / "page" / "recordings").exists()


@pytest.mark.slow
def test_the_report_has_every_example_and_every_figure(recorded: Path, tmp_path: Path) -> None:
    result = invoke("--from", recorded, "--out", "page")
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith("wrote page/report.html\n")
    page = Elements((tmp_path / "page" / "report.html").read_text(encoding="utf-8"))
    ids = [attributes["id"] for tag, attributes in page.found if tag == "section"]
    assert ids[2:-1] == [f"example-{number}" for number in EXAMPLES]
    sources = [str(attributes["src"]) for tag, attributes in page.found if tag == "img"]
    drawn = [base64.b64decode(source.removeprefix("data:image/png;base64,")) for source in sources]
    assert drawn == [(tmp_path / "page" / "paper" / f"{name}.png").read_bytes() for name in FIGURES]
    rows = {row[2]: row for row in page.rows if len(row) == 9}
    assert set(rows) == {"scenario", *(name for example in EXAMPLES.values() for name in example.scenarios)}
    assert "nhtrack paper --examples 1,2,3,4,5" in page.texts["pre"]


def test_a_report_can_be_left_out(recorded: Path, tmp_path: Path) -> None:
    only = ("--examples", "5", "--backend", "ideal", "--no-report")
    assert invoke("--from", recorded, "--out", "page", *only).exit_code == 0
    assert not (tmp_path / "page" / "report.html").exists()


@pytest.mark.slow
def test_redrawing_gives_the_same_bytes(recorded: Path, tmp_path: Path) -> None:
    for out in ("one", "two"):
        assert invoke("--from", recorded, "--out", out, "--examples", "3,4", "--pdf").exit_code == 0
    one, two = (sorted(path for path in Path(out).rglob("*") if path.is_file()) for out in ("one", "two"))
    assert [path.relative_to("one") for path in one] == [path.relative_to("two") for path in two]
    assert len(one) == 2 + 2 * 3
    for a, b in zip(one, two, strict=True):
        assert a.read_bytes() == b.read_bytes(), a


def test_some_examples_without_mujoco_and_pdf(recorded: Path, tmp_path: Path) -> None:
    result = invoke("--from", recorded, "--out", "page", "--examples", "5", "--backend", "ideal")
    assert result.exit_code == 0, result.output
    assert {path.name for path in (tmp_path / "page").rglob("*.*")} == {
        "paper.md", "report.html", "example5_trajectories.png",
    }  # fmt: skip
    page = (tmp_path / "page" / "paper.md").read_text(encoding="utf-8")
    assert "## Example 5" in page
    assert "## Example 4" not in page
    assert "| MuJoCo |" not in page
    assert "robot0 -> robot1, robot0 -> robot2, robot1 -> robot3, robot2 -> robot3" in page


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


def test_a_missing_or_partial_recording_is_named(recorded: Path, tmp_path: Path) -> None:
    result = invoke("--from", tmp_path, "--out", "page", "--examples", "4")
    assert result.exit_code == 1
    assert "example4-ideal.nc: no such recording" in result.stderr
    stand_in("example4", "ideal", stop=30.0).save(tmp_path / "recordings" / "example4-ideal.nc")
    result = invoke("--from", tmp_path, "--out", "page", "--examples", "4")
    assert result.exit_code == 1
    assert "example4-ideal.nc: this run is interrupted" in result.stderr
    assert not (tmp_path / "page").exists()


def test_a_folder_with_files_is_not_written_into_unless_told(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "precious").write_text("")
    only = ("--from", recorded, "--out", "page", "--examples", "5", "--backend", "ideal")
    result = invoke(*only)
    assert result.exit_code == 1
    assert "--force" in result.stderr
    assert invoke(*only, "--force").exit_code == 0
    assert (tmp_path / "page" / "precious").exists()


@pytest.mark.slow
def test_the_command_runs_what_it_draws(tmp_path: Path) -> None:
    result = invoke("--examples", "3", "--backend", "ideal")
    assert result.exit_code == 0, result.output
    for name in ("example3_pi", "example3_minus_pi"):
        recording = Recording.load(tmp_path / "runs" / "paper-1" / "recordings" / f"{name}-ideal.nc")
        assert (recording.name, recording.backend, recording.outcome) == (name, "ideal", "completed")
    assert (tmp_path / "runs" / "paper-1" / "paper" / "example3_trajectories.png").stat().st_size > 10_000
