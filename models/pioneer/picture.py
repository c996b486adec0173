"""Draws pioneer.png. Run `python models/pioneer/picture.py [FILE]`."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from picture import draw  # noqa: E402

PLACES = {"#D55E00": (0.0, 0.0, 0.15), "#0072B2": (-0.35, 0.52, -0.2), "#009E73": (-0.55, -0.48, 0.5)}

if __name__ == "__main__":
    draw(HERE, PLACES, height=0.0975, lookat=(-0.22, 0.02, 0.06), view=(1.42, 207, -24))
