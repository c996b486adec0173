"""One page that says how a run went: it opens offline, in any browser, and needs no other file."""

from nhtrack.report.page import Extras, render, write

__all__ = ["Extras", "render", "write"]
