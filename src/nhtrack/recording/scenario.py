"""The scenario that a recording holds, read without running anything of it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple, NoReturn

from pydantic import ValidationError

from nhtrack.config.law_sections import FileLaw
from nhtrack.config.messages import shape_faults
from nhtrack.config.scenario import Scenario
from nhtrack.config.tree import dotted
from nhtrack.errors import RecordingError
from nhtrack.laws import LawError, laws
from nhtrack.section import Section

_STAND_IN = FileLaw.model_construct(file="")  # a law while the rest of a scenario is judged


class LawText(NamedTuple):
    """A law that is not the package's own, as a recording holds it; see `nhtrack.laws.Law.account`.

    Attributes:
        name: what tables call it.
        file: where it was.
        sha256: of its text.
        source: its text.
        gains: in robot units.
    """

    name: str
    file: str
    sha256: str
    source: str
    gains: Mapping[str, float]


class RecordedLaw(Section, extra="allow"):
    """The section of a law that is not the package's own: its keys as they were, none of its text is run.

    Its file may be gone or have changed, and a recording may be somebody else's: who looks at it runs no code of it.
    """

    __pydantic_extra__: dict[str, Any]

    def _refuse(self) -> NoReturn:
        raise LawError(
            f"law {getattr(self, 'name', None)!r} is not the package's own, and a recording's scenario is for reading; "
            "nhtrack.recording.rerun.load_recorded returns one that runs"
        )

    kind = limits = robot_gain = property(_refuse)


def read_scenario(text: str) -> Scenario:
    """Returns the scenario of a recording from its JSON text.

    A law that is not the package's own is a `RecordedLaw`.

    Raises:
        RecordingError: this version reads other scenarios; with every key that does not fit.
    """
    tree = json.loads(text)
    law = None if _is_own(tree.get("law")) else tree["law"]
    judged = tree if law is None else tree | {"law": _STAND_IN}
    try:
        scenario = Scenario.model_validate(judged)
    except ValidationError as error:
        faults = "; ".join(f"{dotted(path)}: {said}" for path, said in shape_faults(judged, error))
        raise RecordingError(f"the scenario of this recording is not one that this version reads: {faults}") from None
    return scenario if law is None else scenario.model_copy(update={"law": RecordedLaw(**law)})


def _is_own(law: Any) -> bool:
    """Returns whether a section is judged as one of the package's own laws, as one that is none is, too."""
    if not isinstance(law, Mapping) or "name" not in law:
        return True
    return "file" not in law and law["name"] in laws() and laws()[law["name"]].built_in
