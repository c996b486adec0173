"""The files of examples/ run, and pages that show them show them as they are."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples/write_a_law"
PAGE = (ROOT / "docs/how-to/own_law.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [path.name for path in sorted(EXAMPLE.glob("*.*"))])
def test_page_shows_the_files_as_they_are(name: str) -> None:
    shown = re.search(rf"`{name}`:\n\n```\w+\n(.*?)```", PAGE, re.DOTALL)
    assert shown is not None
    assert shown[1] == (EXAMPLE / name).read_text(encoding="utf-8")


@pytest.mark.slow
def test_example_runs() -> None:
    """One Python runs the script and the tests: importing is most of the work."""
    options = ["-q", "-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", str(EXAMPLE), "test_my_law.py"]
    both = f"import pytest, runpy; runpy.run_path('run_it.py', run_name='__main__'); pytest.main({options})"
    done = subprocess.run([sys.executable, "-B", "-c", both], cwd=EXAMPLE, capture_output=True, text=True, check=True)
    assert re.search(r"0\.\d+ mm from the leader at 12 s", done.stdout), done.stdout
    assert "8 passed" in done.stdout, done.stdout
