"""Results folders: what is removed of an earlier run, and what is not."""

from __future__ import annotations

from pathlib import Path

from nhtrack.files.folder import COMPARISON, clear, save_json


def test_nothing_outside_a_folder_is_removed_whatever_its_comparison_says(tmp_path: Path) -> None:
    folder, inside, outside = tmp_path / "results", tmp_path / "results" / "kanayama", tmp_path / "mine"
    for each in (inside, outside):
        save_json(each / "summary.json", {})
    save_json(folder / COMPARISON, {"laws": [{"label": "../mine"}, {"label": "kanayama"}]})
    clear(folder)
    assert list(folder.iterdir()) == []
    assert (outside / "summary.json").is_file()
