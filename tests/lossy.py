"""nh_mini with friction at its wheel joints, written by changing its MJCF."""

from __future__ import annotations

from pathlib import Path

from nhtrack import assets

Loss = tuple[float, float]  # damping [N m s/rad], frictionloss [N m]


def write_lossy(folder: Path, left: Loss, right: Loss | None = None) -> str:
    """Returns the file of an nh_mini with losses at its wheels, the right one's as the left one's unless told."""
    text = assets.find_robot("nh_mini").read_text(encoding="utf-8")
    for side, (damping, dry) in (("left", left), ("right", right or left)):
        old = f'<joint name="{side}_wheel"/>'
        assert text.count(old) == 1
        text = text.replace(old, f'<joint name="{side}_wheel" damping="{damping}" frictionloss="{dry}"/>')
    file = folder / "lossy.xml"
    file.write_text(text, encoding="utf-8")
    return str(file)
