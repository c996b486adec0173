"""One page that says how a command went: it opens offline, in any browser, and needs no other file.

`pages` has a module for each command; what these share is here: `page` (the file as a whole), `data`, `panels` and
`thin` (numbers to draw), `words` and `units` (sentences), `graph`, `keys` and `film`; `assets` are templates, styles
and scripts.
"""

from nhtrack.studies.run.report import Extras, render, write

__all__ = ["Extras", "render", "write"]
