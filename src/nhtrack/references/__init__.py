"""The leader's input u0(t): what the root of the network is commanded over time.

A signal is a scalar function of time; a reference is a pair of them, (u_x [m/s^2], u_theta [rad/s^2]) in whatever units
its time is in. A form of the input is a module here, with its section of a scenario and the reference it makes of it.
Nothing here knows of scales: `nhtrack.similarity` maps times and inputs to the robot.
"""

from nhtrack.references.columns import FileFaults, header_of
from nhtrack.references.contract import Commands, InputSection, PathStart, Reference, ReferenceInputError, Signal
from nhtrack.references.expression import (
    CONSTANTS,
    FUNCTIONS,
    LONGEST_EXPRESSION,
    VOCABULARY,
    Expression,
    make_signal,
    number_of,
    value_of,
)
from nhtrack.references.inputs import Input, input_kind, input_kinds, input_words
from nhtrack.references.motion import Departure, Motion, MotionInput
from nhtrack.references.segments import Segments, make_segments
from nhtrack.references.signals import Segment, SignalInput, SignalValue
from nhtrack.references.table import Table, TableInput

__all__ = [
    "CONSTANTS",
    "FUNCTIONS",
    "LONGEST_EXPRESSION",
    "VOCABULARY",
    "Commands",
    "Departure",
    "Expression",
    "FileFaults",
    "Input",
    "InputSection",
    "Motion",
    "MotionInput",
    "PathStart",
    "Reference",
    "ReferenceInputError",
    "Segment",
    "Segments",
    "Signal",
    "SignalInput",
    "SignalValue",
    "Table",
    "TableInput",
    "header_of",
    "input_kind",
    "input_kinds",
    "input_words",
    "make_segments",
    "make_signal",
    "number_of",
    "value_of",
]
