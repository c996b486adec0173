"""Draws mp500.png. Run `python models/mp500/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#D55E00": (0.0, 0.0, 0.15), "#0072B2": (-0.75, 1.05, 2.45), "#009E73": (-1.55, -0.75, 0.6)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.13, lookat=(-0.5, 0.15, 0.14), view=(2.9, 207, -21))
