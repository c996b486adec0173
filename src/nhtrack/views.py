"""What draws a result in a notebook: it stands in a room above the result's own, and is found by its name."""

from __future__ import annotations

from importlib import import_module

__all__ = ["drawn_by"]


def drawn_by(drawer: str, result: object) -> str:
    """Returns the HTML of a result.

    Args:
        drawer: full name of the function that makes it, such as `nhtrack.studies.run.view.recording_html`.
        result: its argument.
    """
    module, _, name = drawer.rpartition(".")
    return str(getattr(import_module(module), name)(result))
