"""Draws waffle.png. Run `python models/waffle/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#D55E00": (0.0, 0.0, 0.2), "#0072B2": (-0.28, 0.42, -0.25), "#009E73": (-0.42, -0.52, 0.75)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.033, lookat=(-0.15, -0.02, 0.11), view=(1.2, 205, -20))
