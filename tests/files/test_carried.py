"""Copies of files: read in place of what they were made of, there or not, for as long as they are asked for."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from nhtrack.files.carried import as_named, carried, read_at
from nhtrack.laws import LawError, law_in
from nhtrack.references.columns import FileFaults, read_csv
from nhtrack.references.recorded import read_poses
from recordings import synthetic_recording

LAW = Path(__file__).parents[1] / "own_laws" / "spring.py"


def test_whatever_a_user_names_is_read_from_its_copy(tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    recording, table, law = folder / "recording.nc", folder / "a b.csv", folder / "law.py"
    synthetic_recording(samples=11).save(recording)
    table.write_text("t,u\n0,1\n")
    law.write_text(LAW.read_text())
    here = read_poses(recording, "leader"), read_csv(table, ("t", "u")).values["u"], law_in(law).source
    copies = pickle.loads(pickle.dumps(carried([recording, table, law])))
    folder.rename(tmp_path / "gone")
    with copies.here():
        np.testing.assert_array_equal(read_poses(recording, "leader")[1], here[0][1])
        assert read_csv(table, ("t", "u")).values["u"] == here[1]
        assert (law_in(law).source, law_in(law).file) == (here[2], str(law))
        assert as_named(f"{read_at(law)}:1: no") == f"{law}:1: no"
        assert read_at(tmp_path) != tmp_path
        assert read_at(tmp_path / "other") == tmp_path / "other"
    for read, error in ((lambda: read_poses(recording, "leader"), FileFaults), (lambda: law_in(law), LawError)):
        with pytest.raises(error, match="no "):
            read()
    with pytest.raises(FileFaults, match="no such file"):
        read_csv(table, ("t", "u"))
    assert read_at(law) == law


def test_copies_are_those_of_the_time_they_were_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "table.csv"
    file.write_text("one")
    monkeypatch.chdir(tmp_path)
    first = carried([Path("table.csv")])
    file.write_text("two")
    second = carried([file])
    for copies, text in ((first, "one"), (second, "two"), (first, "one")):
        with copies.here():
            assert read_at(Path("table.csv")).read_text() == text
    assert first != second
    assert carried([file]) == second
