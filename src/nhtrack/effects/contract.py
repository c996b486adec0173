"""What the file of a physical effect defines: its key in a scenario, what it changes, what is wrong with it.

An effect is a frozen dataclass in robot units, kept with every recording. It overrides the methods that it needs;
several effects change different things, so that their order does not matter. The engine does not know effects: it reads
what they change, the MJCF, the ground and the reduced model.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from nhtrack.arrays import Array
from nhtrack.ground import Ground
from nhtrack.section import Finding

if TYPE_CHECKING:  # what reads robots imports MuJoCo, which takes a while, and files are read without it
    from nhtrack.robots.contract import Parts
    from nhtrack.robots.diff_drive import DiffDrive


class Setting(NamedTuple):
    """What an effect's checks may look at before anything is built.

    Attributes:
        effects: all effects of the scenario.
        plant: reads the reduced model of the robots under all of them; raises RobotError where it cannot be read.
    """

    effects: tuple[Effect, ...]
    plant: Callable[[], DiffDrive]

    @property
    def holds_level(self) -> bool:
        """Whether something keeps the robots from leaning."""
        return any(effect.holds_level for effect in self.effects)


class RobotsAtRest(NamedTuple):
    """Robots with a body as they begin.

    Attributes:
        names: theirs, shape n.
        heading: theirs [rad], shape (n,).
        plant: their reduced model.
        ground: what they stand on.
        met: indices of the patches that they meet on their way.
    """

    names: tuple[str, ...]
    heading: Array
    plant: DiffDrive
    ground: Ground
    met: tuple[int, ...]


@dataclass(frozen=True)
class Effect:
    """A physical effect, in robot units.

    Attributes:
        key: its key in `physics`.
        field: type and pydantic field of that key; the default is a scenario without the effect.
        holds_level: whether it keeps robots from leaning.
        weighs: whether `edit_robot` changes masses, which the reduced model is then read from anew. Wheel torques are
            computed for them only where a scenario has `compensation: actual`.
    """

    key: ClassVar[str]
    field: ClassVar[tuple[Any, Any]]
    holds_level: ClassVar[bool] = False
    weighs: ClassVar[bool] = False

    @classmethod
    def of(cls, value: Any, length: float) -> Self | None:
        """Returns the effect of the value of its key, or None for a scenario without it.

        Args:
            value: of the type that `field` says, in scenario units.
            length: robot metres per scenario length unit.
        """
        raise NotImplementedError

    def ground(self, ground: Ground) -> Ground:
        """Returns what robots stand on; wheel torques are computed for it only under `compensation: actual`."""
        return ground

    def model(self, model: DiffDrive) -> DiffDrive:
        """Returns the reduced model of the robots, for predictions and wheel torques alike."""
        return model

    def edit_robot(self, robot: Any, parts: Parts, model: DiffDrive) -> None:
        """Changes the MJCF of one robot.

        Args:
            robot: its dm_control element.
            parts: names of its parts.
            model: its reduced model, without what weighs.
        """

    def edit_frame(self, frame: Any) -> None:
        """Changes how one robot hangs in the arena; the dm_control frame it is attached by has the joint `root`."""

    def edit_arena(self, arena: Any, ground: Ground) -> None:
        """Changes the MJCF around the robots, a dm_control element."""

    def findings(self, setting: Setting) -> Iterator[Finding]:
        """Yields why robots cannot be as the scenario has them; paths begin below the key.

        Raises:
            RobotError: the robot cannot be read; whoever asks knows already.
        """
        yield from ()

    def warnings(self, robots: RobotsAtRest) -> Iterator[str]:
        """Yields what it will do to robots that merely stand, in sentences."""
        yield from ()
