"""Trajectory tracking of nonholonomic mobile robots on MuJoCo wheel contacts, beside the ideal integrator."""

from importlib.metadata import version

__version__ = version("nhtrack")
