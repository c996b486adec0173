"""Machines that work for this one: files are sent along, and what else has to be the same is asked beforehand."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from nhtrack.analysis.sources import files_read, fingerprint, is_file_name, outline, sources_in
from nhtrack.assets import models_directory, scenarios_directory
from nhtrack.errors import RefusedError
from nhtrack.execution import Executor
from nhtrack.execution.contract import Done, Result, Task
from nhtrack.experiment.compile import compile_once
from nhtrack.files.carried import Carried, carried
from nhtrack.files.temporary import made_folder, temporary_folder
from nhtrack.laws import LawError, law_of_text
from nhtrack.laws.own_file import read_source
from nhtrack.recording.versions import versions

_PACKAGE = Path(__file__).parents[1]
_MOST_SENT = 5e7  # bytes of files: Ray's object stores are kept small


class MachineError(RefusedError):
    """Machines that would not do what this one would, or not where it is looked for; nothing was run."""


class _Facts(NamedTuple):
    """What has to be the same on all machines."""

    package: str
    versions: Mapping[str, str]
    sources: Mapping[str, tuple[str, str]]
    faults: tuple[str, ...]


@dataclass(frozen=True)
class _Sending(Executor):
    """Does tasks by another executor, with copies of files of this machine.

    Attributes:
        executor: the other.
        files: the copies.
    """

    executor: Executor
    files: Carried

    @property
    def workers(self) -> int:
        """How many tasks the other does at once."""
        return self.executor.workers

    @property
    def elsewhere(self) -> bool:
        """Whether the other works elsewhere."""
        return self.executor.elsewhere

    def __call__(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[Result]:
        """Does tasks by the other; see `Executor`."""
        return self.executor(tasks, partial(_with, self.files, work))

    def survived(self, tasks: Sequence[Task], work: Callable[[Task], Result]) -> Done[bool]:
        """Does tasks by the other; see `Executor`."""
        return self.executor.survived(tasks, partial(_with, self.files, work))

    def everywhere(self, work: Callable[[], Result]) -> list[tuple[str, Result]]:
        """Returns what each machine of the other answers; see `Executor`."""
        return self.executor.everywhere(partial(_with, self.files, work))


def _with(files: Carried, work: Callable[..., Result], *tasks: Any) -> Result:
    with files.here():
        return work(*tasks)


def ready(executor: Executor, folder: Path | None, *trees: Any) -> Executor:
    """Returns what does tasks as this machine would: with the files that trees name, where it works elsewhere.

    Each machine compiles beforehand what is not compiled there.

    Args:
        executor: what is going to do tasks.
        folder: where tasks write, which all machines share; None where they do not.
        *trees: plain trees that may name files of laws and robots, and tables, by their full paths.

    Raises:
        MachineError: everything that is not the same, by machine: it would do something else than this one, or could
            not keep it.
    """
    if not executor.elsewhere:
        return executor
    sources = sources_in(*trees)
    sent = _copies(sources)
    executor = executor if sent is None else _Sending(executor, sent)
    with nullcontext() if folder is None else made_folder(folder):  # which is no longer there where it is refused
        with nullcontext(None) if folder is None else temporary_folder(folder.absolute()) as shared:
            answers = executor.everywhere(partial(_look, sources, shared))
        here, found = _facts(sources), list[str]()
        for machine, (facts, writes) in answers:
            found += [f"{machine}: {fault}" for fault in _faults(here, facts, sent is not None)]
            if not writes:
                found.append(f"{machine}: cannot write into {folder}, which all machines share (docs/scaling.md)")
        if found:
            raise MachineError("\n".join(found))
    return executor


def _copies(sources: Sequence[str]) -> Carried | None:
    """Returns copies of all files that are read; None of none, and of too much."""
    read = {file for source in sources for file in files_read(source)}
    try:
        if read and sum(file.stat().st_size for file in read) <= _MOST_SENT:
            return carried(read)
    except OSError as error:
        raise MachineError(f"{error.filename}: cannot be read: {error.strerror}") from error
    return None


def _look(sources: tuple[str, ...], shared: Path | None) -> tuple[_Facts, bool]:
    """Returns what a machine has, and whether it can write into the folder that all share."""
    compile_once(None)
    return _facts(sources), shared is None or _can_write(shared)


def _can_write(folder: Path) -> bool:
    if not folder.is_dir():  # with its name, which nobody else has
        return False
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _facts(sources: tuple[str, ...]) -> _Facts:
    told = {fault for source in sources for fault in _law_faults(source)}
    found = {source: (fingerprint(source), outline(source)) for source in sources}
    return _Facts(_package(), versions(), found, tuple(sorted(told)))


def _law_faults(source: str) -> Iterator[str]:
    """Yields why a law of the user's own cannot be used here, such as that what it imports is not installed."""
    try:
        file, text = read_source(source)
    except LawError:
        return  # no text of a law's size, so no law
    if "def command(" in text:
        try:
            law_of_text(file, text)
        except LawError as error:
            yield from str(error).splitlines()


def _faults(here: _Facts, there: _Facts, sent: bool) -> Iterator[str]:
    """Yields what another machine has otherwise, though files may have been sent there."""
    if there.package != here.package:
        yield "has other sources of nhtrack; install the same wheel there"
    for name, version in here.versions.items():
        if there.versions.get(name) != version:
            yield f"has {name} {there.versions.get(name, 'none')}, this machine has {version}"
    for source, known in here.sources.items():
        if there.sources[source] == known:
            continue
        told = f"{source} is {'another' if there.sources[source][0] else 'not'} there"
        if not is_file_name(source):
            yield f"law {told}; install the same package there"
        else:
            why = "its copy does not find all files; name them relative to it, without .."
            yield f"{told}: {why if sent else f'more than {_MOST_SENT / 1e6:g} MB in all are not sent along'}"
    yield from (fault for fault in there.faults if fault not in here.faults)


def _package() -> str:
    """Returns a hash of all of the package's modules, and of the robots and scenarios that come with it."""
    digest = hashlib.sha256()
    for folder, files in ((_PACKAGE, "*.py"), (models_directory(), "*.xml"), (scenarios_directory(), "*.yaml")):
        for file in sorted(each for each in folder.rglob(files) if "__pycache__" not in each.parts):
            digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()
