"""What robots are up against beyond a level, uniform floor and the robot of their file: a file a physical effect."""

from nhtrack.effects.contract import Effect, RobotsAtRest, Setting
from nhtrack.effects.registry import effect_kinds, effects_of

__all__ = ["Effect", "RobotsAtRest", "Setting", "effect_kinds", "effects_of"]
