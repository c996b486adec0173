"""The commented scenario that people start from: the bundled one, or the same for a robot of their own."""

from __future__ import annotations

import io
import re
from math import pi
from typing import Any, NamedTuple

from ruamel.yaml import YAML

from nhtrack import assets
from nhtrack.config.edit import with_values
from nhtrack.config.robot_section import RobotSection
from nhtrack.laws import Limits

__all__ = ["Pace", "pace_within", "starter", "starter_with"]

_SPEEDING, _WAVE = 2.0, 5.0  # [s] for which its leader speeds up; of a wave in which it turns
_SPEED, _PUSH = 0.4, 0.6  # shares of the limits of speeds and of accelerations that it takes
_TURNING = 0.5  # [rad/s] at most
_BEFORE_LAW = "# The tracking law"  # begins what the bundled scenario says of its own
_BUNDLED_FIELD = 0.16  # [m/s] of the bundled robot, whose leader drives at 0.2
_LAW = """\
# `agile` follows leaders that drive, stop, reverse and park, from wherever a follower starts. Wheels may use that
# share of their friction; the limits of motion are found from the model of the robot (`nhtrack inspect` shows them).
law: {{name: agile, field_speed: {field:.3g}, limits: {{utilisation: {utilisation:g}{speed}}}}}
"""


class Pace(NamedTuple):
    """How fast the robots of a scenario move.

    Attributes:
        speed: of the leader at most [m/s].
        yaw_rate: of the leader at most [rad/s].
        top: of a follower at most [m/s].
        friction: of the level floor [1].
        utilisation: the share of it that followers may use [1].
    """

    speed: float
    yaw_rate: float
    top: float
    friction: float
    utilisation: float


def pace_within(limits: Limits, friction: float, utilisation: float) -> Pace:
    """Returns the pace of a leader whose followers have limits, and room within them to catch up."""
    speed = min(_SPEED * limits.speed, _PUSH * _SPEEDING * limits.acceleration)
    turning = min(_TURNING, _SPEED * limits.yaw_rate, _PUSH * _WAVE / (2 * pi) * limits.yaw_acceleration)
    return Pace(speed, turning, limits.speed, friction, utilisation)


def starter(name: str) -> str:
    """Returns a scenario that begins with a bundled robot, called by a name where that is one."""
    return _without_law(name) + _LAW.format(field=_BUNDLED_FIELD, utilisation=0.5, speed="")


def _without_law(name: str) -> str:
    text, _, _ = assets.find_scenario("tour/hello").read_text(encoding="utf-8").partition(_BEFORE_LAW)
    return called(text, name)


def starter_with(name: str, robot: RobotSection, pace: Pace) -> str:
    """Returns the same scenario of another robot, whose leader moves at a pace that suits it.

    Args:
        name: of the scenario.
        robot: which, and what its file cannot say itself.
        pace: that suits it; its follower starts four seconds' way behind and aside.
    """
    push, away = f"{pace.speed / _SPEEDING:.3g}", f"{4 * pace.speed:.3g}"
    turn = f"{2 * pi * pace.yaw_rate / _WAVE:.3g}"
    text = re.sub(r"^(robot: \S+) .*", r"\1", _without_law(name), count=1, flags=re.MULTILINE)
    values = {
        ("description",): flow(f"A leader drives an S and parks; a follower joins it. Both are {robot.file}."),
        ("robot",): flow(robot.model_dump(mode="json", exclude_defaults=True)),
        ("physics", "friction"): f"{pace.friction:g}",
        ("leader", "input", "u_x", 0, "value"): push,
        ("leader", "input", "u_x", 2, "value"): f"-{push}",
        ("leader", "input", "u_theta"): f"where(2 < t < 12, {turn}*cos(2*pi*(t - 2)/5), 0)",
        ("followers", 0, "start", "pose"): f"[-{away}, {away}, {-pi / 2!r}]",
    }
    law = _LAW.format(field=0.8 * pace.speed, utilisation=pace.utilisation, speed=f", speed: {pace.top:.3g}")
    return with_values(text + law, values)


def called(text: str, name: str) -> str:
    """Returns a scenario's text under another name, where that is one."""
    if re.fullmatch(r"[A-Za-z][\w-]*", name):
        text = re.sub(r"^name: \S+", f"name: {name}", text, count=1, flags=re.MULTILINE)
    return text


def flow(value: Any) -> str:
    """Returns a value as YAML in one line."""
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.default_flow_style, yaml.sort_base_mapping_type_on_output, yaml.width = True, False, 10_000
    text = io.StringIO()
    yaml.dump([value], text)
    return text.getvalue().strip()[1:-1]
