"""One page that says how a command went: it opens offline, in any browser, and needs no other file.

Every study has a page of its own, in its folder; what they share is here: `page` (the file as a whole), `timed` (what
moves with time), `data`, `panels` and `downsample` (numbers to draw), `summary_text` (sentences), `graph`,
`scenario_listing` and `film`; `assets` are templates, styles and scripts.
"""
