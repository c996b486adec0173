"""What a page tells a reader to do: files to write and commands to give, in order; and the doing of it."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

_BLOCK = re.compile(r"(?:`(?P<name>[\w.]+)`:\n\n)?```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL)
_COMMAND = re.compile(r"^(?:\.venv/bin/)?(nhtrack .*)$", re.MULTILINE)


def commands(text: str) -> list[list[str]]:
    """Returns the arguments of every nhtrack command line that is shown as code in a page or a part of it."""
    text = text.replace("\\\n", " ")
    indented = re.findall(r"^    (.*)$", _BLOCK.sub("", text), re.MULTILINE)
    shown = [block["text"] for block in _BLOCK.finditer(text) if block["language"] == "sh"]
    return [shlex.split(line, comments=True)[1:] for part in (*shown, *indented) for line in _COMMAND.findall(part)]


def perform(page: Path, folder: Path, printed: Callable[[list[str], Path], str] | None = None) -> Iterator[str]:
    """Does in a folder what a page says, and yields what each block of commands prints.

    A block of code after a file's name and a colon is that file. Of the others those in `sh` are commands of nhtrack,
    those in `python` are run, and the rest is only shown.

    Args:
        page: a Markdown file.
        folder: where its reader is.
        printed: what Python prints that is given some arguments in a folder; by default in a process of its own.

    Raises:
        subprocess.CalledProcessError: a command failed.
    """
    printed = printed or _printed
    for block in _BLOCK.finditer(page.read_text(encoding="utf-8")):
        if block["name"] is not None:
            (folder / block["name"]).write_text(block["text"], encoding="utf-8")
        elif block["language"] == "python":
            yield printed(["-c", block["text"]], folder)
        elif block["language"] == "sh":
            yield "".join(printed(["-m", "nhtrack", *arguments], folder) for arguments in commands(block[0]))


def _printed(arguments: list[str], folder: Path) -> str:
    done = subprocess.run([sys.executable, *arguments], cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout
