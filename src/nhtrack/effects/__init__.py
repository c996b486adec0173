"""What robots are up against beyond a level, uniform floor and the robot of their file: a file a physical effect."""

from nhtrack.effects.contract import Effect, Setting, Standing
from nhtrack.effects.registry import effect_kinds, effects_of

__all__ = ["Effect", "Setting", "Standing", "effect_kinds", "effects_of"]
