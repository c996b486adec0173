"""What is known of a campaign before it runs: which references are beyond its laws, or its robots."""

from __future__ import annotations

from collections.abc import Mapping

from nhtrack.analysis.beforehand import leader_beyond_law, leader_beyond_robot
from nhtrack.config.campaign import Campaign
from nhtrack.config.link import delay_warnings
from nhtrack.experiment.build import build, make_law, make_limits
from nhtrack.studies.campaign.cell import Cell


def campaign_beforehand(
    campaign: Campaign, gains: Mapping[tuple[str, str], Mapping[str, float]] | None = None
) -> tuple[str, ...]:
    """Returns what of its references is beyond laws and robots, in sentences, once for each reference and law.

    Of random references the first is looked at; of laws to be tuned nothing is known before they are.

    Args:
        campaign: with its time scale as a number.
        gains: found by tuning, by label and family.
    """
    tuned = () if campaign.tuning is None else campaign.tuning.laws
    laws, robot, limits = campaign.laws.items(), None, {}
    found = [said for label, law in laws for said in delay_warnings(campaign.delay, law, f"laws.{label}")]
    for family in campaign.family_names:
        for place, label in enumerate(campaign.laws):
            cell = Cell(campaign, label, family, (gains or {}).get((label, family), {}))
            if place == 0:
                scenario = cell.scenario(0)
                experiment = build(scenario, robot)
                robot = experiment.robot
                found += [f"{family}: {said}" for said in leader_beyond_robot(scenario, experiment)]
            if gains is None and label in tuned:
                continue
            if label not in limits:
                limits[label] = make_limits(scenario.model_copy(update={"law": cell.law}), robot)
            law = make_law(cell.law, experiment.similarity, limits[label])
            found += [f"{family} under {label}: {said}" for said in leader_beyond_law(law, scenario, experiment)]
    return tuple(found)
