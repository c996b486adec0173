"""Takes what docs/convergence.md shows of a campaign into docs/campaigns/: its table, its account, its figures.

Run as `python docs/_generate/publish_campaign.py runs/campaign-ideal ideal`, and generate_convergence.py after it.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd
from PIL import Image

from nhtrack.studies.campaign.grids import grid_labels
from nhtrack.studies.campaign.plots import save_campaign_figures

CAMPAIGNS = Path(__file__).resolve().parents[1] / "campaigns"
FIGURES = ("share_map", "settling", "late_errors", "start_map_universal")
SCALE, COLOURS = 5 / 8, 256  # of pictures: small enough to be kept, and still sharp on a page


def publish(source: Path, name: str) -> None:
    """Copies tables and draws figures of a finished campaign.

    Args:
        source: its results folder.
        name: the folder in docs/campaigns/.
    """
    target = CAMPAIGNS / name
    (target / "figures").mkdir(parents=True, exist_ok=True)
    for file in ("cells.csv", "campaign.json"):
        shutil.copy(source / file, target / file)
    labels = grid_labels(json.loads((source / "campaign.json").read_text())["asked"])
    with TemporaryDirectory() as folder:
        runs, cells = pd.read_parquet(source / "runs.parquet"), pd.read_csv(source / "cells.csv")
        files = save_campaign_figures(runs, cells, Path(folder), labels=labels, pdf=True)
        drawn = [path for path in files if path.suffix == ".png"]
        maps = [path for path in drawn if path.stem.startswith("grid_map_")]
        for path in maps or [path for path in drawn if path.stem in FIGURES]:
            _save_small(path, target / "figures" / path.name)


def _save_small(drawn: Path, target: Path) -> None:
    """Saves a picture with fewer pixels and colours."""
    with Image.open(drawn) as image:
        size = round(image.width * SCALE), round(image.height * SCALE)
        small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    publish(Path(sys.argv[1]), sys.argv[2])
