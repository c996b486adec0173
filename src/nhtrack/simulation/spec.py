"""What decides a compiled scene, as one value that is kept with every recording."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from pydantic import TypeAdapter

from nhtrack.colours import robot_colour
from nhtrack.effects import Effect, effect_kinds
from nhtrack.errors import RecordingError, did_you_mean
from nhtrack.ground import Ground
from nhtrack.robots.contract import Hints


@dataclass(frozen=True)
class SceneSpec:
    """All that decides a compiled scene; kept with every recording, so that it can be composed again.

    Attributes:
        robots: names, root first.
        robot: folder in models/, or path to a robot's file.
        timestep: physics step [s].
        friction: sliding friction coefficient between wheels and floor.
        contact: `stiff` (contact parameters from the time step) or `default` (MuJoCo's own).
        rate_correction: whether the simulation supplies the missing rate term of the contact rows.
        robot_contact: whether robots touch each other.
        virtual_root: whether the root is a marker without a body.
        bounds: rectangle (x_min, x_max, y_min, y_max) [m] that the whole-run cameras frame.
        effects: what robots are up against beyond a level, uniform floor and the robot of their file.
        compensation: what the wheel torques are computed for: `nominal` (the robot as its file has it, on a level
            floor) or `actual` (what it carries and stands on as well).
        colours: each robot's place in the palette, shape n; empty where a robot's place here is its place there.
        hints: what the robot's file cannot say itself.
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
    effects: tuple[Effect, ...] = ()
    compensation: str = "nominal"
    colours: tuple[int, ...] = ()
    hints: Hints = field(default_factory=Hints)

    def to_json(self) -> str:
        """Returns the spec as one line of JSON, its effects by their keys."""
        return json.dumps(asdict(self) | {"effects": {effect.key: asdict(effect) for effect in self.effects}})

    @classmethod
    def from_json(cls, text: str) -> SceneSpec:
        """Returns the spec written by `to_json`; what an older one lacks is at its default.

        Raises:
            RecordingError: it has an effect that this version does not know.
        """
        tree = _frozen(json.loads(text))
        effects = tuple(_effect(key, fields) for key, fields in tree.pop("effects", {}).items())
        hints = tree.pop("hints", {})
        return cls(**tree, effects=effects, hints=Hints(**hints))

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
        ground = Ground(self.friction)
        for effect in self.effects:
            ground = effect.ground(ground)
        return ground


def _effect(key: str, fields: dict[str, Any]) -> Effect:
    """Returns an effect of its key and its fields in JSON."""
    kinds = effect_kinds()
    if key not in kinds:
        said = f"made under the physical effect {key!r}, which this version lacks"
        raise RecordingError(f"{said}; {did_you_mean(key, tuple(kinds))}")
    return TypeAdapter(kinds[key]).validate_python(fields)


def _frozen(tree: Any) -> Any:
    """Returns a JSON tree with its lists as tuples."""
    if isinstance(tree, dict):
        return {key: _frozen(value) for key, value in tree.items()}
    return tuple(_frozen(item) for item in tree) if isinstance(tree, list) else tree
