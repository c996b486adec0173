"""Names of files for what users have named."""

from __future__ import annotations

import re
from collections.abc import Iterable


def file_names(labels: Iterable[str]) -> dict[str, str]:
    """Returns a name for a file for every label; those that would be the same are numbered."""
    chosen: dict[str, str] = {}
    for label in labels:
        slug = name = re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_")
        number = 1
        while name in chosen.values():
            number += 1
            name = f"{slug}_{number}"
        chosen[label] = name
    return chosen
