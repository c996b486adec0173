"""Files appear under their names only once they are whole."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from nhtrack.errors import WriteError
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


@pytest.mark.parametrize(
    ("failure", "raised"),
    [(KeyboardInterrupt(), KeyboardInterrupt), (OSError(errno.ENOSPC, "Error writing bytes"), WriteError)],
)
@pytest.mark.parametrize("old", [None, b"the old file"])
def test_failed_write_leaves_all_as_it_was(
    tmp_path: Path, failure: BaseException, raised: type[BaseException], old: bytes | None
) -> None:
    folder = tmp_path / ("there" if old is not None else "new/inner")
    target = folder / "result.nc"
    if old is not None:
        folder.mkdir()
        target.write_bytes(old)

    def write_half() -> None:
        with atomic_path(target) as temporary:
            temporary.write_bytes(b"half")
            raise failure

    with pytest.raises(raised) as stopped:
        write_half()
    assert raised is not WriteError or str(stopped.value) == f"cannot write {target}: No space left on device"
    assert list(tmp_path.rglob("*")) == ([] if old is None else [folder, target])
    assert old is None or target.read_bytes() == old
