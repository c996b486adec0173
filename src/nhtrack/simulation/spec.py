"""What decides a compiled scene, as one value that is kept with every recording."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from nhtrack.colours import robot_colour
from nhtrack.ground import Ground, Patch

__all__ = ["Payload", "SceneSpec"]


@dataclass(frozen=True)
class Payload:
    """A box of uniform density that every robot carries.

    Attributes:
        mass: [kg].
        position: its centre, x and y in the chassis frame and height above the floor [m].
        size: its edges [m]; zeros for a point.
    """

    mass: float
    position: tuple[float, float, float]
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SceneSpec:
    """All that decides a compiled scene; kept with every recording, so that it can be composed again.

    Attributes:
        robots: names, root first.
        robot: folder in models/ or path to an MJCF file.
        timestep: physics step [s].
        friction: sliding friction coefficient between wheels and floor.
        contact: `stiff` (contact parameters from the time step) or `default` (MuJoCo's own).
        rate_correction: whether the simulation supplies the missing rate term of the contact rows.
        robot_contact: whether robots touch each other.
        virtual_root: whether the root is a marker without a body.
        bounds: rectangle (x_min, x_max, y_min, y_max) [m] that the whole-run cameras frame.
        base: `free` (a free joint, three supports) or `planar` (held level by slides and a vertical hinge).
        patches: regions of the floor with a friction of their own.
        slope: angle of the floor with the horizontal [rad].
        uphill: direction in which the floor rises [rad].
        payload: what every robot carries, or None.
        wheel_mismatch: (r_left - r_right)/r of the tyres; their mean stays r.
        torque_limit: of each wheel motor [N m], or None for the robot's own.
        no_load_speed: of each wheel [rad/s], or None for the robot's own.
        compensation: what the wheel torques are computed for: `nominal` (the robot as its file has it, on a level
            floor) or `actual` (its payload and the slope as well).
        colours: each robot's place in the palette, shape n; empty where a robot's place here is its place there.
    """

    robots: tuple[str, ...]
    robot: str = "nh_mini"
    timestep: float = 0.001
    friction: float = 1.0
    contact: str = "stiff"
    rate_correction: bool = True
    robot_contact: bool = False
    virtual_root: bool = False
    bounds: tuple[float, float, float, float] = (-1.0, 1.0, -1.0, 1.0)
    base: str = "free"
    patches: tuple[Patch, ...] = ()
    slope: float = 0.0
    uphill: float = 0.0
    payload: Payload | None = None
    wheel_mismatch: float = 0.0
    torque_limit: float | None = None
    no_load_speed: float | None = None
    compensation: str = "nominal"
    colours: tuple[int, ...] = ()

    def to_json(self) -> str:
        """Returns the spec as one line of JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> SceneSpec:
        """Returns the spec written by `to_json`; what an older one lacks is at its default."""
        tree = _frozen(json.loads(text))
        tree["patches"] = tuple(Patch(**patch) for patch in tree.get("patches", ()))
        if tree.get("payload") is not None:
            tree["payload"] = Payload(**tree["payload"])
        return cls(**tree)

    @property
    def first_body(self) -> int:
        """Place in `robots` of the first robot that has a body in the scene."""
        return 1 if self.virtual_root else 0

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the robots that have a body in the scene."""
        return self.robots[self.first_body :]

    def colour(self, place: int) -> str:
        """Returns the colour `#RRGGBB` in which the robot at a place of `robots` is drawn."""
        return robot_colour(self.colours[place] if self.colours else place)

    @property
    def ground(self) -> Ground:
        """What the robots stand on."""
        return Ground(self.friction, self.patches, self.slope, self.uphill)

    @property
    def radius_factors(self) -> tuple[float, float]:
        """Radii of the left and the right tyre over the nominal radius."""
        return 1 + self.wheel_mismatch / 2, 1 - self.wheel_mismatch / 2


def _frozen(tree: Any) -> Any:
    """Returns a JSON tree with its lists as tuples."""
    if isinstance(tree, dict):
        return {key: _frozen(value) for key, value in tree.items()}
    return tuple(_frozen(item) for item in tree) if isinstance(tree, list) else tree
