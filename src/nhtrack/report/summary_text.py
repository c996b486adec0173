"""What became of a run, in sentences, from its summary (`nhtrack.analysis.metrics.summary`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from nhtrack.analysis.events import AT_LIMIT
from nhtrack.presentation.numbers import counted, listed, quantity, seconds, share
from nhtrack.presentation.shown import CROWD, Span, within
from nhtrack.recording import Recording
from nhtrack.settling import LATE, SettlingLimits

Summary: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class About:
    """What a summary does not know of its run.

    Attributes:
        virtual_root: whether the root is a marker without a body.
        track: distance between the wheels of a robot [m], or None where it is not known.
    """

    virtual_root: bool = False
    track: float | None = None


def about(recording: Recording) -> About:
    """Returns what sentences need beside the summary of a recording."""
    half = recording.robot.half_separation
    return About(has_virtual_root(recording), 2 * half if np.isfinite(half) else None)


def has_virtual_root(recording: Recording) -> bool:
    """Returns whether the root of a run is a marker without a body."""
    return recording.scenario.leader.virtual


def run_verdicts(summary: Summary, run: About | None = None) -> list[str]:
    """Returns sentences on how the run ended, who settled, the gap to the twin, friction, motors and distances.

    Args:
        summary: of the run.
        run: what the summary does not know of it.
    """
    known = run or About()
    parts: list[Callable[[Summary], list[str]]] = [_gap, _friction, _motors, _events]
    told = _outcome(summary, known) + _settling(summary, known)
    return told + [sentence for part in parts for sentence in part(summary)] + _closest(summary, known)


def event_spans(summary: Summary) -> list[Span]:
    """Returns start and end of every event [s]."""
    return [(event["start"], event["end"]) for event in summary["events"]]


def tiles(summary: Summary) -> list[tuple[str, str]]:
    """Returns the figures that stand at the head of the page, each with its name."""
    followers, robots = summary["followers"], summary["robots"]
    settled = [name for name, figures in followers.items() if figures["settling_time"] is not None]
    late = _worst(followers, "late_position_error")
    found = [("followers settled", f"{len(settled)} of {len(followers)}")]
    found += [("largest late position error", quantity(late[1], "m"))] if late else []
    if summary["backend"] == "mujoco":
        gap, use = _worst(robots, "gap_position_max"), _worst(robots, "peak_utilisation")
        found += [("largest gap to the ideal twin", quantity(gap[1], "m"))] if gap else []
        found += [("largest friction utilisation", share(use[1]))] if use else []
    return found


def _outcome(summary: Summary, run: About) -> list[str]:
    where = "MuJoCo's wheel contacts" if summary["backend"] == "mujoco" else "the ideal integrator"
    count = len(summary["robots"]) - run.virtual_root
    behind = " behind a virtual leader, which has no body," if run.virtual_root else ""
    whole = f"{counted(count, 'robot')} ran{behind} on {where} for {seconds(summary['duration'])}"
    outcome = summary["outcome"]
    if outcome == "completed":
        return [f"{whole}, and the run completed."]
    if outcome == "interrupted":
        return [f"{whole}; then the run was interrupted. What follows is about that time."]
    return [f"{whole}; then the run {outcome.replace(':', ',', 1)}. What follows is about the time before."]


def _settling(summary: Summary, run: About) -> list[str]:
    followers, near = summary["followers"], within(SettlingLimits(**summary["settling_limits"]))
    if len(followers) > CROWD:
        return _crowd_settling(followers, near, run)
    last = f"for {share(LATE)} of the run or longer"
    meaning = f"A follower has settled once it stays {near} of its place until the end, {last}."
    return [meaning, *(_follower(name, figures, run) for name, figures in followers.items())]


def _follower(name: str, figures: Mapping[str, float | None], run: About) -> str:
    late = f"{_distance(figures['late_position_error'], run)} and {quantity(figures['late_heading_error'], 'rad')}"
    began = f"{quantity(figures['initial_position_error'], 'm')} from its place"
    if figures["settling_time"] is None:
        end = f"{quantity(figures['final_position_error'], 'm')} and {quantity(figures['final_heading_error'], 'rad')}"
        return (
            f"{name} began {began} and did not settle: it was off by up to {late} in the last {share(LATE)} of the "
            f"run, and by {end} at its end."
        )
    return (
        f"{name} began {began} and settled after {seconds(figures['settling_time'])}; in the last {share(LATE)} of the "
        f"run it was off by at most {late}."
    )


def _distance(value: float | None, run: About) -> str:
    """Returns a distance, and how it compares with the robot, so that it reads as small or large by itself."""
    if value is None or run.track is None:
        return quantity(value, "m")
    shares = value / run.track
    return f"{quantity(value, 'm')} ({f'{share(shares)} of' if shares < 1 else f'{shares:.3g} times'} its track width)"


def _crowd_settling(followers: Mapping[str, Mapping[str, float | None]], near: str, run: About) -> list[str]:
    times = {name: figures["settling_time"] for name, figures in followers.items()}
    settled = [time for time in times.values() if time is not None]
    astray = [name for name, time in times.items() if time is None]
    told = [f"{len(settled)} of {len(followers)} followers settled, which is to stay {near} of their places"]
    if settled:
        told[0] += (
            f", the first after {seconds(min(settled))}, half of them after {seconds(float(np.median(settled)))}, the "
            f"last after {seconds(max(settled))}"
        )
    told[0] += "."
    if astray:
        told.append(f"{listed(astray)} did not settle.")
    worst = _worst(followers, "late_position_error")
    if worst:
        told.append(f"In the last {share(LATE)} of the run {worst[0]} was off the most, {_distance(worst[1], run)}.")
    return told


def _gap(summary: Summary) -> list[str]:
    if summary["backend"] != "mujoco":
        return ["No wheels were simulated: there is no slip, no friction and no gap to the ideal twin to speak of."]
    robots = summary["robots"]
    far, turned = _worst(robots, "gap_position_max"), _worst(robots, "gap_heading_max")
    if far is None or turned is None:
        return ["How far wheels and ideal twin part is not known to the end: the twin diverged or ended early."]
    rms = robots[far[0]]["gap_position_rms"]
    until = summary["twin_compared_until"]
    told = "Wheels" if until is None else f"Until robots first touched, at {seconds(until)}, wheels"
    after = "" if until is None else " From then on they are not compared: twins pass through each other."
    return [
        f"{told} and ideal twin part by at most {quantity(far[1], 'm')} ({far[0]}; {quantity(rms, 'm')} RMS), their "
        f"headings by at most {quantity(turned[1], 'rad')} ({turned[0]}).{after}"
    ]


def _friction(summary: Summary) -> list[str]:
    worst = _worst(summary["robots"], "peak_utilisation")
    if summary["backend"] != "mujoco" or worst is None:
        return []
    name, used = worst
    told = f"The largest friction utilisation was {share(used)} ({name})"
    if used >= AT_LIMIT:
        return [f"{told}: the wheels were at the limit of what the floor holds."]
    predicted = summary["robots"][name]["peak_utilisation_predicted"]
    model = "" if predicted is None else f"; the reduced model predicts {share(predicted)}"
    return [f"{told}, and wheels break away at 100 %{model}."]


def _motors(summary: Summary) -> list[str]:
    if summary["backend"] != "mujoco":
        return []
    worst = _worst(summary["robots"], "torque_saturation_share")
    if worst is None or worst[1] == 0.0:
        return ["No motor was at its limits."]
    return [f"The motors of {worst[0]} were at their limits for {share(worst[1])} of the run, the most of all robots."]


def _events(summary: Summary) -> list[str]:
    if summary["backend"] != "mujoco":
        return []
    events = summary["events"]
    if not events:
        return ["No wheel slid, none left the floor, and no robot was stuck, leaned, tipped over or touched another."]
    kinds: dict[str, list[str]] = {}
    for event in events:
        kinds.setdefault(event["kind"], []).append(_who(event))
    told = [f"{kind} {_times(len(robots))} ({listed(list(dict.fromkeys(robots)))})" for kind, robots in kinds.items()]
    hardest = max((event for event in events if event["touch"]), key=lambda event: event["worst"], default=None)
    return [f"Events on wheels: {'; '.join(told)}.", *([_hardest(hardest)] if hardest else [])]


def _who(event: Mapping[str, Any]) -> str:
    return f"{event['robot']} with {event['touch']['other']}" if event["touch"] else str(event["robot"])


def _hardest(event: Mapping[str, Any]) -> str:
    """Returns how the robots of the hardest contact touched."""
    touch = event["touch"]
    return (
        f"{event['robot']} and {touch['other']} touched hardest of all, at {seconds(event['start'])}: they closed in "
        f"at {quantity(event['worst'], 'm/s')}, were in contact for {seconds(touch['contact_time'])}, with an impulse "
        f"of {quantity(touch['impulse'], 'N s')}, and hulls overlapped by up to {quantity(touch['overlap'], 'm')}."
    )


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _closest(summary: Summary, run: About) -> list[str]:
    closest = summary["smallest_separation"]
    if closest is None:
        return []
    one, other = closest["robots"]
    if run.virtual_root and next(iter(summary["robots"])) in (one, other):
        return []  # nobody comes close to a robot without a body
    distance = quantity(closest["distance"], "m")
    return [f"{one} and {other} came closest to each other of all robots, {distance} at {seconds(closest['time'])}."]


def _worst(table: Mapping[str, Mapping[str, float | None]], figure: str) -> tuple[str, float] | None:
    """Returns who has the largest of a figure, and how large it is; None where nobody's is known."""
    known = [(name, value) for name, figures in table.items() if (value := figures[figure]) is not None]
    return max(known, key=lambda item: item[1]) if known else None
