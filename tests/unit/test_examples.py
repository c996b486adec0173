"""The files of examples/ run, and pages that show them show them as they are."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples/write_a_law"
PAGE = (ROOT / "docs/how-to/own_law.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [path.name for path in sorted(EXAMPLE.glob("*.*"))])
def test_page_shows_the_files_as_they_are(name: str) -> None:
    shown = re.search(rf"`{name}`:\n\n```\w+\n(.*?)```", PAGE, re.DOTALL)
    assert shown is not None
    assert shown[1] == (EXAMPLE / name).read_text(encoding="utf-8")


def test_links_of_the_page_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", PAGE):
        assert target.startswith("http") or (ROOT / "docs/how-to" / target).exists(), target


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "said"), [(["run_it.py"], r"0\.\d+ mm from the leader at 12 s"), (["-m", "pytest", "-q"], "8 passed")]
)
def test_example_runs(arguments: list[str], said: str) -> None:
    command = [sys.executable, "-B", *arguments]
    if "pytest" in arguments:
        command += ["-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", str(EXAMPLE), "test_my_law.py"]
    done = subprocess.run(command, cwd=EXAMPLE, capture_output=True, text=True, check=True)
    assert re.search(said, done.stdout), done.stdout
