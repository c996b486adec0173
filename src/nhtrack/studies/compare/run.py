"""One scenario under several laws: runs side by side, a table of how they did, one figure, film and report of all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Unpack

from nhtrack.config.changes import LawChoice, ScenarioChanges
from nhtrack.config.law_sections import Law
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError, noting
from nhtrack.experiment.build import make_limits
from nhtrack.files.folder import COMPARISON, claimed_folder, clear, save_json
from nhtrack.recording.source import Source, load
from nhtrack.stopping import heard
from nhtrack.studies.compare.laws_file import law_texts, load_laws
from nhtrack.studies.compare.result import Comparison, Search, room_of, search_of
from nhtrack.studies.feasibility.run import fitting_time
from nhtrack.studies.run.files import make_film
from nhtrack.studies.run.run import simulate
from nhtrack.studies.tune.box import TuningError
from nhtrack.studies.tune.result import Tuning
from nhtrack.studies.tune.run import find_gains
from nhtrack.terminal.progress import Observer, Stage, shown_progress

Entrants = dict[str, Scenario]  # the scenario under each law, by the law's label


def compare(
    scenario: Source,
    laws: LawChoice | Iterable[LawChoice],
    *,
    tune: int | None = None,
    objective: str | None = None,
    out: str | Path | None = None,
    overwrite: bool = False,
    figures: bool = True,
    pdf: bool = False,
    video: bool = True,
    report: bool = True,
    processes: int = 1,
    progress: bool | Observer | None = None,
    trust: bool = False,
    **changes: Unpack[ScenarioChanges],
) -> Comparison:
    """Returns how laws did in one scenario, its own among them; files only where `out` is given.

    Args:
        scenario: as in `nhtrack.run`.
        laws: each by its name, its Python file, or its section, such as `{"name": "kanayama", "k_x": 2}`; or another
            scenario whose law it is, by its file or its name.
        tune: how many sets of gains to try for each law before it runs; None takes gains as they are.
        objective: what that search wants, as in `nhtrack.tune`; the late errors by default.
        out: a folder for all that `nhtrack compare` writes; with `overwrite` and what follows as in `nhtrack.run`.
        overwrite: allow a folder that has files in it.
        figures: whether to draw the figure.
        pdf: whether to draw it for print.
        video: whether to make the film.
        report: whether to write the report.
        processes: how many draw the film.
        progress: as in `nhtrack.run`.
        trust: whether to run a law of one's own that a recording brings along.
        **changes: `law`, `robot`, `duration`, `backend` and `set`, see `nhtrack.config.changes.ScenarioChanges`.

    Raises:
        ScenarioError: everything wrong with the scenario, its changes and the laws.
        ObjectiveError: an objective that cannot be understood, or one without `tune`.
        OutputError: the folder has files in it, or cannot be written to; nothing is run.
        FeasibilityError: ground or motors leave a law with limits none, or `time: auto` and no time scale fits any law.
    """
    search = search_of(tune, objective)
    read = partial(load, trust=trust)
    loaded, wanted = load_laws(lambda: read(scenario, **changes), law_texts(laws), read)
    with shown_progress(progress) as stage:
        if out is None:
            return _run_all(_planned(_entrants(loaded, wanted), loaded, None, search, stage), stage)
        made = {"figures": figures, "pdf": pdf, "video": video, "report": report, "overwrite": overwrite}
        return compare_laws(loaded, wanted, Path(out), search=search, **made, processes=processes, stage=stage)


def compare_laws(
    scenario: Scenario,
    laws: Sequence[Law],
    out: Path | None = None,
    *,
    search: Search | None = None,
    overwrite: bool = False,
    figures: bool = True,
    pdf: bool = False,
    video: bool = True,
    report: bool = True,
    processes: int = 1,
    stage: Stage | None = None,
) -> Comparison:
    """Runs a scenario under several laws and writes how they did into a folder.

    Gains are searched first, if at all; then one time scale is found for `time: auto`; then the laws run one after the
    other, each with its ideal twin, and each leaves its recording and summary at once. A law that diverges is kept as
    far as it went, and the others are run all the same; an interruption leaves the recordings there are, and no more.

    Args:
        scenario: what to run; its own law is not run unless it is among the laws.
        laws: the laws, each another.
        out: the folder; `runs/compare-<name>-<n>/` with the first free n by default.
        search: how to search gains; None takes them as they are.
        overwrite: allow a folder that has files in it.
        figures: whether to draw the figure.
        pdf: whether to draw it for print, see `nhtrack.plots.files.save_figure`.
        video: whether to make the film.
        report: whether to write the report.
        processes: how many draw the film, see `nhtrack.video.render_film`.
        stage: see `nhtrack.studies.run.run.simulate`.

    Raises:
        OutputError: the folder has files in it, or cannot be written to; nothing is run.
        FeasibilityError: ground or motors leave a law with limits none, or `time: auto` and no time scale fits any law.
    """
    entrants = _entrants(scenario, laws)  # refuses before anything is written
    with claimed_folder(f"compare-{scenario.name}", out, overwrite) as folder:
        found = _run_all(_planned(entrants, scenario, folder, search, stage), stage)
        if found.interrupted:  # who interrupts does not want to wait
            return found
        with noting(f"the runs are whole in {folder}: `nhtrack plot` and `nhtrack render` draw each"):
            if figures:
                found = _drawn(found, folder, pdf=pdf)
            if video and found.completed:
                found = _filmed(found, folder, stage, processes)
            return _reported(found, folder) if report else found


def _entrants(scenario: Scenario, laws: Sequence[Law]) -> Entrants:
    """Returns a scenario under each law.

    Raises:
        FeasibilityError: ground or motors leave a law with limits none.
    """
    entrants = {label: _under(scenario, law) for label, law in zip(labels(laws), laws, strict=True)}
    for entrant in entrants.values():
        make_limits(entrant)
    return entrants


def _planned(
    entrants: Entrants, scenario: Scenario, folder: Path | None, search: Search | None, stage: Stage | None
) -> Comparison:
    """Returns a comparison of which nothing has run yet, with the gains and the time scale it will run with."""
    entrants, tunings, told = _tuned(entrants, search, stage)
    entrants, more = _at_one_time(entrants, stage)
    timed = _under(next(iter(entrants.values())), scenario.law)
    return Comparison(timed, entrants, {}, search, tunings, (*told, *more), folder)


def labels(laws: Sequence[Law]) -> tuple[str, ...]:
    """Returns what laws are called: their names, numbered where several have the same one."""
    count, seen = Counter(law.name for law in laws), Counter[str]()
    names = []
    for law in laws:
        seen[law.name] += 1
        names.append(law.name if count[law.name] == 1 else f"{law.name}-{seen[law.name]}")
    return tuple(names)


def _under(scenario: Scenario, law: Law) -> Scenario:
    return scenario.model_copy(update={"law": law})


def _staged(stage: Stage | None, label: str) -> Stage | None:
    """Returns a stage whose names say which law they are about."""
    return None if stage is None else lambda name: stage(f"{label}: {name}")


def _tuned(
    entrants: Entrants, search: Search | None, stage: Stage | None
) -> tuple[Entrants, dict[str, Tuning], list[str]]:
    """Returns the scenarios with the gains found, the searches, and what to say of those that found none."""
    if search is None:
        return entrants, {}, []
    found, tunings, notes = dict(entrants), dict[str, Tuning](), list[str]()
    for label, entrant in entrants.items():
        try:
            tuning = find_gains(entrant, search.objective, search.budget, entrant.seed, _staged(stage, label))
        except (TuningError, FeasibilityError) as error:
            notes.append(f"{label}: not tuned, its gains are those it came with: {error}")
        else:
            tunings[label] = tuning
            found[label] = _under(entrant, tuning.scenario.law)
    return found, tunings, notes


def _at_one_time(entrants: Entrants, stage: Stage | None) -> tuple[Entrants, list[str]]:
    """Returns the scenarios at one time scale, and which laws had no say in it; all but `time: auto` as they are.

    The time scale is the largest of those that fit each law: metres and seconds can then be compared.
    """
    if all(entrant.similarity.time != "auto" for entrant in entrants.values()):
        return entrants, []
    times, reasons = dict[str, float](), dict[str, str]()
    for label, entrant in entrants.items():
        try:
            times[label] = fitting_time(entrant, None if stage is None else stage(f"{label}: time scale"))
        except FeasibilityError as error:
            reasons[label] = str(error)
    if not times:
        raise FeasibilityError("; ".join(f"{label}: {reason}" for label, reason in reasons.items()))
    slowest = max(times, key=lambda label: times[label])
    whom = "the other laws" if reasons else "every law"
    notes = [f"similarity.time is {times[slowest]:g}, the smallest that fits {whom}: {slowest} asks for it"]
    notes += [f"{label}: fits no time scale and had no say in it: {reason}" for label, reason in reasons.items()]
    similarity = next(iter(entrants.values())).similarity.model_copy(update={"time": times[slowest]})
    return {label: each.model_copy(update={"similarity": similarity}) for label, each in entrants.items()}, notes


def _run_all(planned: Comparison, stage: Stage | None) -> Comparison:
    """Returns the comparison with its laws run, until the user stops it; what is written is whole after every law."""
    found, folder = planned, planned.folder
    for label, entrant in planned.entrants.items():
        try:
            outcome = simulate(entrant, _staged(stage, label))
        except KeyboardInterrupt:  # before the run proper began
            if not found.outcomes:
                raise
            heard()
            break
        with noting(f"what is kept of the laws before: {', '.join(found.outcomes) or 'nothing'}"):
            found = _written(replace(found, outcomes={**found.outcomes, label: outcome}), label)
        if outcome.recording.outcome == "interrupted":
            break
    return found if folder is None else replace(found, files=(*found.files, folder / COMPARISON))


def _written(found: Comparison, label: str) -> Comparison:
    """Returns a comparison with the files of the law that has just run, where it has a folder."""
    folder, outcome = found.folder, found.outcomes[label]
    if folder is None:
        return found
    files = outcome.recording.save(folder / label / "recording.nc"), folder / label / "summary.json"
    if len(found.outcomes) == 1:
        clear(folder, but=files[0])
    save_json(files[1], outcome.summary)
    found = replace(found, files=(*found.files, *files))
    save_json(folder / COMPARISON, found.tree)
    return found


def _drawn(found: Comparison, folder: Path, *, pdf: bool) -> Comparison:
    """Returns a comparison with its figure, or with the reason why there is none."""
    from nhtrack.plots.files import save_figure
    from nhtrack.studies.compare.figure import overlay

    try:
        figure = overlay(found.recordings, room_of(list(found.recordings.values())))
        drawn = save_figure(figure, folder / "figures" / "overlay", pdf=pdf)
    except (ValueError, OverflowError) as error:
        return replace(found, skipped=(*found.skipped, f"no figure: {error}"))
    return replace(found, files=(*found.files, *drawn))


def _filmed(found: Comparison, folder: Path, stage: Stage | None, processes: int) -> Comparison:
    """Returns a comparison with its film, or with the reason why there is none."""
    from nhtrack.video.together import together

    merged = together(found.recordings, room_of(list(found.recordings.values())))
    film, reasons = make_film(merged, found.scenario.video, folder / "video.mp4", stage, processes)
    return replace(found, files=(*found.files, *film), skipped=(*found.skipped, *reasons))


def _reported(found: Comparison, folder: Path) -> Comparison:
    """Returns a comparison with its report, which has the film in it if there is one."""
    from nhtrack.config.documentation import json_schema
    from nhtrack.studies.compare.report import write_compare_page
    from nhtrack.studies.run.report import Extras
    from nhtrack.video.together import together

    film = folder / "video.mp4"
    extras = Extras(film if film in found.files else None, found.no_film, json_schema())
    merged = together(found.recordings, room_of(list(found.recordings.values())))
    wrong = [(event.start, event.end) for outcome in found.outcomes.values() for event in outcome.events]
    page = write_compare_page(found.tree, found.recordings, merged, wrong, folder / "report.html", extras)
    return replace(found, files=(*found.files, page))
