"""What running an example of the paper leaves behind."""

from __future__ import annotations

from dataclasses import dataclass

from nhtrack.studies.paper.examples import Example, Runs


@dataclass(frozen=True)
class ExampleRuns:
    """An example and its runs.

    Attributes:
        example: which.
        wheels: runs on MuJoCo, empty where only the ideal model was asked for.
        ideal: runs on the ideal model.
    """

    example: Example
    wheels: Runs
    ideal: Runs

    @property
    def shown(self) -> Runs:
        """The runs that are drawn: on wheels where there are any."""
        return self.wheels or self.ideal
