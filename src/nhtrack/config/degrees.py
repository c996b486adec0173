"""Angles that look like degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator

from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import lookup

_STEP = 5.0  # degrees come in such steps; an angle in radians of more than a turn hardly does


def degree_warnings(scenario: Scenario) -> Iterator[str]:
    """Yields the headings of starts, and the direction of a slope, that look like degrees, with what they would be."""
    angles = {"leader.start.pose[2]": scenario.leader.start.pose[2]}
    angles |= {f"followers[{i}].start.pose[2]": each.start.pose[2] for i, each in enumerate(scenario.followers)}
    angles["physics.slope.uphill"] = lookup(scenario.physics.model_dump(), ("slope", "uphill"), 0.0)
    for key, angle in angles.items():
        if abs(angle) > 2 * math.pi and angle % _STEP == 0:
            yield f"{key} = {angle:g} rad looks like degrees, of which it would be {math.radians(angle):.4g} rad"
