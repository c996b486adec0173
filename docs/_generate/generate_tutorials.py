"""Does what tutorials and a how-to say, and writes into them what commands print and the figures that they draw.

Run as `python docs/_generate/generate_tutorials.py`. What the n-th block prints stands between markers called n; the
figure `<run>-<figure>.png` is that of the run of this name, and any other the file that a command wrote.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from pages import fill
from session import perform

DOCS = Path(__file__).resolve().parents[1]
PAGES = (*sorted(DOCS.glob("tutorials/*.md")), DOCS / "how-to/own_robot.md")
FIGURE = re.compile(r"\]\((figures/(?:([\w-]+)-)?(\w+)\.png)\)")


def main() -> None:
    """Does the pages that are named on the command line, or all of them, each in a folder of its own."""
    for page in [page for page in PAGES if page.stem in sys.argv[1:] or not sys.argv[1:]]:
        with TemporaryDirectory() as name:
            folder = Path(name)
            printed = {str(index): f"```text\n{text}```" for index, text in enumerate(perform(page, folder), start=1)}
            fill(page, printed)
            for figure, run, drawn in FIGURE.findall(page.read_text(encoding="utf-8")):
                source = folder / "runs" / run / "figures" if run else folder
                (page.parent / figure).parent.mkdir(exist_ok=True)
                shutil.copy(source / f"{drawn}.png", page.parent / figure)


if __name__ == "__main__":
    main()
