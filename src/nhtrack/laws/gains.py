"""Gains that several laws have, and where `nhtrack tune` looks for gains of one kind."""

from __future__ import annotations

from math import pi
from typing import Annotated, TypeAlias

from nhtrack.laws.contract import Gain

# A law that settles within a run of duration T has sqrt(kp) T of 10 to 100 and kd around 2 sqrt(kp). A leader that
# covers its size L within the duration turns gains on lengths into stiffness and damping: the same numbers hold.
STIFFNESS, DAMPING = (9.0, 4e4), (6.0, 1000.0)
STEERING = (0.1, 30.0)

Hysteresis: TypeAlias = Annotated[
    float, Gain("rad", "how far past pi a relative heading goes before a whole turn is dropped", above=0.0, below=pi)
]
InnerGain: TypeAlias = Annotated[
    float,
    Gain(
        "1/T",
        "gain of the inner loop that leads velocities to those commanded; well below the control rate",
        search=DAMPING,
        above=0.0,
    ),
]
DeadZoneLength: TypeAlias = Annotated[
    float, Gain("m", "smallest |q| whose direction means anything", least=0.0, section="dead_zone")
]
DeadZoneSpeed: TypeAlias = Annotated[
    float, Gain("m/s", "smallest leader speed whose direction means anything", least=0.0, section="dead_zone")
]
PlaceDeadZoneSpeed: TypeAlias = Annotated[
    float, Gain("m/s", "smallest speed of a place that has a direction", least=0.0, section="dead_zone")
]
