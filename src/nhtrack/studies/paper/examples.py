"""The examples of the paper: what happens in each, its scenarios and its figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from nhtrack.errors import NhtrackError, did_you_mean
from nhtrack.recording import Recording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Runs = Mapping[str, Recording]  # by the scenario's name, without its folder


class ExampleError(NhtrackError):
    """An example that the paper does not have."""


class PaperFigure(NamedTuple):
    """A figure of the paper.

    Attributes:
        name: of its files.
        caption: what it shows.
        draw: from the runs of its example.
    """

    name: str
    caption: str
    draw: Callable[[Runs], Figure]


@dataclass(frozen=True)
class Example:
    """An example of the paper.

    Attributes:
        number: in the paper.
        title: what it is about.
        text: what happens in it.
        scenarios: names of its bundled scenarios, without their folder.
        figures: its figures, in the paper's order.
    """

    number: int
    title: str
    text: str
    scenarios: tuple[str, ...]
    figures: tuple[PaperFigure, ...]


def _paths(
    scenario: str, fractions: Sequence[float], title: str, *, joined: bool = False
) -> Callable[[Runs], Figure]:
    def draw(runs: Runs) -> Figure:
        from nhtrack.studies.paper.figure import panels, tracks

        return panels(tracks(runs[scenario], joined=joined), fractions, title)

    return draw


def _leader_motion(runs: Runs) -> Figure:
    from nhtrack.studies.paper.figure import leader_motion

    return leader_motion(runs["example2"], "Example 2: the leader")


def _reference_path(runs: Runs) -> Figure:
    from nhtrack.studies.paper.figure import reference_path

    return reference_path(runs["example2"], "Example 2: reference path")


def _opposite_starts(runs: Runs) -> Figure:
    from nhtrack.studies.paper.figure import panels, side_by_side

    followers = {r"$\theta(0) = \pi$": runs["example3_pi"], r"$\theta(0) = -\pi$": runs["example3_minus_pi"]}
    return panels(side_by_side(followers), (0.25, 1.0), "Example 3: one start, two ways round", shared_start=1)


def _topology(runs: Runs) -> Figure:
    from nhtrack.studies.paper.figure import topology

    return topology(runs["example4"].parents)


EXAMPLES: Mapping[int, Example] = {
    example.number: example
    for example in (
        Example(
            1,
            "one follower, smooth path",
            "The leader accelerates along a wide curve. The follower starts across its path, driving and turning.",
            ("example1",),
            (
                PaperFigure(
                    "example1_trajectories",
                    "Leader and follower at 15, 25, 50 and 100 % of T.",
                    _paths("example1", (0.15, 0.25, 0.5, 1.0), "Example 1: smooth path"),
                ),
            ),
        ),
        Example(
            2,
            "one follower, a leader that stops",
            "The leader halts again and again, with both velocities exactly zero, turns on the spot and drives on. The "
            "paper shows its input as a figure only; the input here is the project's own, in the same spirit.",
            ("example2",),
            (
                PaperFigure("example2_leader", "Input and velocity of the leader.", _leader_motion),
                PaperFigure("example2_reference", "Path of the leader: it has corners.", _reference_path),
                PaperFigure(
                    "example2_trajectories",
                    "Leader and follower at the end.",
                    _paths("example2", (1.0,), "Example 2: a path with corners"),
                ),
            ),
        ),
        Example(
            3,
            "headings pi and -pi",
            "The follower starts behind the leader with its back to it. Headings pi and -pi are one pose and two "
            "initial conditions: from pi the follower turns clockwise, from -pi anticlockwise.",
            ("example3_pi", "example3_minus_pi"),
            (PaperFigure("example3_trajectories", "Both runs at 25 and 100 % of T.", _opposite_starts),),
        ),
        Example(
            4,
            "consensus",
            "Three followers meet in the leader's place. Robot 3 has two parents and tracks the virtual leader halfway "
            "between them. Robots do not touch here: meeting in one place is the task.",
            ("example4",),
            (
                PaperFigure("example4_topology", "Who tracks whom, in Examples 4 and 5.", _topology),
                PaperFigure(
                    "example4_trajectories",
                    "All robots at 15, 25, 50 and 100 % of T.",
                    _paths("example4", (0.15, 0.25, 0.5, 1.0), "Example 4: consensus"),
                ),
            ),
        ),
        Example(
            5,
            "formation",
            "The same robots and edges; each follower has a place in the frame of its (virtual) leader, and together "
            "they make a diamond. Robots touch each other here, as they would. Robot 3 rests on a choice: its parents "
            "start with headings exactly pi apart, whose middle lies on either side.",
            ("example5",),
            (
                PaperFigure(
                    "example5_trajectories",
                    "All robots at 25, 50, 75 and 100 % of T.",
                    _paths("example5", (0.25, 0.5, 0.75, 1.0), "Example 5: formation", joined=True),
                ),
            ),
        ),
    )
}


def examples_of(numbers: Sequence[int]) -> list[Example]:
    """Returns the examples of some numbers, in the paper's order.

    Raises:
        ExampleError: a number that is none of the paper's.
    """
    for number in numbers:
        if number not in EXAMPLES:
            raise ExampleError(
                f"no Example {number} in the paper; {did_you_mean(str(number), map(str, EXAMPLES))}"
            )
    return [EXAMPLES[number] for number in sorted(set(numbers))]
