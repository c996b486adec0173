"""The reduced model of a differential-drive robot: inertia, wheel torques, limits and friction demand."""

from nhtrack.diffdrive.identification import identify
from nhtrack.diffdrive.motor import Motor
from nhtrack.diffdrive.reduced_model import DiffDrive

__all__ = ["DiffDrive", "Motor", "identify"]
