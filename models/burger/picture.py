"""Draws burger.png. Run `python models/burger/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#0072B2": (0.0, 0.0, 0.15), "#D55E00": (-0.19, 0.20, -0.25), "#009E73": (-0.17, -0.24, 0.5)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.033, lookat=(-0.13, -0.015, 0.088), view=(0.64, 205, -20))
