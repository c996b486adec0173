"""What processes leave that are killed, and who removes it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from nhtrack.files.atomic import atomic_path
from nhtrack.files.folder import OutputError, is_used, require_unused
from nhtrack.files.temporary import remove_abandoned, temporary_folder

_WRITER = """\
import sys, time
from pathlib import Path
from nhtrack.files.atomic import atomic_path

with atomic_path(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    print("begun", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def target(tmp_path: Path) -> Path:
    return tmp_path / "out" / "result.txt"


@pytest.fixture
def writer(target: Path) -> Iterator[subprocess.Popen[str]]:
    """Yields a process in the middle of writing a file."""
    with subprocess.Popen([sys.executable, "-c", _WRITER, str(target)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        yield process
        process.kill()


def test_a_process_that_writes_is_left_alone(writer: subprocess.Popen[str], target: Path) -> None:
    with atomic_path(target) as temporary:
        temporary.write_text("whole")
    (left,) = (entry for entry in target.parent.iterdir() if entry != target)
    assert (left / target.name).read_text() == "half"
    with pytest.raises(OutputError, match="another process writes"):
        require_unused(target.parent, overwrite=False)


def test_what_a_killed_process_left_is_removed(writer: subprocess.Popen[str], target: Path) -> None:
    writer.kill()
    writer.wait()
    assert len(list(target.parent.iterdir())) == 1
    with atomic_path(target) as temporary:
        temporary.write_text("whole")
    assert [entry.name for entry in target.parent.iterdir()] == [target.name]


def test_a_folder_with_nothing_else_in_it_is_unused(writer: subprocess.Popen[str], target: Path) -> None:
    assert is_used(target.parent.parent)
    writer.kill()
    writer.wait()
    assert not is_used(target.parent)
    assert list(target.parent.iterdir()) == []


def test_files_of_others_stay(tmp_path: Path) -> None:
    precious = [tmp_path / ".nhtrack-notes", tmp_path / ".hidden" / "lock"]
    for file in precious:
        file.parent.mkdir(exist_ok=True)
        file.write_text("mine")
    remove_abandoned(tmp_path)
    assert all(file.read_text() == "mine" for file in precious)


def test_a_folder_taken_before_it_was_locked_is_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made, mkdir = list[Path](), Path.mkdir

    def taken(folder: Path, **how: Any) -> None:
        made.append(folder)
        mkdir(folder, **how)
        if len(made) == 1:
            remove_abandoned(tmp_path)

    monkeypatch.setattr(Path, "mkdir", taken)
    with temporary_folder(tmp_path) as folder:
        assert made == 2 * [folder]
        (folder / "file").touch()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_removed_that_was_made_but_not_locked_when_its_process_was_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from nhtrack.files import temporary

    def stopped(_: Path) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(temporary, "_locked", stopped)
    with pytest.raises(KeyboardInterrupt), temporary_folder(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_where_files_cannot_be_locked_work_goes_on_and_nothing_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from nhtrack.files import temporary

    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(temporary.fcntl, "flock", refuse)
    with atomic_path(tmp_path / "a") as one, atomic_path(tmp_path / "b") as other:
        one.write_text("1")
        other.write_text("2")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a", "b"]
