"""The files of examples/ run, and pages that show them show them as they are."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
LAW = EXAMPLES / "write_a_law"
ROBOT = EXAMPLES / "bring_a_robot"
PAGES = {
    "python.md": sorted(EXAMPLES.glob("*.py")),
    "own_law.md": sorted(LAW.glob("*.*")),
    "own_robot.md": sorted(ROBOT.glob("*.*")),
}
FILES = [(page, path) for page, paths in PAGES.items() for path in paths]

# What each script prints of what it claims.
PRINTED = {
    "quickstart": r"0\.000\d m from the leader, \d\.\de-0[78] m from the ideal twin",
    "run_a_scenario": r"friction used: \d\d\.\d%\nleader: the 12 s of the run .*\nthe same run: True\n"
    r".*hello\.yaml: law\.kp: expected a number, got the text 'much'",
    "compare_laws": r"published: \d+ mm late, .*\nsamson: .*\nkanayama: .*\n\{'k_x': ",
    "tune_gains": r"cost 0\.1\d+ -> 0\.0\d+\nname='published' delay_periods=0 kp=",
    "run_a_campaign": r"universal +rest +8 +8 +0\.6755\d+ +1\.0",
    "check_feasibility": r"^Fits at .*\nDoes not fit at .*\nfriction used: (69\.\d|70\.0)%",
    "inspect_a_robot": r"1\.00173 kg on wheels of 33 mm\nat most 0\.\d+ m/s and \d\.\d+ rad/s\n\{'part': 'geometry'",
    "make_a_film": r"hello\.mp4 True",
    "draw_figures": r"\['trajectories\.png', 'trajectories\.pdf', 'errors\.png', 'errors\.pdf'\]",
}


@pytest.mark.parametrize(("page", "path"), FILES, ids=[path.name for _, path in FILES])
def test_pages_show_the_files_as_they_are(page: str, path: Path) -> None:
    text = (ROOT / "docs/how-to" / page).read_text(encoding="utf-8")
    shown = re.search(rf"`{path.name}`:\n\n```\w+\n(.*?)```", text, re.DOTALL)
    assert shown is not None
    assert shown[1] == path.read_text(encoding="utf-8")


def test_the_readme_shows_the_shortest() -> None:
    shown = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert shown is not None
    code = (EXAMPLES / "quickstart.py").read_text(encoding="utf-8").split('"""\n\n', 1)[1]
    assert shown[1] == code


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the scripts print, by their names: all run in one Python, since importing is most of their work."""
    folder = tmp_path_factory.mktemp("examples")
    script = f"""
import runpy, sys
from pathlib import Path
for path in sorted(Path({str(EXAMPLES)!r}).glob("*.py")):
    print("#", path.stem, flush=True)
    runpy.run_path(str(path), run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-B", "-c", script], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    parts = re.split(r"^# (\w+)\n", done.stdout, flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", [path.stem for path in PAGES["python.md"]])
def test_scripts_run_and_print_what_they_claim(name: str, printed: dict[str, str]) -> None:
    assert re.search(PRINTED[name], printed[name]), printed[name]


def pytest_of(folder: Path, file: str) -> list[str]:
    """Returns what pytest is given to run the tests of an example, without this project's settings."""
    return ["-q", "-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", str(folder), file]


@pytest.mark.slow
def test_the_example_of_a_law_runs() -> None:
    """One Python runs the script and the tests: importing is most of the work."""
    tests = f"pytest.main({pytest_of(LAW, 'test_my_law.py')})"
    both = f"import pytest, runpy; runpy.run_path('run_it.py', run_name='__main__'); {tests}"
    done = subprocess.run([sys.executable, "-B", "-c", both], cwd=LAW, capture_output=True, text=True, check=True)
    assert re.search(r"0\.\d+ mm from the leader at 12 s", done.stdout), done.stdout
    assert "8 passed" in done.stdout, done.stdout


@pytest.mark.slow
@pytest.mark.render
def test_the_robots_of_the_example_keep_their_contract() -> None:
    """Two robots, eight tests each; what they look like is among them."""
    command = [sys.executable, "-B", "-m", "pytest", *pytest_of(ROBOT, "test_my_robot.py")]
    done = subprocess.run(command, cwd=ROBOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "16 passed" in done.stdout, done.stdout
