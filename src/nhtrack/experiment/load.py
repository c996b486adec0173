"""Scenario files to scenarios whose robots have been looked at, too; see `nhtrack.config.load`."""

from nhtrack.config.load import Loader
from nhtrack.experiment.robot_checks import robot_findings

LOADER = Loader(robot_findings)
load, load_campaign, load_sweep, load_either = LOADER.load, LOADER.load_campaign, LOADER.load_sweep, LOADER.load_either
load_text, load_tree = LOADER.load_text, LOADER.load_tree
