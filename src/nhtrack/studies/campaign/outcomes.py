"""What is asked of the runs of a campaign, and what they answer, in the campaign's units."""

from __future__ import annotations

import math

import numpy as np

from nhtrack.arrays import Array
from nhtrack.config.campaign import Campaign
from nhtrack.experiment.build import Experiment
from nhtrack.experiment.run_statistics import RunStatistics
from nhtrack.settling import settling_limits
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import stepped_scene

FOLLOWER = 1  # its place behind the leader


@np.errstate(over="ignore", invalid="ignore")  # what is lost is told by the table
def run_outcomes(campaign: Campaign, experiment: Experiment) -> dict[str, Array]:
    """Runs some starts of a campaign side by side and returns their figures, see `outcomes_of`.

    Raises:
        SimulationDiverged: the law raised an exception; a robot that is lost is a figure.
    """
    simulation, statistics = simulation_of(experiment, campaign.backend), statistics_of(campaign, experiment)
    failure = experiment.record(simulation, statistics)
    if failure is not None:
        raise failure
    return outcomes_of(statistics, campaign, experiment, simulation.lost)


def simulation_of(experiment: Experiment, backend: str) -> IdealSimulation | MujocoSimulation:
    """Returns what runs an experiment's simulations side by side, and goes on when it has lost one."""
    spec, size = experiment.scene, experiment.size
    if backend == "ideal":
        names, plant = experiment.network.names, experiment.robot.plant
        return IdealSimulation(
            names, plant, experiment.dt, spec.ground, virtual_root=spec.virtual_root, keep_going=True, size=size
        )
    batch = experiment.start.g.shape[:1]
    scene = stepped_scene(spec, experiment.robot)
    return MujocoSimulation(scene, experiment.dt, batch, spec=spec, keep_going=True, size=size)


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
    rows, position, heading = held.settled[:, FOLLOWER], *held.late[:, FOLLOWER].T
    settled = (rows <= statistics.late) & ~lost
    effort = experiment.similarity.inputs_to_scenario(np.sqrt(held.effort[:, FOLLOWER] / periods))
    return {
        "converged": settled,
        "lost": lost,
        "late_position": np.where(lost, np.nan, position / experiment.similarity.length),
        "late_heading": np.where(lost, np.nan, heading),
        "settling_time": np.where(settled, rows * (campaign.duration / periods), np.nan),
        "peak_utilisation": held.utilisation[:, FOLLOWER],
        "saturated": held.saturated[:, FOLLOWER] / periods,
        "effort_x": effort[:, 0],
        "effort_theta": effort[:, 1],
        "switches": held.switches[:, FOLLOWER],
    }
