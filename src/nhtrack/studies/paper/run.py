"""Runs the paper's examples, draws its figures, writes the pages that hold both against each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from nhtrack.analysis.machines import ready
from nhtrack.config.values import Backend
from nhtrack.errors import RecordingError, noting
from nhtrack.execution import Executor, Processes
from nhtrack.experiment.compile import compile_once
from nhtrack.experiment.load import load
from nhtrack.files.appeared import wait_for
from nhtrack.files.atomic import atomic_path
from nhtrack.files.folder import claimed_folder
from nhtrack.recording import Recording
from nhtrack.studies.paper.examples import Example
from nhtrack.studies.paper.result import ExampleRuns
from nhtrack.studies.run.run import simulate
from nhtrack.terminal.progress import Stage

if TYPE_CHECKING:
    from nhtrack.experiment.loop import Progress


_FOLDER = "paper"  # of the scenarios, and of the figures beside the page


def reproduce(
    examples: Sequence[Example],
    out: Path | None,
    *,
    source: Path | None = None,
    backend: Backend = "mujoco",
    pdf: bool = False,
    report: bool = True,
    overwrite: bool = False,
    stage: Stage | None = None,
    executor: Executor | None = None,
) -> list[Path]:
    """Returns the files written: recordings, the figures of the paper, the page `paper.md` and `report.html`.

    Every scenario is run on the ideal model and, unless `backend` is `ideal`, on MuJoCo with its ideal twin. A
    recording is written as soon as it is there.

    Args:
        examples: which, see `EXAMPLES`.
        out: the folder, `runs/paper-<n>/` with the first free n by default; figures lie in its `paper/`, recordings
            in its `recordings/`.
        source: a folder that an earlier call wrote; its recordings are drawn, and nothing is run.
        backend: `ideal` leaves MuJoCo out.
        pdf: whether to draw for print, see `nhtrack.plots.files.save_figure`.
        report: whether to write the report.
        overwrite: allow a folder that has files in it.
        stage: see `nhtrack.studies.run.run.simulate`.
        executor: what does the runs; processes, one for each core, by default. Its machines share the folder.

    Raises:
        OutputError: the folder has files in it; nothing is run.
        RecordingError: a recording is missing in `source`, or is of a run that did not complete.
        SimulationDiverged: a run did; what it recorded is kept.
        EngineError, MachineError: the executor cannot be had, or its machines are not like this one.
    """
    with claimed_folder("paper", out, overwrite) as folder:
        runs = {example: _wanted(example, source or folder, backend) for example in examples}
        recorded = list[Path]()
        if source is None:
            every = [run for each in runs.values() for run in each]
            recorded = _record_all(every, folder, stage, executor or Processes())
        done = [_read(example, each) for example, each in runs.items()]
        with noting(f"`nhtrack paper --from {source or folder}` draws what is recorded"):
            drawn = _draw(done, folder / _FOLDER, pdf, None if stage is None else stage("figures"))
            page = _write_page(done, folder / "paper.md")
            return [*recorded, *drawn, page, *([_write_report(done, folder)] if report else [])]


class _Run(NamedTuple):
    """A scenario of the paper on one model, and the file of its recording."""

    name: str
    model: Backend
    file: Path


def _wanted(example: Example, folder: Path, backend: Backend) -> list[_Run]:
    models: tuple[Backend, ...] = ("ideal", backend) if backend != "ideal" else ("ideal",)
    names = product(example.scenarios, models)
    return [_Run(name, model, folder / "recordings" / f"{name}-{model}.nc") for name, model in names]


def _record_all(runs: Sequence[_Run], folder: Path, stage: Stage | None, executor: Executor) -> list[Path]:
    """Runs what is wanted and returns the recordings, on disk as soon as each is there."""
    compile_once(stage)
    executor = ready(executor, folder)
    report = None if stage is None else stage("runs")
    elsewhere = [run._replace(file=run.file.absolute()) for run in runs]  # a worker may be in another folder
    for done, _ in enumerate(executor(elsewhere, _record), start=1):
        if report is not None:
            report(done, len(runs))
    wait_for(run.file for run in runs)
    return [run.file for run in runs]


def _record(run: _Run) -> None:
    """Runs a scenario on one model and writes its recording, be it whole or not."""
    scenario = load(f"{_FOLDER}/{run.name}", [f"backend={run.model}"])
    outcome = simulate(scenario)
    outcome.recording.save(run.file)
    if outcome.failure is not None:
        raise outcome.failure
    if outcome.recording.outcome == "interrupted":
        raise KeyboardInterrupt


def _read(example: Example, runs: Sequence[_Run]) -> ExampleRuns:
    """Returns the recorded runs of an example."""
    read: dict[Backend, dict[str, Recording]] = {"mujoco": {}, "ideal": {}}
    for run in runs:
        read[run.model][run.name] = _completed(run.file)
    return ExampleRuns(example, read["mujoco"], read["ideal"])


def _completed(file: Path) -> Recording:
    recording = Recording.load(file)
    if recording.outcome != "completed":
        raise RecordingError(
            f"{file}: this run is {recording.outcome}; figures of the paper need a whole one"
        )
    return recording


def _draw(done: Sequence[ExampleRuns], folder: Path, pdf: bool, progress: Progress | None) -> list[Path]:
    from nhtrack.plots.files import save_figure

    wanted = [(figure, runs.shown) for runs in done for figure in runs.example.figures]
    written: list[Path] = []
    for i, (figure, runs) in enumerate(wanted):
        written += save_figure(figure.draw(runs), folder / figure.name, pdf=pdf)
        if progress is not None:
            progress(i + 1, len(wanted))
    return written


def _write_page(done: Sequence[ExampleRuns], path: Path) -> Path:
    from nhtrack.studies.paper.page import page

    with atomic_path(path) as temporary:
        temporary.write_text(page(done, _FOLDER), encoding="utf-8")
    return path


def _write_report(done: Sequence[ExampleRuns], folder: Path) -> Path:
    from nhtrack.studies.paper.report import write_paper_page
    from nhtrack.studies.paper.report_sections import paper_command, sections

    made = next(iter(done[0].shown.values())).versions
    return write_paper_page(sections(done, folder / _FOLDER), paper_command(done), made, folder / "report.html")
