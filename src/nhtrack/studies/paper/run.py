"""Runs the paper's examples, draws its figures, writes the pages that hold both against each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nhtrack.config.values import Backend
from nhtrack.errors import RecordingError, noting
from nhtrack.experiment.load import load
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

    Raises:
        OutputError: the folder has files in it; nothing is run.
        RecordingError: a recording is missing in `source`, or is of a run that did not complete.
        SimulationDiverged: a run did; what it recorded is kept.
    """
    with claimed_folder("paper", out, overwrite) as folder:
        recorded: list[Path] = []
        done = [_runs(example, source or folder, backend, source is None, stage, recorded) for example in examples]
        with noting(f"`nhtrack paper --from {source or folder}` draws what is recorded"):
            drawn = _draw(done, folder / _FOLDER, pdf, None if stage is None else stage("figures"))
            page = _write_page(done, folder / "paper.md")
            return [*recorded, *drawn, page, *([_write_report(done, folder)] if report else [])]


def _runs(
    example: Example, folder: Path, backend: Backend, wanted: bool, stage: Stage | None, recorded: list[Path]
) -> ExampleRuns:
    """Returns the runs of an example, run where that is wanted, else read; adds to the files that were recorded."""
    runs: dict[Backend, dict[str, Recording]] = {"mujoco": {}, "ideal": {}}
    for name in example.scenarios:
        for model in ("ideal", backend) if backend != "ideal" else ("ideal",):
            file = folder / "recordings" / f"{name}-{model}.nc"
            runs[model][name] = _recorded(name, model, file, stage) if wanted else _completed(file)
            recorded += [file] if wanted else []
    return ExampleRuns(example, runs["mujoco"], runs["ideal"])


def _recorded(name: str, model: Backend, file: Path, stage: Stage | None) -> Recording:
    """Runs a scenario on one model and returns its recording, which is then on disk, whole or not."""

    def named(part: str) -> Progress:
        assert stage is not None
        return stage(f"{name} {part}")

    scenario = load(f"{_FOLDER}/{name}", [f"backend={model}"])
    outcome = simulate(scenario, None if stage is None else named)
    outcome.recording.save(file)
    if outcome.failure is not None:
        raise outcome.failure
    if outcome.recording.outcome == "interrupted":
        raise KeyboardInterrupt
    return outcome.recording


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
