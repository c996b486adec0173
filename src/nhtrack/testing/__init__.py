"""Contracts that authors of plug-ins inherit in their tests."""

from nhtrack.testing.law import LawContract
from nhtrack.testing.robot import RobotContract
from nhtrack.testing.simulation import SimulationContract

__all__ = ["LawContract", "RobotContract", "SimulationContract"]
