"""The reduced model of a differential-drive robot: inertia, wheel torques, limits and friction demand."""

from nhtrack.robots.diff_drive.model import DiffDrive
from nhtrack.robots.motor import Motor

__all__ = ["DiffDrive", "Motor"]
