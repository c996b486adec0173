"""Figures as files."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from nhtrack import plots
from nhtrack.plots.figures.errors import errors
from recordings import synthetic_recording

pytestmark = [pytest.mark.slow, pytest.mark.render]

CROWD = 9  # followers that are drawn as bands


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The figures of a run for print, alone in their folder."""
    folder = tmp_path_factory.mktemp("run") / "figures"
    return plots.save_figures(synthetic_recording(CROWD, samples=51), folder, pdf=True)


def test_files_are_whole_and_nothing_else_is_left(printed):
    names = [f"{name}.{suffix}" for name in plots.run_figures() for suffix in ("png", "pdf")]
    assert [path.name for path in printed] == names
    assert sorted(printed[0].parent.iterdir()) == sorted(printed)
    for png, pdf in zip(printed[::2], printed[1::2], strict=True):
        image, content = iio.imread(png), pdf.read_bytes()
        assert image.shape[1] == 2100  # 3.5 inches at 600 dots
        assert np.std(image[::20]) > 1.0
        assert content.startswith(b"%PDF")
        assert content.rstrip().endswith(b"%%EOF")


def test_pdfs_are_drawings_with_letters_and_say_whose_they_are(printed):
    """No pixels; letters as TrueType, which can be searched and edited; no date."""
    for path in printed[1::2]:
        content = path.read_bytes()
        assert b"/Subtype /Image" not in content
        assert b"/Type3" not in content
        assert b"/FontFile2" in content
        assert b"CreationDate" not in content
        assert f"/Title (example1: {path.stem})".encode() in content


def test_a_pdf_is_the_same_every_time(printed, tmp_path, monkeypatch):
    monkeypatch.setattr(plots, "run_figures", lambda: {"errors": errors})
    again = plots.save_figures(synthetic_recording(CROWD, samples=51), tmp_path, pdf=True)
    assert [path.read_bytes() for path in again] == [path.read_bytes() for path in printed if path.stem == "errors"]


def test_figures_are_for_a_screen_and_the_same_unless_asked_otherwise(tmp_path):
    """Those that say something: an ideal run is its own twin, and does not slip."""
    runs = [synthetic_recording(2, backend="ideal", samples=51) for _ in "ab"]
    first, second = (plots.save_figures(run, tmp_path / name) for run, name in zip(runs, "ab", strict=True))
    assert [path.stem for path in first] == [name for name in plots.run_figures() if name not in ("slip", "gap")]
    assert {iio.imread(path).shape[1] for path in first} == {700}  # 3.5 inches at 200 dots
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_failure_leaves_no_file(tmp_path, monkeypatch):
    def fail(recording):
        figure = errors(recording)
        figure.savefig = lambda path, **_: path.write_bytes(b"half") and 1 / 0
        return figure

    monkeypatch.setattr(plots, "run_figures", lambda: {"errors": fail})
    with pytest.raises(ZeroDivisionError):
        plots.save_figures(synthetic_recording(1, samples=21), tmp_path)
    assert list(tmp_path.iterdir()) == []
