"""Prints the processor time of whole commands, each in a process of its own: python benchmarks/startup.py [--spells 3].

All but the first spell find compiled code and byte code in their caches; the least is told.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

COMMANDS = (
    ("run", "--help"),
    ("validate", "tour/hello"),
    ("run", "tour/hello", "--no-video", "--no-figures", "--no-report"),
    ("run", "tour/hello", "--no-video"),
    ("run", "paper/example1", "--no-video"),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spells", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for command in COMMANDS:
            spent = min(cost(command, Path(folder)) for _ in range(given.spells))
            print(f"{spent:6.2f} s  nhtrack {' '.join(command)}", flush=True)


def cost(command: tuple[str, ...], folder: Path) -> float:
    """Returns the processor time of a command and of all that it starts [s]."""
    before = os.times()
    subprocess.run([sys.executable, "-m", "nhtrack", *command], cwd=folder, check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


if __name__ == "__main__":
    main()
