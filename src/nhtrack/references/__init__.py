"""The leader's input u0(t): what the root of the network is commanded over time.

A signal is a scalar function of time; a reference is a pair of them, (u_x [m/s^2], u_theta [rad/s^2]) in whatever units
its time is in. Nothing here knows of files or of scales: `nhtrack.similarity` maps times and inputs to the robot.
"""

from nhtrack.references.contract import ReferenceInputError, Signal
from nhtrack.references.expression import CONSTANTS, FUNCTIONS, LONGEST_EXPRESSION, Expression, make_signal
from nhtrack.references.reference import Reference
from nhtrack.references.segments import Segments, make_segments
from nhtrack.references.table import Interpolation, Table

__all__ = [
    "CONSTANTS",
    "FUNCTIONS",
    "LONGEST_EXPRESSION",
    "Expression",
    "Interpolation",
    "Reference",
    "ReferenceInputError",
    "Segments",
    "Signal",
    "Table",
    "make_segments",
    "make_signal",
]
