"""What is read from a robot's file, and what follows from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nhtrack.config.robot_section import RobotSection
from nhtrack.errors import RefusedError, RenderError
from nhtrack.laws import Limits
from nhtrack.presentation.numbers import counted
from nhtrack.presentation.result_table import ResultTable
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.kind import Reading
from nhtrack.simulation.guard import GuardFigure
from nhtrack.studies.inspect.tables import Property, elements_table, guard_table, numbers_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Inspection:
    """What is read from a robot's file, and what follows from it.

    Attributes:
        name: of the robot.
        robot: which, as a scenario has it.
        reading: the robot as it was read.
        guard: what its composed scene was asked, beside the reduced model.
        limits: motions within which wheels keep to a share of their friction and motors to their limits; None where
            there are none.
        friction: of the level floor that these limits are for [1].
        utilisation: the share of it [1].
        remarks: what else is to be said, a sentence each.
    """

    name: str
    robot: RobotSection
    reading: Reading
    guard: tuple[GuardFigure, ...]
    limits: Limits | None
    friction: float
    utilisation: float
    remarks: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The robot's file."""
        return self.reading.file.resolve()

    @property
    def drive(self) -> DiffDrive:
        """The reduced model."""
        return self.reading.model

    @property
    def parts(self) -> Parts:
        """Names of the parts of the robot in its standard form."""
        return self.reading.parts

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out or taken otherwise than the file has it, and what else is to be said, a sentence each."""
        return (*self.reading.notes, *self.remarks)

    @property
    def faults(self) -> tuple[str, ...]:
        """What the guard objects to, a sentence each: such a robot is not run."""
        return tuple(f"{self.path}: {each}" for each in self.guard if not each.holds)

    @property
    def properties(self) -> tuple[Property, ...]:
        """All numbers, part by part."""
        return (*self._geometry(), *self._masses(), *self._model(), *self._motor(), *self._limits())

    @property
    def rows(self) -> list[dict[str, str | float | None]]:
        """Plain values of the numbers; None for no limit."""
        return [each._asdict() | {"value": _finite(each.value)} for each in self.properties]

    @property
    def summary(self) -> dict[str, Any]:
        """Plain values of all there is, for JSON."""
        return {
            "robot": self.name,
            "file": str(self.path),
            "kind": self.reading.kind,
            "read from": dict(self.reading.sources),
            "notes": list(self.notes),
            "properties": self.rows,
            "guard": [
                asdict(each) | {"found": _finite(each.found), "holds": each.holds} for each in self.guard
            ],
        }  # fmt: skip

    @property
    def tables(self) -> tuple[ResultTable, ...]:
        """Elements that parts were read from, numbers, and what the guard found."""
        title = f"{self.name}: {self.reading.file}"
        return elements_table(title, self.reading), numbers_table(self.properties), guard_table(self.guard)

    @cached_property
    def figure(self) -> Figure:
        """The robot from above and from the side."""
        from nhtrack.studies.inspect.figure import robot_figure

        return robot_figure(self.reading)

    def save_figure(self, path: str | Path, *, pdf: bool = False) -> list[Path]:
        """Writes the picture of the robot and returns the files.

        Args:
            path: a PNG file; a PDF file gets a PNG beside it.
            pdf: whether to write for print, see `nhtrack.plots.files.save_figure`.

        Raises:
            RenderError: another kind of file.
        """
        from nhtrack.plots import save_drawn

        target = Path(path)
        if target.suffix not in ("", ".png", ".pdf"):
            raise RenderError(f"{target}: expected a file .png or .pdf")
        return save_drawn(self.name, {target.stem: self.figure}, target.parent, pdf=pdf or target.suffix == ".pdf")

    def write_scenario(self, path: str | Path) -> Path:
        """Writes a commented scenario to start from, with this robot at a pace that suits it, and returns its file.

        Raises:
            RefusedError: the file exists, or there is no motion within friction and motors.
        """
        from nhtrack.studies.inspect.scenario import write_scenario

        if self.limits is None:
            raise RefusedError("no scenario to start from: " + "; ".join(self.remarks))
        return write_scenario(self.robot, self.drive, Path(path), self.friction, self.utilisation)

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"Inspection({self.name!r}, {self.drive.mass:.3g} kg, wheels {self.drive.wheel_radius:.3g} m)"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: drawing, numbers, and a picture where there is one beside the file."""
        from nhtrack.presentation.notebook import NotebookView, drawing, html_of, picture_file

        picture = self.path.with_name(f"{self.name}.png")
        shown = [drawing(self.figure, f"{self.name} from above and from the side", 1.2)]
        shown += [picture_file(picture, self.name)] if picture.is_file() else []
        lead = f"Two driven wheels and {counted(len(self.parts.casters), 'caster')}, read from {self.path.name}."
        return html_of(NotebookView(self.name, lead=lead, figures=shown, tables=self.tables, notes=self.notes))

    def _geometry(self) -> Iterator[Property]:
        drive = self.drive
        yield Property("geometry", "wheel radius", drive.wheel_radius, "m", "tyres")
        yield Property("geometry", "wheel separation", 2 * drive.half_separation, "m", "where the tyres touch")
        for name, (x, y) in zip(self.parts.casters, drive.casters, strict=True):
            said = name.replace("_", " ")
            yield Property("geometry", f"{said} ahead of axle", x, "m", said)
            yield Property("geometry", f"{said} to the left", y, "m", said)

    def _masses(self) -> Iterator[Property]:
        drive, inertia = self.drive, "mass matrix"
        yield Property("masses", "mass", drive.mass, "kg", inertia)
        names = ("centre of mass, ahead", "centre of mass, left", "centre of mass, height")
        for name, value in zip(names, drive.com, strict=True):
            yield Property("masses", name, value, "m", "bodies")
        yield Property("masses", "yaw inertia about axle", drive.axle_inertia, "kg m²", inertia)
        yield Property("masses", "spin inertia of a wheel", drive.wheel_inertia, "kg m²", inertia)
        yield Property("masses", "of it, geared rotor", drive.reflected_inertia, "kg m²", "armature")
        for name, load in drive.support_loads().items():
            yield Property("masses", f"load at rest, {name}", float(load), "N", "supports")

    def _model(self) -> Iterator[Property]:
        drive, losses = self.drive, self.drive.losses
        yield Property("reduced model", "mass motors feel", drive.m_eff, "kg", "m + 2 I_w / r²")
        yield Property("reduced model", "yaw inertia motors feel", drive.J_eff, "kg m²", "J + 2 I_w b² / r²")
        for k, side in enumerate(("left", "right")):
            yield Property("reduced model", f"damping, {side} wheel", losses.damping[k], "N m s", f"{side} wheel")
            dry = losses.dry_friction[k]
            yield Property("reduced model", f"dry friction, {side} wheel", dry, "N m", f"{side} wheel")

    def _motor(self) -> Iterator[Property]:
        motor = self.drive.motor
        yield Property("motors", "largest wheel torque", motor.torque_limit, "N m", "motors")
        yield Property("motors", "stall torque", motor.stall_torque, "N m", "motors")
        yield Property("motors", "speed without load", motor.no_load_speed, "rad/s", "motors")
        yield Property("motors", "top speed", self.drive.top_speed, "m/s", "motors and losses")

    def _limits(self) -> Iterator[Property]:
        if self.limits is None:
            return
        source = f"{100 * self.utilisation:g} % of friction {self.friction:g}"
        units = {"speed": "m/s", "yaw_rate": "rad/s", "acceleration": "m/s²", "yaw_acceleration": "rad/s²"}
        for name, value in self.limits._asdict().items():
            yield Property("motion limits", name.replace("_", " "), value, units[name], source)


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
