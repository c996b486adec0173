"""Does what the tutorials say, and writes into them what commands print and the figures that they draw.

Run as `python docs/_generate/generate_tutorials.py`. What the n-th block prints stands between markers called n; the
figure `<run>-<figure>.png` is that of the run of this name.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from pages import fill
from session import perform

TUTORIALS = Path(__file__).resolve().parents[1] / "tutorials"
FIGURE = re.compile(r"\]\((figures/([\w-]+)-(\w+)\.png)\)")


def main() -> None:
    """Does all tutorials, each in a folder of its own."""
    for page in sorted(TUTORIALS.glob("*.md")):
        with TemporaryDirectory() as name:
            folder = Path(name)
            printed = {str(index): f"```text\n{text}```" for index, text in enumerate(perform(page, folder), start=1)}
            fill(page, printed)
            for figure, run, drawn in FIGURE.findall(page.read_text(encoding="utf-8")):
                (TUTORIALS / figure).parent.mkdir(exist_ok=True)
                shutil.copy(folder / "runs" / run / "figures" / f"{drawn}.png", TUTORIALS / figure)


if __name__ == "__main__":
    main()
