"""What is asked of the runs of a campaign, and what they answer, in the campaign's units."""

from __future__ import annotations

import math

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.campaign import Campaign
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.run_statistics import RunStatistics
from nhtrack.settling import settling_limits


def statistics_of(campaign: Campaign, experiment: Experiment) -> RunStatistics:
    """Returns a recorder that takes the figures of some runs of a campaign."""
    arrival, periods = campaign.arrival, len(experiment.inputs)
    late = math.ceil(periods * (1 - arrival.last / campaign.duration) - 1e-6)
    limits = settling_limits(experiment.similarity.length, arrival.position, arrival.heading)
    return RunStatistics(limits, late, experiment.law.kind.modes)


def outcomes_of(
    statistics: RunStatistics, campaign: Campaign, experiment: Experiment, lost: Array
) -> dict[str, Array]:
    """Returns figures by the columns of `nhtrack.studies.campaign.tables`, in scenario units, shape (b,).

    Args:
        statistics: of runs that are over.
        campaign: theirs.
        experiment: what was run.
        lost: which runs were.
    """
    held, periods = statistics.figures, len(experiment.inputs)
    settled = (held.settled <= statistics.late) & ~lost
    effort = experiment.similarity.inputs_to_scenario(np.sqrt(held.effort / periods))
    return {
        "converged": settled,
        "lost": lost,
        "late_position": np.where(lost, np.nan, held.position / experiment.similarity.length),
        "late_heading": np.where(lost, np.nan, held.heading),
        "settling_time": np.where(settled, held.settled * (campaign.duration / periods), np.nan),
        "peak_utilisation": held.utilisation,
        "saturated": held.saturated / periods,
        "effort_x": effort[:, 0],
        "effort_theta": effort[:, 1],
        "switches": held.switches,
    }
