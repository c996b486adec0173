"""Draws warehouse.png. Run `python models/warehouse/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#0072B2": (0.0, 0.0, 0.15), "#D55E00": (-0.70, 0.85, -0.30), "#009E73": (-0.60, -0.95, 0.55)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.1, lookat=(-0.38, 0.02, 0.10), view=(2.5, 214, -21))
