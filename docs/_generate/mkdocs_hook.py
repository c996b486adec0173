"""Lets the site show pages that stand outside docs/, and makes links between all of them lead somewhere in it.

A hook of mkdocs. Pages are written for a viewer of the repository: their links are those between its files. Files that
are no pages are copied into the site beside the page that shows them, or, where they are only linked, into `files/`.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = ("CHANGELOG.md", "CONTRIBUTING.md", "models/*/README.md", "renders/README.md")
LINK = re.compile(r"(?<=\]\()(?!\w+:|#)([^)#\s]+)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages outside docs/, and what all pages link to."""
    for pattern in OUTSIDE:
        for page in sorted(ROOT.glob(pattern)):
            _add(files, config, page.relative_to(ROOT).as_posix())
    for file in list(files.documentation_pages()):
        for target in LINK.findall(_without_code(file.content_string)):
            linked = _target(file.src_uri, target)
            if files.get_file_from_path(_in_site(linked)) is None and (ROOT / linked).is_file():
                _add(files, config, linked)
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Returns a page's text with links to where their targets are in the site, and with Markdown inside of details."""

    def moved(match: re.Match[str]) -> str:
        target = _in_site(_target(page.file.src_uri, match[1]))
        return posixpath.relpath(target, posixpath.dirname(page.file.src_uri) or ".")

    folder = re.compile(r"\[([^]]+)\]\(([^)#\s]+)\)")
    markdown = folder.sub(lambda it: it[1] if (ROOT / _target(page.file.src_uri, it[2])).is_dir() else it[0], markdown)
    markdown = LINK.sub(moved, markdown).replace("<details>", '<details markdown="1">')
    return re.sub(r"(?<=\] )(?=\[[\w ]+\] \|)", r"\\", markdown)  # a unit after a list is no link


def _add(files: Files, config: MkDocsConfig, path: str) -> None:
    files.append(File.generated(config, _in_site(path), abs_src_path=str(ROOT / path)))


def _target(page: str, link: str) -> str:
    """Returns the path in the repository that a link of a page of the site speaks of."""
    home = f"docs/{page}" if not any(Path(page).match(pattern) for pattern in OUTSIDE) else page
    return posixpath.normpath(posixpath.join(posixpath.dirname(home), link))


def _in_site(path: str) -> str:
    """Returns where a file of the repository is in the site."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return path if path.endswith((".md", ".png", ".gif")) else f"files/{path}"


def _without_code(text: str) -> str:
    return re.sub(r"```.*?```", "", text, flags=re.DOTALL)
