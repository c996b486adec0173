"""The section `physics`: how MuJoCo steps, and the keys of all physical effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field, create_model

from nhtrack.effects import effect_kinds
from nhtrack.section import Friction, Section


class Contact(Section):
    """How wheels meet the floor."""

    model: Literal["stiff", "default"] = Field(
        default="stiff",
        description="`stiff` derives the contact parameters from the time step, so that turning slip "
        "vanishes with it; `default` keeps MuJoCo's own, which slip by centimetres per second",
    )
    rate_correction: bool = Field(
        default=True,
        description="supplies the term MuJoCo's contact rows leave out, as a bias inside the friction cone: "
        "it gives no grip on ice",
    )


class _Stepping(Section):
    """How MuJoCo steps, and what the robots are up against."""

    timestep: float = Field(default=0.001, ge=1e-6, le=0.1, description="physics step on the robot's clock [s]")
    friction: Friction = Field(default=1.0, description="Coulomb friction coefficient of wheels and floor [1]")
    contact: Contact = Field(default=Contact(), description="how wheels meet the floor")
    robot_contact: bool = Field(
        default=False,
        description="whether robots collide: off where followers end in the leader's place, on in formations; those "
        "whose hulls overlap at the start are refused",
    )
    compensation: Literal["nominal", "actual"] = Field(
        default="nominal",
        description="what wheel torques are computed for: `nominal`, the robot as its file has it on a level floor; "
        "`actual`, what it carries and the slope as well",
    )


if TYPE_CHECKING:
    Physics = _Stepping
else:
    _KEYS: dict[str, Any] = {key: kind.field for key, kind in effect_kinds().items()}
    Physics = create_model("Physics", __base__=_Stepping, __doc__=_Stepping.__doc__, **_KEYS)
