"""Draws nh_mini.png. Run `python models/nh_mini/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#0072B2": (0.0, 0.0, 0.15), "#D55E00": (-0.12, 0.17, -0.25), "#009E73": (-0.16, -0.15, 0.5)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.03, lookat=(-0.075, 0.01, 0.014), view=(0.50, 207, -22))
