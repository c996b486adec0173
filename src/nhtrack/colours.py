"""The colours of scenes, films, figures and pages."""

from __future__ import annotations

__all__ = [
    "BAND_COLOUR",
    "FOLLOWERS",
    "GRIP",
    "ICE",
    "INK",
    "PAPER",
    "ROOT",
    "TOUCH",
    "UTILISATION",
    "ink_on",
    "letter_colour",
    "rgb",
    "robot_colour",
    "robot_dashes",
]

# A set that colour-blind readers can tell apart (Okabe and Ito 2008), most readable on white first.
ROOT = "#D55E00"
BAND_COLOUR = "#0072B2"  # of many followers drawn as a band
INK = "#1A1A1A"  # of letters and outlines
PAPER = "#FFFFFF"  # what they stand on
FOLLOWERS = ("#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F", "#B5A900")

# Where colours come again, lines are broken, so that any number of them is told apart.
_BROKEN = ((), (4.0, 1.6), (1.3, 1.3), (4.0, 1.4, 1.2, 1.4), (8.0, 1.8))

# Patches of the floor with less and with more friction than the rest.
ICE, GRIP = "#9ED1F2", "#736154"

# Where robots touch each other.
TOUCH = "#A3003F"

# A wheel's tyre as it uses more of its friction: from its own near black by these to the last, at its limit.
UTILISATION = ("#7A1F5C", "#E8663C", "#FFE64D")


def rgb(colour: str) -> tuple[float, float, float]:
    """Returns red, green and blue from 0 to 1 of a colour written `#RRGGBB`."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def ink_on(colour: str) -> str:
    """Returns the ink that is read better on a colour `#RRGGBB`, dark or white, by its contrast (WCAG 2)."""
    below = _luminance(colour) + 0.05
    return INK if below * below > (_luminance(INK) + 0.05) * (_luminance(PAPER) + 0.05) else PAPER


def letter_colour(colour: str) -> str:
    """Returns a colour `#RRGGBB` darkened as far as letters on paper need it to be read, a contrast of 4.5 (WCAG 2)."""
    most = (_luminance(PAPER) + 0.05) / 4.5 - 0.05
    shades = (_mixed(colour, INK, step / 20) for step in range(20))
    return next((shade for shade in shades if _luminance(shade) <= most), INK)


def _mixed(one: str, other: str, share: float) -> str:
    pairs = zip(rgb(one), rgb(other), strict=True)
    return "#" + "".join(f"{round(255 * ((1 - share) * a + share * b)):02X}" for a, b in pairs)


def _luminance(colour: str) -> float:
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb(colour))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def robot_colour(index: int) -> str:
    """Returns the colour `#RRGGBB` of a robot by its place in the recording; the root's is its own alone."""
    return ROOT if index == 0 else FOLLOWERS[(index - 1) % len(FOLLOWERS)]


def robot_dashes(index: int) -> tuple[float, ...]:
    """Returns how the line of a robot is broken, lengths of dashes and gaps in widths of the line; () for solid.

    Lines of the first robots of the palette are solid, and those that have its colours again are each time broken in
    another way.
    """
    return () if index == 0 else _BROKEN[(index - 1) // len(FOLLOWERS) % len(_BROKEN)]
