"""What pages tell a reader to do can be done: commands, links, and, in tutorials and a how-to, every step."""

from __future__ import annotations

import contextlib
import importlib
import io
import re
from functools import cache
from pathlib import Path
from types import ModuleType
from urllib.parse import unquote

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from nhtrack.cli import app

ROOT = Path(__file__).parents[2]
FOLLOWED = [*sorted(ROOT.glob("docs/tutorials/*.md")), ROOT / "docs/how-to/own_robot.md"]
PAGES = sorted(page for folder in ("", "docs/**/", "models/*/", "renders/") for page in ROOT.glob(f"{folder}*.md"))
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """What the tutorials are written with."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_generate")
    return importlib.import_module("session")


@cache
def options() -> dict[str, set[str]]:
    """The options of every command."""
    commands = get_command(app).commands  # type: ignore[attr-defined]
    return {
        name: {option for each in command.params for option in each.opts + each.secondary_opts}
        for name, command in commands.items()
    }


@every_page
def test_commands_exist_and_take_these_options(page: Path, session: ModuleType) -> None:
    text = page.read_text(encoding="utf-8")
    for name, *arguments in session.commands(text):
        assert name in options()
        assert {word for word in arguments if word.startswith("--")} <= options()[name], name
    for name in re.findall(r"`nhtrack ([a-z]+)", text):
        assert name in options()


@every_page
def test_links_lead_somewhere(page: Path) -> None:
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)\)", prose):
        if re.match(r"\w+:", target):
            continue
        found = page.parent / unquote(target) if target else page
        assert found.exists(), target
        assert not anchor or anchor in headings(found), f"{target}#{anchor}"


@cache
def headings(page: Path) -> set[str]:
    """The anchors of a page, as viewers of Markdown make them from its headings."""
    text = page.read_text(encoding="utf-8")
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    made = {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}
    return made | set(re.findall(r'<a id="([^"]+)"', text))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("```sh\nnhtrack run a --set \"b={c: 1}\"  # d\n```", [["run", "a", "--set", "b={c: 1}"]]),
        ("    .venv/bin/nhtrack list \\\n        --b   # e\n    make demo", [["list", "--b"]]),
        ("```yaml\nnhtrack: 1\n```\nnhtrack run x", []),
    ],
)
def test_commands_are_found(session: ModuleType, text: str, expected: list[list[str]]) -> None:
    assert session.commands(text) == expected


def printed_here(arguments: list[str], folder: Path) -> str:
    """Returns what Python prints that is given some arguments, without a process of its own."""
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as out:
        if arguments[0] == "-c":
            exec(arguments[1], {"__name__": "__main__"})
            return out.getvalue()
        done = CliRunner().invoke(app, arguments[2:], catch_exceptions=False)
    assert done.exit_code == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.parametrize("page", FOLLOWED, ids=lambda page: page.stem)
def test_a_page_can_be_followed(page: Path, session: ModuleType, tmp_path: Path) -> None:
    printed = list(session.perform(page, tmp_path, printed_here))
    text = page.read_text(encoding="utf-8")
    assert len(printed) == text.count("<!-- begin: ")
    assert all(printed)
    figures = re.findall(r"\]\(figures/(?:([\w-]+)-)?(\w+)\.png\)", text)
    assert figures
    for run, figure in figures:
        folder = tmp_path / "runs" / run / "figures" if run else tmp_path
        assert (folder / f"{figure}.png").is_file()
