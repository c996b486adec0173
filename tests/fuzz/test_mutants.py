"""Changed files of all kinds are told with their place, soon and without a traceback; see `mutants`."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz import mutants
from nhtrack.errors import Fault, RecordingError, ScenarioError
from nhtrack.recording import Recording


def assert_kept(seed: int, count: int, whole: bool) -> None:
    """Judges so many mutants of a seed."""
    found = list(mutants.verdicts(seed, count, whole))
    assert len(found) == count
    broken = [f"{each.mutant.kind} {each.mutant.origin}: {each.broken}" for each in found if each.broken]
    assert not broken, "\n".join(broken)
    kinds = {(each.mutant.kind, bool(each.said)) for each in found}
    assert {kind for kind, _ in kinds} == {"text", "formula", "columns", "recording", "robot"}
    assert ("text", False) in kinds  # a change that nobody minds
    assert ("text", True) in kinds


def test_300_mutants() -> None:
    assert_kept(seed=1, count=300, whole=False)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_2700_more(seed: int) -> None:
    assert_kept(seed=seed, count=1350, whole=True)


def test_a_seed_and_a_number_are_one_mutant() -> None:
    assert mutants.mutant(5, 7) == mutants.mutant(5, 7) != mutants.mutant(5, 8)
    assert mutants.mutant(6, 7) != mutants.mutant(5, 7)


@pytest.mark.parametrize(
    ("error", "said"),
    [(ZeroDivisionError(), "Traceback"), (ScenarioError("x", [Fault(0, 0, "", "no")]), "without a line")],
)
def test_what_breaks_the_contract_is_found(
    error: Exception, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise error

    monkeypatch.setattr(mutants, "load_either", fails)
    text = next(each for each in (mutants.mutant(1, k) for k in range(99)) if each.kind == "text")
    assert said in mutants.judged(text, tmp_path).broken


@pytest.mark.parametrize("place", range(0, 100, 11))
def test_no_bit_of_a_recording_changes_its_numbers_unseen(place: int, tmp_path: Path) -> None:
    whole = mutants.recording()
    (tmp_path / "whole.nc").write_bytes(whole)
    before = Recording.load(tmp_path / "whole.nc").dataset
    at = place * len(whole) // 100
    changed = whole[:at] + bytes([whole[at] ^ 16]) + whole[at + 1 :]
    (tmp_path / "changed.nc").write_bytes(changed)
    try:
        after = Recording.load(tmp_path / "changed.nc").dataset
    except RecordingError:
        return
    assert after.identical(before)
