"""Bundled references of campaigns, at the scale of 1 m/s.

They hold what tracking laws are known to stumble over: leaders that stand, stop, reverse, spin in place, park, and
one whose motion dies away too slowly to excite anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

RANDOM = "random"  # random pieces, another reference for every start


def _pushes(value: float, until: float, back: float, end: float) -> list[dict[str, float]]:
    """Returns segments of a push until a time and one against it on [back, end)."""
    return [
        {"until": until, "value": value},
        {"until": back, "value": 0.0},
        {"until": end, "value": -value},
    ]


_PUSH = [{"until": 2.0, "value": 0.5}]  # to 1 m/s

FAMILIES: Mapping[str, Mapping[str, Any]] = {
    "rest": {"u_x": 0.0, "u_theta": 0.0},
    "line": {"u_x": _PUSH, "u_theta": 0.0},
    "circle": {"u_x": _PUSH, "u_theta": [{"until": 1.0, "value": 0.5}]},
    "sinus": {"u_x": _PUSH, "u_theta": "0.3*cos(0.5*t)"},
    "stop-and-go": {"u_x": "0.5*sign(sin(2*pi*t/20))", "u_theta": "0.2*cos(0.4*t)"},
    "forward-reverse": {"u_x": "0.5*cos(2*pi*t/20)", "u_theta": "0.1*cos(0.4*t)"},
    "park": {"u_x": _pushes(0.5, 2.0, 20.0, 22.0), "u_theta": _pushes(0.3, 1.0, 19.0, 20.0)},
    "spin": {"u_x": 0.0, "u_theta": [{"until": 1.0, "value": 0.5}]},
    "slow-decay": {"u_x": "-1/(1 + t)**2", "u_theta": "-1/(1 + t)**2", "twist": [1.0, 1.0]},
}
