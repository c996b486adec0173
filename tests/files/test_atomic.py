"""Files appear under their names only once they are whole."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from nhtrack.files.atomic import atomic_path


def test_a_file_appears_whole_and_as_any_other(tmp_path: Path) -> None:
    target, plain = tmp_path / "made" / "result.nc", tmp_path / "plain"
    plain.touch()
    for content in (b"first", b"again"):
        with atomic_path(target) as temporary:
            temporary.write_bytes(content)
            assert not target.exists() or target.read_bytes() == b"first"
        assert target.read_bytes() == content
    assert target.stat().st_mode == plain.stat().st_mode
    assert list(target.parent.iterdir()) == [target]


@pytest.mark.parametrize("failure", [KeyboardInterrupt(), OSError(errno.ENOSPC, "No space left on device")])
@pytest.mark.parametrize("old", [None, b"the old file"])
def test_failed_write_leaves_all_as_it_was(tmp_path: Path, failure: BaseException, old: bytes | None) -> None:
    target = tmp_path / "result.nc"
    if old is not None:
        target.write_bytes(old)

    def write_half() -> None:
        with atomic_path(target) as temporary:
            temporary.write_bytes(b"half")
            raise failure

    with pytest.raises(type(failure)):
        write_half()
    assert [path.name for path in tmp_path.iterdir()] == ([] if old is None else ["result.nc"])
    assert old is None or target.read_bytes() == old
