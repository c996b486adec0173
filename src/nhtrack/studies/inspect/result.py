"""What is read from a robot's file, and what follows from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from nhtrack.laws import Limits
from nhtrack.presentation.numbers import cell
from nhtrack.presentation.result_table import ResultTable, TableRow
from nhtrack.robots.contract import Parts
from nhtrack.robots.diff_drive import DiffDrive


class Property(NamedTuple):
    """A number that is known of a robot.

    Attributes:
        part: what it is a property of.
        name: what it is.
        value: the number, in its unit.
        unit: its unit; `1` for none.
        source: what it was read from, or follows from.
    """

    part: str
    name: str
    value: float
    unit: str
    source: str


@dataclass(frozen=True, repr=False)
class Inspection:
    """What is read from a robot's file, and what follows from it.

    Attributes:
        name: of the robot.
        path: its MJCF file.
        parts: names of the parts that were found in it.
        drive: the reduced model.
        limits: motions within which wheels keep to a share of their friction and motors to their limits; None where
            there are none.
        friction: of the level floor that these limits are for [1].
        utilisation: the share of it [1].
    """

    name: str
    path: Path
    parts: Parts
    drive: DiffDrive
    limits: Limits | None
    friction: float
    utilisation: float

    @property
    def properties(self) -> tuple[Property, ...]:
        """All numbers, part by part."""
        return (*self._geometry(), *self._masses(), *self._motor(), *self._limits())

    @property
    def rows(self) -> list[dict[str, str | float]]:
        """Plain values for JSON."""
        return [each._asdict() for each in self.properties]

    @property
    def table(self) -> ResultTable:
        """A row for every number."""
        rows, part = list[TableRow](), ""
        for each in self.properties:
            cells = ("" if each.part == part else each.part, each.name, cell(each.value, each.unit), each.source)
            rows.append(TableRow(cells, begins=bool(part) and each.part != part))
            part = each.part
        headings = ("", "property", "value", "from")
        return ResultTable(f"{self.name}: {self.path}", headings, tuple(rows), frozenset({"", "property", "from"}))

    def __repr__(self) -> str:
        """Returns a one-line account."""
        return f"Inspection({self.name!r}, {self.drive.mass:.3g} kg, wheels {self.drive.wheel_radius:.3g} m)"

    def _repr_html_(self) -> str:
        """Returns what a notebook shows: the numbers, and a picture where there is one beside the file."""
        from nhtrack.presentation.notebook import NotebookView, html_of, picture_file

        picture = self.path.with_name(f"{self.name}.png")
        shown = [picture_file(picture, self.name)] if picture.is_file() else []
        lead = f"Two driven wheels ({', '.join(self.parts.tyres)}), standing on {', '.join(self.parts.casters)}."
        return html_of(NotebookView(self.name, lead=lead, figures=shown, tables=[self.table]))

    def _geometry(self) -> Iterator[Property]:
        drive, tyres = self.drive, ", ".join(self.parts.tyres)
        joints = ", ".join(self.parts.wheel_joints)
        yield Property("geometry", "wheel radius", drive.wheel_radius, "m", f"geoms {tyres}")
        yield Property("geometry", "wheel separation", 2 * drive.half_separation, "m", f"joints {joints}")
        for name, (x, y) in zip(self.parts.casters, drive.casters, strict=True):
            yield Property("geometry", "caster ahead of the axle", x, "m", f"geom {name}")
            yield Property("geometry", "caster left of the middle", y, "m", f"geom {name}")

    def _masses(self) -> Iterator[Property]:
        drive, inertia = self.drive, "mass matrix"
        yield Property("masses", "mass", drive.mass, "kg", inertia)
        for name, value in zip(("ahead of the axle", "left of the middle", "above the floor"), drive.com, strict=True):
            yield Property("masses", f"centre of mass {name}", value, "m", "bodies")
        yield Property("masses", "yaw inertia about the axle", drive.axle_inertia, "kg m²", inertia)
        yield Property("masses", "spin inertia of a wheel", drive.wheel_inertia, "kg m²", inertia)
        yield Property("masses", "of that, the geared rotor", drive.reflected_inertia, "kg m²", "armature")
        yield Property("reduced model", "mass felt by the motors", drive.m_eff, "kg", "m + 2 I_w / r²")
        yield Property("reduced model", "yaw inertia felt by the motors", drive.J_eff, "kg m²", "J + 2 I_w b² / r²")

    def _motor(self) -> Iterator[Property]:
        motor, names = self.drive.motor, ", ".join(self.parts.motors)
        yield Property("motors", "largest torque at a wheel", motor.torque_limit, "N m", f"ctrlrange of {names}")
        yield Property("motors", "stall torque", motor.stall_torque, "N m", "numeric motor_stall_torque")
        yield Property("motors", "speed without load", motor.no_load_speed, "rad/s", "numeric motor_no_load_speed")

    def _limits(self) -> Iterator[Property]:
        if self.limits is None:
            return
        source = f"{100 * self.utilisation:g} % of friction {self.friction:g}"
        units = {"speed": "m/s", "yaw_rate": "rad/s", "acceleration": "m/s²", "yaw_acceleration": "rad/s²"}
        for name, value in self.limits._asdict().items():
            yield Property("motion limits", name.replace("_", " "), value, units[name], source)
