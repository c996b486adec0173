"""Figures as files."""

from __future__ import annotations

import imageio.v3 as iio
import numpy as np
import pytest

from nhtrack import plots
from recordings import synthetic_recording

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("followers", "changes"), [(1, {}), (3, {"stop": 30.0}), (63, {}), (2, {"backend": "ideal"})])
def test_files_are_whole_and_nothing_else_is_left(tmp_path, followers, changes):
    recording = synthetic_recording(followers, samples=101, **changes)
    written = plots.save_figures(recording, tmp_path / "figures", pdf=True)
    silent = {"slip", "gap"} if changes.get("backend") == "ideal" else set()
    assert [path.name for path in written] == [
        f"{name}.{suffix}" for name in plots.FIGURES if name not in silent for suffix in ("png", "pdf")
    ]
    assert sorted((tmp_path / "figures").iterdir()) == sorted(written)
    for path in written:
        if path.suffix == ".png":
            image = iio.imread(path)
            assert image.shape[1] == 2100  # 3.5 inches at 600 dots
            assert np.std(image) > 1.0
        else:
            content = path.read_bytes()
            assert content.startswith(b"%PDF")
            assert content.rstrip().endswith(b"%%EOF")


def test_figures_are_for_a_screen_unless_asked_otherwise(tmp_path):
    written = plots.save_figures(synthetic_recording(1, samples=51), tmp_path)
    assert [path.name for path in written] == [f"{name}.png" for name in plots.FIGURES]
    assert {iio.imread(path).shape[1] for path in written} == {700}  # 3.5 inches at 200 dots


@pytest.mark.parametrize("pdf", [False, True])
def test_same_run_gives_the_same_files(tmp_path, pdf):
    first, second = (
        [path.read_bytes() for path in plots.save_figures(synthetic_recording(2, samples=51), tmp_path / name, pdf=pdf)]
        for name in "ab"
    )
    assert len(first) == (2 if pdf else 1) * len(plots.FIGURES)
    assert first == second


@pytest.mark.parametrize("followers", [2, 15])
def test_pdfs_are_drawings_with_letters_and_say_whose_they_are(tmp_path, followers):
    """No pixels; letters as TrueType, which can be searched and edited; no date."""
    for path in plots.save_figures(synthetic_recording(followers, samples=51), tmp_path, pdf=True)[1::2]:
        content = path.read_bytes()
        assert b"/Subtype /Image" not in content
        assert b"/Type3" not in content
        assert b"/FontFile2" in content
        assert b"CreationDate" not in content
        assert f"/Title (example1: {path.stem})".encode() in content


def test_failure_leaves_no_file(tmp_path, monkeypatch):
    def fail(recording):
        figure = plots.errors(recording)
        figure.savefig = lambda path, **_: path.write_bytes(b"half") and 1 / 0
        return figure

    monkeypatch.setitem(plots.FIGURES, "trajectories", fail)
    with pytest.raises(ZeroDivisionError):
        plots.save_figures(synthetic_recording(1, samples=21), tmp_path)
    assert list(tmp_path.iterdir()) == []
