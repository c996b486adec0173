"""Colours of the robots, the same in the scene, the film and the figures."""

from __future__ import annotations

__all__ = ["FOLLOWERS", "GRIP", "ICE", "ROOT", "UTILISATION", "rgb", "robot_colour"]

# A set that colour-blind readers can tell apart (Okabe and Ito 2008), most readable on white first.
ROOT = "#D55E00"
FOLLOWERS = ("#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F", "#B5A900")


def robot_colour(index: int) -> str:
    """Returns the colour `#RRGGBB` of a robot by its place in the recording; the root's is its own alone."""
    return ROOT if index == 0 else FOLLOWERS[(index - 1) % len(FOLLOWERS)]

# Patches of the floor with less and with more friction than the rest.
ICE, GRIP = "#9ED1F2", "#736154"

# A wheel's tyre as it uses more of its friction: from its own near black by these to the last, at its limit.
UTILISATION = ("#7A1F5C", "#E8663C", "#FFE64D")


def rgb(colour: str) -> tuple[float, float, float]:
    """Returns red, green and blue from 0 to 1 of a colour written `#RRGGBB`."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue
