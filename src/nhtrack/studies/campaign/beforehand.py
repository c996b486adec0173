"""What is known of a campaign before it runs: which references are beyond its laws, or its robots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from nhtrack.analysis.beforehand import leader_beyond_law, leader_beyond_robot
from nhtrack.analysis.time_scale import at_time, leader_time
from nhtrack.config.campaign import Campaign
from nhtrack.config.link import delay_warnings
from nhtrack.experiment.build import build, make_law, make_limits
from nhtrack.presentation.numbers import counted
from nhtrack.studies.campaign.cell import Cell

LOOKED_AT = 1_000_000  # control periods that are looked at in a few seconds


def campaign_beforehand(
    campaign: Campaign,
    gains: Mapping[tuple[str, str], Mapping[str, float]] | None = None,
    *,
    limited: bool = True,
    most: int | None = None,
) -> tuple[str, ...]:
    """Returns what of its references is beyond laws and robots, in sentences, once for each reference and law.

    Of a grid the corners are looked at, and the first of them is told with the number of the others. Of random
    references the first is looked at; of laws to be tuned nothing is known before they are.

    Args:
        campaign: with its time scale as a number.
        gains: found by tuning, by label and family.
        limited: whether to look at the limits that laws keep.
        most: control periods to look at, of all references together, where that is to take seconds; then it is told
            how many references are looked at.
    """
    tuned = () if campaign.tuning is None else campaign.tuning.laws
    found, robot, limits = dict[str, dict[str, list[str]]](), None, {}
    laws = campaign.laws.items()
    alike = [said for label, law in laws for said in delay_warnings(campaign.delay, law, f"laws.{label}")]
    families = _looked_at(campaign)
    some = len(families) if most is None else max(1, most // campaign.periods)
    if some < len(families):
        alike.append(
            f"{len(families)} references of {campaign.periods} control periods each: the first {some} are looked at"
        )
    for family in families[:some]:
        for place, label in enumerate(campaign.laws):
            cell = Cell(campaign, label, family, (gains or {}).get((label, family), {}))
            if place == 0:
                scenario = cell.scenario(0)
                experiment = build(scenario, robot)
                robot = experiment.robot
                _note(found, cell, "", leader_beyond_robot(scenario, experiment))
            if gains is None and label in tuned:
                continue
            if limited and label not in limits:
                limits[label] = make_limits(scenario.model_copy(update={"law": cell.law}), robot)
            law = make_law(cell.law, experiment.similarity, limits.get(label))
            _note(found, cell, f" under {label}", leader_beyond_law(law, scenario, experiment))
    return (*alike, *(sentence for points in found.values() for sentence in _told(points)))


def campaign_beforehand_without_time(campaign: Campaign) -> tuple[str, ...]:
    """Returns the same of a campaign with `time: auto`, at the smallest time scale that fits its leaders alone.

    Nothing is told of limits of laws; see `beforehand_without_time`.

    Raises:
        FeasibilityError: none fits.
    """
    guess = at_time(campaign, 1.0)
    cells = [Cell(guess, next(iter(campaign.laws)), family) for family in _looked_at(campaign)]
    time = max(leader_time(at_time(cell.scenario(0, virtual=False), "auto")) for cell in cells)
    at = f"similarity.time {time:g}, the smallest that fits its leaders alone"
    found = campaign_beforehand(at_time(campaign, time), limited=False, most=LOOKED_AT)
    return tuple(f"at {at}: {said}" for said in found)


def _looked_at(campaign: Campaign) -> list[str]:
    """Returns the families that stand for all: of a grid its corners."""
    inner = {point for grid in campaign.grids for point in set(grid.names) - set(grid.corners)}
    return [name for name in campaign.family_names if name not in inner]


def _note(found: dict[str, dict[str, list[str]]], cell: Cell, under: str, said: Iterable[str]) -> None:
    """Adds what is said of a cell to that of its reference, of all corners of a grid to one."""
    sentences = [f"{cell.family}{under}: {each}" for each in said]
    if sentences:
        leader = cell.family_leader
        name = leader.grid if leader is not None and leader.grid else cell.family
        found.setdefault(name + under, {})[cell.family] = sentences


def _told(points: Mapping[str, list[str]]) -> Iterator[str]:
    """Yields what is said of a reference, or of the first corner of a grid, and of how many more there is as much."""
    *others, last = next(iter(points.values()))
    yield from others
    more = len(points) - 1
    yield last + (f"; likewise at {counted(more, 'other corner')} of its grid" if more else "")
