"""The commented scenario to start from whose leader drives after a file of one's own."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from nhtrack.config.starter import called, flow
from nhtrack.references import FileFaults, MotionInput, header_of, input_kind

_TEXT = """\
# A leader that drives after {file}, and a robot that joins it.
#
# Check it:  nhtrack validate <this file>                   # faults of {file} by their line and column
# Run it:    nhtrack run <this file>
# Too fast?  nhtrack feasibility <this file>                # what it asks of wheels and motors, and what would fit
# Every key and its unit: docs/scenario.md, or the JSON Schema that `nhtrack schema` prints.

name: mine
description: {description}

duration: {duration:g}  # the file ends at t = {end:.6g}
# Lengths of the file are metres and times seconds at 1; `length: 0.1` drives it ten times smaller, `time: 2` twice as
# slowly.
similarity: {{length: 1, time: 1}}

backend: mujoco              # real wheels on a floor; `ideal` is the integrator that the theory speaks of
robot: nh_mini               # `nhtrack list` shows the others; a path to a robot's file works too
control_rate: 100            # [Hz] how often the law is asked

leader:
  input: {{{key}: {named}}}  # it begins where the file does; times count from its first row

followers:
  - name: follower
    parents: [leader]        # whom it tracks
    start: {{pose: {pose}}}  # x, y, theta: behind the leader, on its left

# `agile` follows leaders that drive, stop, reverse and park; `field_speed` is how fast it closes in.
law: {{name: agile, field_speed: {field:.3g}}}
"""


def path_starter(name: str, file: Path, folder: Path) -> str:
    """Returns a scenario whose leader drives after a file of timed poses (CSV, TUM) or of velocities (CSV).

    Args:
        name: of the scenario.
        file: the leader's.
        folder: where the scenario is to be; it names the file relative to this.

    Raises:
        FileFaults: everything wrong with the file.
    """
    section = _section_for(file, os.path.relpath(file, folder))
    kind = input_kind(section)
    found = kind.model_validate(kind.resolved(section, folder))
    assert isinstance(found, MotionInput)  # as both forms below are
    motion, (pose, _) = found.reference(), found.start()
    speed = float(abs(motion.speeds(np.linspace(0, motion.end, 1001))[:, 0]).max()) or 0.5
    x, y, theta = pose or (0.0, 0.0, 0.0)
    cos, sin = math.cos(theta), math.sin(theta)
    behind, aside = -2 * speed, speed
    beside = [x + behind * cos - aside * sin, y + behind * sin + aside * cos, theta]
    moving = (abs(motion.speeds(np.array([motion.end]))) > 0.01 * speed).any()
    text = _TEXT.format(
        file=file.name,
        description=flow(f"A leader drives after {file.name}; a robot joins it."),
        duration=math.floor(100 * motion.end) / 100 if moving else math.ceil(motion.end),
        end=motion.end,
        key=kind.key,
        named=flow(section[kind.key]),
        pose=flow([float(f"{value:.3g}") for value in beside]),
        field=0.8 * speed,
    )
    return called(text, name)


def _section_for(file: Path, name: str) -> dict[str, Any]:
    """Returns the input that a file is meant for, by its ending or by the columns its first line names."""
    if file.suffix == ".tum":
        return {"poses": name}
    columns = set(header_of(file))
    for key, needed in (("poses", {"t", "x", "y", "theta"}), ("velocities", {"t", "v", "omega"})):
        if needed <= columns:
            return {key: name}
    got = ", ".join(sorted(columns)) or "nothing"
    raise FileFaults([f"{file.name}:1:1: expected the columns t, x, y, theta or t, v, omega, got {got}"])
