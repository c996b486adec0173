"""The page of a comparison: who was best at what, all laws on one floor and over one time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.presentation.numbers import cell, counted, listed, quantity, seconds
from nhtrack.presentation.shown import Span, settled_note
from nhtrack.recording import Recording
from nhtrack.report.data import payload
from nhtrack.report.page import Page, write_page
from nhtrack.report.panels import decades
from nhtrack.report.scenario_listing import meanings, yaml_text
from nhtrack.report.timed import SCRIPTS, SECTIONS, timed_contents, with_film
from nhtrack.settling import SettlingLimits
from nhtrack.studies.compare.ranking import MEASURES
from nhtrack.studies.run.report import Extras

LawRow = Mapping[str, Any]  # of `laws` in a comparison's tree

_JOINED = ("twist", "input", "wheel_torque", "friction_utilisation", "lateral_slip", "longitudinal_slip")
_WILD, _MARGIN = 3.0, 0.06  # times the others' largest value that an axis still shows; room at its ends


def write_compare_page(
    tree: LawRow, runs: Mapping[str, Recording], merged: Recording, wrong: Iterable[Span], path: Path, extras: Extras
) -> Path:
    """Writes the page of a comparison; the file appears under its name only once it is whole.

    Args:
        tree: what the comparison found, as plain values (`comparison.json`).
        runs: of the laws, by their labels.
        merged: all of them as one (`nhtrack.video.together.together`).
        wrong: start and end of everything that went wrong on wheels, under any law [s].
        path: file to write.
        extras: film and schema.
    """
    return write_page(compare_page(tree, runs, merged, wrong, extras), path)


def compare_page(
    tree: LawRow, runs: Mapping[str, Recording], merged: Recording, wrong: Iterable[Span], extras: Extras
) -> Page:
    """Returns what the page of a comparison shows. Arguments as `write_compare_page`."""
    whole = join_runs(merged, runs)
    data, film = with_film(payload(whole, wrong), whole, extras.film)
    kept = {label for label, run in runs.items() if run.outcome == "completed"}
    data["panels"] = [fitted(panel, kept, whole) for panel in data["panels"]] if kept else data["panels"]
    colours = {robot["name"]: robot["colour"] for robot in data["robots"]}
    groups = {row["label"]: f"{next(iter(runs.values())).followers[0]}-{row['label']}" for row in tree["laws"]}
    return Page(
        "compare.html.j2",
        f"{tree['name']}: {counted(len(tree['laws']), 'law')}",
        {"standings": "Standings", **SECTIONS, "laws": "Laws", "scenario": "Scenario"},
        compare_verdicts(tree),
        [("With the same versions, this repeats the comparison, in the folder of this page:", _command(tree))],
        tree["versions"],
        description=tree["scenario"].get("description", ""),
        alarm=_alarm(tree),
        warnings=tree["warnings"],
        facts=[("backend", data["backend"])],
        scripts=SCRIPTS,
        data=data,
        contents=timed_contents(whole, data)
        | {
            "film": film,
            "no_film": extras.no_film,
            "standings": [row | {"colour": colours[groups[row["label"]]]} for row in _rows(tree)],
            "settled": settled_note(SettlingLimits(**tree["settling_limits"])),
            "headings": [measure.heading for measure in MEASURES.values()],
            "laws": [_law(row) for row in tree["laws"]],
            "notes": tree["notes"],
            "yaml": yaml_text(tree["scenario"]),
            "keys": meanings(tree["scenario"], extras.schema),
        },
    )


def join_runs(merged: Recording, runs: Mapping[str, Recording]) -> Recording:
    """Returns a recording of all runs that has their twists, commands, torques, slips and utilisations, too.

    What a run did not record, and all of it after the run ended, is NaN.

    Args:
        merged: the root of the longest run, then the followers of each run.
        runs: by their labels, in that order.
    """
    root = max(runs.values(), key=lambda run: len(run.time))
    known = [name for name in _JOINED if all(name in run.dataset for run in runs.values())]
    variables = {
        name: (root[name].dims, np.concatenate([root[name].values[:, :1], *_followers(name, runs, root)], axis=1))
        for name in known
    }
    return Recording(merged.dataset.assign(variables).assign_attrs(root.robot._asdict()))


def _followers(name: str, runs: Mapping[str, Recording], root: Recording) -> Iterator[np.ndarray]:
    for run in runs.values():
        values = run[name].values[:, 1:]
        padded = np.full((len(root.time), *values.shape[1:]), np.nan)
        padded[: len(values)] = values
        yield padded


def fitted(panel: Mapping[str, Any], kept: Iterable[str], recording: Recording) -> dict[str, Any]:
    """Returns a panel whose axis fits the runs that completed: one gone wild would flatten the curves of all others.

    Args:
        panel: see `nhtrack.report.panels.make_panels`.
        kept: labels of the runs that completed.
        recording: of all runs.
    """
    groups = recording.groups
    names = {recording.robots[0], *kept, *(name for label in kept for name in groups[label])}
    values = [_values(curve) for curve in panel["curves"] if curve["name"] in names]
    wanted = np.concatenate([np.zeros(0), *values])
    every = np.concatenate([np.zeros(0), *(_values(curve) for curve in panel["curves"])])
    if not wanted.size or np.abs(every).max() <= _WILD * np.abs(wanted).max():
        return dict(panel)
    room = _MARGIN * max(float(np.ptp(wanted)), 1e-9)
    linear = [float(wanted.min()) - room, float(wanted.max()) + room]
    return {**panel, "range": linear, "decades": decades(wanted) if panel["decades"] else None}


def _values(curve: Mapping[str, Any]) -> np.ndarray:
    """Returns all values of a curve or a band that are known."""
    lines = [np.array(curve[name], dtype=float) for name in ("low", "y", "high") if name in curve]
    values = np.concatenate(lines)
    return np.asarray(values[np.isfinite(values)])


# In words -------------------------------------------------------------------------------------------------------------


def compare_verdicts(tree: LawRow) -> list[str]:
    """Returns sentences on which laws completed, which settled, and which is best at what."""
    laws: Sequence[LawRow] = tree["laws"]
    return [*_ends(laws), *_settled(laws), *_bests(laws, tree["best"])]


def _alarm(tree: LawRow) -> str:
    outcomes = [row["outcome"] for row in tree["laws"]]
    return "" if "completed" in outcomes else "No law completed its run."


def _ends(laws: Sequence[LawRow]) -> Iterator[str]:
    whole = [row for row in laws if row["outcome"] == "completed"]
    if len(whole) == len(laws):
        yield f"All {len(laws)} laws completed their runs of {seconds(laws[0]['end'])}."
    elif whole:
        names = listed([row["label"] for row in whole])
        yield f"{len(whole)} of {len(laws)} laws completed their runs of {seconds(whole[0]['end'])}: {names}."
    for row in laws:
        if row["outcome"] != "completed":
            outcome = row["outcome"].replace(":", ",", 1)
            yield f"{row['label']} did not: it {'was ' * (outcome == 'interrupted')}{outcome}, {_ended(row)}."


def _ended(row: LawRow) -> str:
    return f"and what it recorded ends at {seconds(row['end'])}"


def _settled(laws: Sequence[LawRow]) -> Iterator[str]:
    astray = [row for row in laws if row["outcome"] == "completed" and row["settling_time"] is None]
    for row in astray:
        late = f"{quantity(row['late_position_error'], 'm')} and {quantity(row['late_heading_error'], 'rad')}"
        yield f"{row['label']} did not settle: its worst follower was off by up to {late} late in the run."


def _bests(laws: Sequence[LawRow], best: Mapping[str, str]) -> Iterator[str]:
    """Yields who is best at what, and by how much before the next."""
    for name, measure in MEASURES.items():
        if name not in best:
            continue
        known = [row for row in laws if row["outcome"] == "completed" and row[name] is not None]
        first, second = sorted(known, key=lambda row: row[name])[:2]
        said = f"{best[name]} {measure.praise}: {cell(first[name], measure.unit)}"
        yield f"{said}, where the next, {second['label']}, has {cell(second[name], measure.unit)}."


# Tables ---------------------------------------------------------------------------------------------------------------


def _rows(tree: LawRow) -> Iterator[dict[str, Any]]:
    """Yields the standings: of each law its label, its figures with whether they are the best, and how it ended."""
    for row in tree["laws"]:
        best = {name for name, label in tree["best"].items() if label == row["label"]}
        cells = [(cell(row[name], measure.unit), name in best) for name, measure in MEASURES.items()]
        kind = row["outcome"].split(":")[0]
        ended = kind if kind == "completed" else f"{kind} at {seconds(row['end'])}"
        yield {"label": row["label"], "cells": cells, "ended": ended, "completed": kind == "completed"}


def _law(row: LawRow) -> dict[str, Any]:
    """Returns a law as YAML, and what a search for its gains brought."""
    tuning = row["tuning"]
    told = ""
    if tuning is not None:
        before = "unknown" if tuning["cost_before"] is None else cell(tuning["cost_before"], "1")
        told = f"These gains were searched for: the cost went from {before} to {tuning['cost']:.3g}."
    return {"label": row["label"], "yaml": yaml_text({"law": row["law"]}), "tuning": told}


def _command(tree: LawRow) -> str:
    return " ".join(["nhtrack compare", *(f"{row['label']}/recording.nc" for row in tree["laws"])])
