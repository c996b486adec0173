"""What results name as their drawers in notebooks."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import nhtrack

SOURCES = Path(nhtrack.__file__).parent


def test_drawers_that_results_name_exist() -> None:
    """A name in a text is not seen by the type checker."""
    named = [
        name
        for path in SOURCES.rglob("*.py")
        for name in re.findall(r'drawn_by\(\s*"([\w.]+)"', path.read_text(encoding="utf-8"))
    ]
    assert "nhtrack.studies.run.view.recording_html" in named
    for name in named:
        module, _, function = name.rpartition(".")
        assert callable(getattr(import_module(module), function)), name
