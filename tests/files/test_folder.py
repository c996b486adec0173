"""Results folders: what is removed of an earlier run, and what is not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nhtrack.files.folder import COMPARISON, OutputError, claimed_folder, clear, require_free, save_json


def test_nothing_outside_a_folder_is_removed_whatever_its_comparison_says(tmp_path: Path) -> None:
    folder, inside, outside = tmp_path / "results", tmp_path / "results" / "kanayama", tmp_path / "mine"
    for each in (inside, outside):
        save_json(each / "summary.json", {})
    save_json(folder / COMPARISON, {"laws": [{"label": "../mine"}, {"label": "kanayama"}]})
    clear(folder, but=save_json(folder / "recording.nc", {}))
    assert [each.name for each in folder.iterdir()] == ["recording.nc"]
    assert (outside / "summary.json").is_file()


def test_a_folder_is_one_process_s_as_long_as_it_works_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    out = Path("out")
    with claimed_folder("case", out, False), claimed_folder("case", None, False) as first:
        for overwrite in (False, True):
            with pytest.raises(OutputError, match="another process"), claimed_folder("case", out, overwrite):
                pass
        with claimed_folder("case", None, False) as second:
            assert (str(first), str(second)) == ("runs/case-1", "runs/case-2")
    with claimed_folder("case", None, False) as again:  # nothing was left in the first
        assert again == first


@pytest.mark.parametrize("there", [False, True])
def test_what_fails_leaves_no_folder_that_was_not_there(tmp_path: Path, there: bool) -> None:
    out = tmp_path / "new" / "out"
    if there:
        out.mkdir(parents=True)
    with pytest.raises(KeyboardInterrupt), claimed_folder("case", out, False):
        raise KeyboardInterrupt
    assert out.exists() == there == out.parent.exists()


def test_a_place_that_cannot_be_written_to_is_told_before_work(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=": Not a directory"):
        require_free(tmp_path / "file" / "out.yaml", True)
    with pytest.raises(OutputError, match=": Not a directory"), claimed_folder("case", tmp_path / "file/out", True):
        pass
