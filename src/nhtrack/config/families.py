"""Bundled references of campaigns, at the scale of 1 m/s, and the sets that a campaign names them by.

The slow ones hold what tracking laws are known to stumble over: leaders that stand, stop, reverse, spin in place, park,
and one whose motion dies away too slowly to excite anything. The quick ones reverse often, spin and circle fast, pass
cusps, are pushed, stop at corners, hardly move or never stop accelerating.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

RANDOM = "random"  # random pieces, another reference for every start
RANDOM_WALK = "random-walk"  # velocities that walk at random, another reference for every start
DRAWN = (RANDOM, RANDOM_WALK)


def _pushes(value: float, until: float, back: float, end: float) -> list[dict[str, float]]:
    """Returns segments of a push until a time and one against it on [back, end)."""
    return [
        {"until": until, "value": value},
        {"until": back, "value": 0.0},
        {"until": end, "value": -value},
    ]


def _signals(u_x: Any, u_theta: Any, v: float = 0.0, omega: float = 0.0) -> Mapping[str, Any]:
    """Returns a family of two signals, which begins at a twist."""
    return {"u_x": u_x, "u_theta": u_theta, "twist": [v, omega]}


def _steady(v: float, omega: float) -> Mapping[str, Any]:
    """Returns a family that is at its twist at once and keeps it."""
    return _signals(0.0, 0.0, v, omega)


def _decay(time: float) -> Mapping[str, Any]:
    """Returns v = omega = exp(-t/time)."""
    return _signals(f"-exp(-t/{time:g})/{time:g}", f"-exp(-t/{time:g})/{time:g}", 1.0, 1.0)


_PUSH = [{"until": 2.0, "value": 0.5}]  # to 1 m/s
_SWAY = "0.1*cos(0.4*t)"  # of the heading
_SQUARE = {
    "waypoints": [[0, 0], [2, 0], [2, 2], [0, 2]], "closed": True, "laps": 5, "corner": "stop-and-turn", "pause": 1.0,
    "speed": 0.5, "acceleration": 0.5,
}  # fmt: skip

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
QUICK: Mapping[str, Mapping[str, Any]] = {
    **{  # v = 0.5 sin(2 pi t/P) while the heading sways
        f"reverse-{name}": _signals(f"0.5*(2*pi/{period:g})*cos(2*pi*t/{period:g})", _SWAY)
        for name, period in (("300ms", 0.3), ("1s", 1), ("3s", 3), ("6s", 6), ("12s", 12), ("20s", 20))
    },
    "chirp": _signals("(0.1 + 0.02*t)*cos(0.2*t + 0.02*t**2)", _SWAY),  # reversing, up to 3.4 rad/s
    "crossings": _signals("0.5*cos(t)", "0.2*cos(0.4*t)", v=0.2),  # reversing, longer ahead than back
    "cusps-slow": _signals("0.1*cos(0.2*t)", 0.0, omega=0.5),  # reversing while it turns
    "cusps-medium": _signals("0.25*cos(0.5*t)", 0.0, omega=0.5),
    "cusps-fast": _signals("0.5*cos(t)", 0.0, omega=0.5),
    **{f"circle-{omega}": _steady(0.5, omega) for omega in (2, 3, 4, 6, 10, 20)},
    **{f"spin-{omega}": _steady(0.0, omega) for omega in (2, 3, 6, 10, 20)},
    "bursts": _signals("where(t % 5 < 0.2, 5, where(t % 5 < 0.4, -5, 0))", 0.0),  # 0.2 m every 5 s, out of rest
    "wander": _signals(
        "0.28*cos(0.7*t) + 0.57*cos(1.9*t) + 0.93*cos(3.1*t)",
        "0.3*cos(0.6*t) - 0.55*sin(1.1*t) + 0.69*cos(2.3*t)",
        omega=0.5,
    ),
    "square": {"input": {"path": _SQUARE}},  # a side, a stop, a turn on the spot, and on
    "eight": {"input": {"path": {"x": "2*sin(0.3*t)", "y": "sin(0.6*t)"}}},
    "decay-1s": _decay(1),
    "decay-10s": _decay(10),
    "decay-30s": _decay(30),
    "ever-faster": _signals(0.2, _SWAY),
    "tiny": _steady(0.004, 0.002),
}
SETS: Mapping[str, tuple[str, ...]] = {"slow": (*FAMILIES, RANDOM), "quick": (*QUICK, RANDOM_WALK)}
