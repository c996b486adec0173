"""What a scenario file may say: every key, its type, its unit, its bounds.

These models are the single source of the JSON Schema (`nhtrack schema`) and of docs/scenario.md. They judge
one key at a time; what several keys mean together is judged in `nhtrack.config.checks`, and
`nhtrack.config.load` runs both.

"Scenario units" below are whatever length and time unit the file is written in; `similarity` maps them to
metres and seconds. Angles are radians everywhere.
"""

from __future__ import annotations

import math
import re
from importlib import import_module
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from nhtrack.config.law_sections import Law
from nhtrack.config.section import Section, fault
from nhtrack.references import Expression, Interpolation, ReferenceInputError

ROBOT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*\Z")


def _printable(name: str) -> str:
    if not name.strip() or not name.isprintable() or len(name) > 100:
        raise fault(f"expected a short printable name, got {name!r}")
    if any(mark in name for mark in "/\\") or name.startswith("."):
        raise fault(f"{name!r} names a results folder: leave out slashes and a leading dot")
    return name


def _robot_name(name: str) -> str:
    if not ROBOT_NAME.match(name):
        raise fault(f"expected a letter followed by letters, digits, '-' or '_', got {name!r}")
    return name


def _formula(text: str) -> str:
    try:
        Expression(text)
    except ReferenceInputError as error:
        raise fault(str(error)) from None
    return text


def _even(pixels: int) -> int:
    if pixels % 2:
        raise fault(f"video needs even sizes, got {pixels}")
    return pixels


def _values(*names: str) -> BeforeValidator:
    """Returns the validator that says by name which values a list of another length ought to have."""

    def counted(value: Any) -> Any:
        if isinstance(value, (list, tuple)) and len(value) != len(names):
            raise fault(f"expected {len(names)} values ({', '.join(names)}), got {len(value)}")
        return value

    return BeforeValidator(counted)


def _disc(disc: tuple[float, float, float]) -> tuple[float, float, float]:
    if not disc[2] > 0:
        raise fault(f"expected a positive radius, got {disc[2]:g}")
    return disc


def _rectangle(sides: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    x_min, x_max, y_min, y_max = sides
    if not (x_min < x_max and y_min < y_max):
        raise fault(f"expected x_min < x_max and y_min < y_max, got {list(sides)}")
    return sides


# YAML lists become tuples, which stay frozen; only the container is converted, never what is in it.
Pose: TypeAlias = Annotated[tuple[float, float, float], Field(strict=False)]
Place: TypeAlias = Annotated[tuple[float, float], Field(strict=False)]
Edge: TypeAlias = Annotated[float, Field(ge=0)]
Disc: TypeAlias = Annotated[
    tuple[float, float, float], Field(strict=False), _values("x", "y", "r"), AfterValidator(_disc)
]
Rectangle: TypeAlias = Annotated[
    tuple[float, float, float, float],
    Field(strict=False),
    _values("x_min", "x_max", "y_min", "y_max"),
    AfterValidator(_rectangle),
]
Edges: TypeAlias = Annotated[tuple[Edge, Edge, Edge], Field(strict=False), _values("x", "y", "z")]
Weight: TypeAlias = Annotated[float, Field(ge=0, le=1)]
PlanarTwist: TypeAlias = Annotated[tuple[float, float], Field(strict=False)]
RunName: TypeAlias = Annotated[str, AfterValidator(_printable)]
Name: TypeAlias = Annotated[str, AfterValidator(_robot_name)]
Backend: TypeAlias = Literal["mujoco", "ideal"]
Formula: TypeAlias = Annotated[str, AfterValidator(_formula)]
TimeScale: TypeAlias = Annotated[
    Annotated[float, Field(gt=0), Tag("<time>")] | Annotated[Literal["auto"], Tag("<auto>")],
    Discriminator(lambda value: "<auto>" if isinstance(value, str) else "<time>"),
]
Pixels: TypeAlias = Annotated[int, Field(ge=16, le=8192), AfterValidator(_even)]


class Similarity(Section):
    """Maps scenario units to the robot; robot and gravity do not scale, so this sets the friction demand."""

    length: float = Field(default=1.0, gt=0, description="robot metres per scenario length unit [m]")
    time: TimeScale = Field(
        default=1.0,
        description="robot seconds per scenario time unit [s]; `auto` takes the smallest at which, on the ideal model, "
        "friction stays within `friction_margin` and every motor within its limits",
    )
    friction_margin: float = Field(
        default=0.7,
        gt=0,
        le=1,
        description="share of the friction limit that `time: auto` and `nhtrack feasibility` let wheels use [1]",
    )

    @property
    def time_scale(self) -> float:
        """Robot seconds per scenario time unit.

        Raises:
            TypeError: the time is still `auto`; `nhtrack.studies.feasibility.run.with_time` makes it a number.
        """
        if self.time == "auto":
            raise TypeError("similarity.time: auto becomes a number by nhtrack.studies.feasibility.run.with_time")
        return self.time


class Contact(Section):
    """How wheels meet the floor."""

    model: Literal["stiff", "default"] = Field(
        default="stiff",
        description="`stiff` derives the contact parameters from the time step, so that turning slip "
        "vanishes with it; `default` keeps MuJoCo's own, which slip by centimetres per second",
    )
    rate_correction: bool = Field(
        default=True,
        description="supplies the term MuJoCo's contact rows leave out, as a bias inside the friction cone: "
        "it gives no grip on ice",
    )


class Patch(Section):
    """A region of the floor with a friction coefficient of its own: a disc or a rectangle."""

    friction: float = Field(ge=0, description="Coulomb friction coefficient of wheels on it [1]; ice has about 0.05")
    disc: Disc | None = Field(default=None, description="its centre and radius, [x, y, r] [scenario length]")
    rectangle: Rectangle | None = Field(
        default=None, description="its sides, [x_min, x_max, y_min, y_max] [scenario length]"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.disc is None) == (self.rectangle is None):
            raise fault("expected either `disc` or `rectangle`")
        return self


class Slope(Section):
    """An inclined floor. Poses are given in its plane; its normal is what robots take for upwards."""

    angle: float = Field(default=0.0, ge=0, lt=math.pi / 2, description="angle with the horizontal [rad]")
    uphill: float = Field(default=0.0, description="direction in which the floor rises, from the x axis [rad]")


class Payload(Section):
    """A box of uniform density that every robot carries; robot units, since robots do not scale."""

    mass: float = Field(gt=0, description="its mass [kg]")
    offset: Place = Field(
        default=(0.0, 0.0), description="its centre in the robot's frame: x ahead of the axle, y left of it [m]"
    )
    height: float = Field(ge=0, description="height of its centre above the floor [m]")
    size: Edges = Field(default=(0.0, 0.0, 0.0), description="its edges along x, y, z [m]; zeros make it a point")


class Motors(Section):
    """Limits of the wheel motors, in place of the robot's own; robot units."""

    torque_limit: float | None = Field(
        default=None, gt=0, description="largest torque at a wheel [N m]; null keeps the robot's own"
    )
    no_load_speed: float | None = Field(
        default=None, gt=0, description="wheel speed at which a motor gives no torque [rad/s]; null keeps the robot's"
    )


class Physics(Section):
    """How MuJoCo steps, and what the robots are up against."""

    timestep: float = Field(default=0.001, ge=1e-6, le=0.1, description="physics step on the robot's clock [s]")
    friction: float = Field(default=1.0, ge=0, description="Coulomb friction coefficient of wheels and floor [1]")
    patches: Annotated[tuple[Patch, ...], Field(strict=False)] = Field(
        default=(), description="regions with a friction of their own, such as ice; where they overlap the last counts"
    )
    slope: Slope = Field(default=Slope(), description="an inclined floor")
    payload: Payload | None = Field(default=None, description="what every robot carries")
    wheel_mismatch: float = Field(
        default=0.0,
        gt=-0.5,
        lt=0.5,
        description="how much larger the left wheel is than the right one, over the nominal radius [1]",
    )
    motors: Motors = Field(default=Motors(), description="limits of the wheel motors")
    compensation: Literal["nominal", "actual"] = Field(
        default="nominal",
        description="what wheel torques are computed for: `nominal`, the robot as its file has it on a level floor; "
        "`actual`, its payload and the slope as well",
    )
    base: Literal["free", "planar"] = Field(
        default="free",
        description="`free`: a body on two wheels and a caster that can tip; `planar`: held level, each wheel bearing "
        "half the weight, for large sweeps",
    )
    robot_contact: bool = Field(
        default=False,
        description="whether robots collide: off where followers end in the leader's place, on in formations",
    )
    contact: Contact = Field(default=Contact(), description="how wheels meet the floor")


class Start(Section):
    """Where a robot is at t = 0 and how it moves."""

    pose: Pose = Field(description="x, y [scenario length], theta [rad, unwrapped: pi and -pi are different starts]")
    twist: PlanarTwist = Field(
        default=(0.0, 0.0),
        description="forward speed v [scenario length/time] and turning speed omega [rad/scenario time]",
    )


class Segment(Section):
    """A piece of a piecewise input: `value` from the end of the piece before it until `until`."""

    until: float | None = Field(
        default=None,
        gt=0,
        description="end of the piece [scenario time]; the last piece may leave it out and hold for ever",
    )
    value: Annotated[float, Tag("<number>")] | Annotated[Formula, Tag("<formula>")] = Field(
        description="acceleration during the piece: a number or a formula in t, the time of the scenario",
        discriminator=Discriminator(lambda value: "<formula>" if isinstance(value, str) else "<number>"),
    )


def _increasing(segments: tuple[Segment, ...]) -> tuple[Segment, ...]:
    before = 0.0
    for i, segment in enumerate(segments):
        if segment.until is None:
            if i + 1 < len(segments):
                raise fault(f"segment {i + 1} of {len(segments)} needs `until`: only the last one may go without")
        elif segment.until <= before:
            raise fault(f"segments must end later and later: {segment.until:g} comes after {before:g}")
        else:
            before = segment.until
    return segments


def _signal_form(value: Any) -> str:
    if isinstance(value, str):
        return "<formula>"
    return "<segments>" if isinstance(value, (list, tuple)) else "<signal>"


Signal: TypeAlias = Annotated[
    Annotated[float, Tag("<signal>")]
    | Annotated[Formula, Tag("<formula>")]
    | Annotated[tuple[Segment, ...], Field(strict=False, min_length=1), AfterValidator(_increasing), Tag("<segments>")],
    Discriminator(_signal_form),
]


class SignalInput(Section):
    """The leader's input as two signals, each a number, a formula in t, or a list of segments."""

    u_x: Signal = Field(description="forward acceleration [scenario length/time^2]")
    u_theta: Signal = Field(description="angular acceleration [rad/scenario time^2]")


class CsvInput(Section):
    """The leader's input from a file; loading turns it into a table, so a recording carries the numbers."""

    csv: str = Field(
        min_length=1,
        description="CSV file with the columns t, u_x, u_theta named in its first line, found relative to the scenario",
    )
    interpolation: Interpolation = Field(
        default="previous", description="hold each row until the next, or join rows by lines"
    )


class Samples(Section):
    """Columns of equal length."""

    t: Annotated[tuple[float, ...], Field(strict=False, min_length=1)] = Field(
        description="increasing times [scenario time]"
    )
    u_x: Annotated[tuple[float, ...], Field(strict=False)] = Field(
        description="forward accelerations [scenario length/time^2]"
    )
    u_theta: Annotated[tuple[float, ...], Field(strict=False)] = Field(
        description="angular accelerations [rad/scenario time^2]"
    )


class TableInput(Section):
    """The leader's input as samples in the file itself."""

    table: Samples = Field(description="the samples")
    interpolation: Interpolation = Field(
        default="previous", description="hold each sample until the next, or join them by lines"
    )


def _input_form(value: Any) -> str:
    keys = value if isinstance(value, dict) else vars(value) if isinstance(value, BaseModel) else ()
    return "<csv>" if "csv" in keys else "<table>" if "table" in keys else "<signals>"


Input: TypeAlias = Annotated[
    Annotated[SignalInput, Tag("<signals>")]
    | Annotated[CsvInput, Tag("<csv>")]
    | Annotated[TableInput, Tag("<table>")],
    Discriminator(_input_form),
]


class Leader(Section):
    """The root of the network: drives open loop by its own input, on real wheels unless virtual."""

    name: Name = Field(default="leader", description="how followers and results call it")
    virtual: bool = Field(
        default=False, description="true: a moving marker that follows the input exactly, instead of a robot"
    )
    start: Start = Field(description="where it begins")
    input: Input = Field(description="its accelerations over time: two signals, a CSV file, or a table")


class Follower(Section):
    """A robot that tracks others."""

    name: Name = Field(description="how others and results call it")
    parents: Annotated[tuple[Name, ...], Field(strict=False, min_length=1)] = Field(
        description="the robots it tracks, by name; several are folded, in this order, into one virtual leader"
    )
    weights: Annotated[tuple[Weight, ...], Field(strict=False)] | None = Field(
        default=None,
        description="lambda of each fold, one fewer than the parents: 0 keeps what is folded so far, 1 takes the next "
        "parent; null gives every parent the same share [1]",
    )
    offset: Place = Field(
        default=(0.0, 0.0),
        description="its place in the frame of its (virtual) leader: x ahead, y left [scenario length]",
    )
    start: Start = Field(description="where it begins")


class Record(Section):
    """What of a run is kept."""

    every: int = Field(
        default=1,
        ge=1,
        description="every so many control periods a row is kept, and one at the end; what wheels did is then told of "
        "the period before each row only [1]",
    )


class Video(Section):
    """How the film of the run is made."""

    camera: Literal["group", "top", "isometric", "chase", "split"] = Field(
        default="group",
        description="`group` frames the robots as they move, `top` and `isometric` the whole run, "
        "`chase` follows the first follower, `split` is `group` beside a live plot of the errors",
    )
    size: Annotated[tuple[Pixels, Pixels], Field(strict=False)] = Field(
        default=(640, 480), description="width, height [pixels]"
    )
    fps: int = Field(default=30, ge=1, le=120, description="frames per second of film [1/s]")
    speed: float | None = Field(
        default=None,
        gt=0,
        description="robot seconds per second of film [1]; null picks one that keeps the film short",
    )
    quality: Literal["draft", "normal", "high"] = Field(
        default="normal",
        description="`draft` has no shadows and no antialiasing; `high` has twice the samples of `normal` and finer "
        "shadows, for more than 20 robots too",
    )


class Scenario(Section):
    """One experiment: who moves, by what law, on which ground, for how long."""

    name: RunName = Field(description="names the run and its results folder")
    description: str = Field(default="", description="one line for people, shown by `nhtrack list`")
    duration: float = Field(gt=0, description="how long the run lasts [scenario time]")
    similarity: Similarity = Field(default=Similarity(), description="scenario units to metres and seconds")
    backend: Backend = Field(
        default="mujoco",
        description="`mujoco`: wheels, friction, motors; `ideal`: the integrator the theory speaks of",
    )
    robot: str = Field(
        default="nh_mini",
        min_length=1,
        description="a bundled robot, or an MJCF file relative to the scenario file",
    )
    physics: Physics = Field(default=Physics(), description="how MuJoCo steps")
    control_rate: float = Field(default=100.0, gt=0, description="control periods per second on the robot's clock [Hz]")
    seed: int = Field(default=0, ge=0, description="seed of everything random [1]")
    leader: Leader = Field(description="the root of the network")
    followers: Annotated[tuple[Follower, ...], Field(strict=False, min_length=1)] = Field(
        description="the robots that track others"
    )
    virtual_leader: Literal["convex", "exact"] = Field(
        default="convex",
        description="twist of a virtual leader between several parents: `convex` combines theirs, as the paper prints "
        "it; `exact` differentiates the geodesic between them",
    )
    formation: Literal["printed", "exact"] = Field(
        default="printed",
        description="twist of a leader displaced by `offset`: `printed` as if its attitude stood still, as in the "
        "paper; `exact` with the attitude's motion",
    )
    law: Law = Field(description="the law every follower obeys, with gains in scenario units")
    record: Record = Field(default=Record(), description="what of the run is kept")
    video: Video = Field(default=Video(), description="how the film of the run is made")

    def _repr_html_(self) -> str:
        """Returns what a notebook shows of the scenario; what draws it stands in a room above, found by its name."""
        return str(import_module("nhtrack.studies.run.scenario_view").scenario_html(self))

    @property
    def periods(self) -> int:
        """Number of control periods: `duration` on the robot's clock, rounded to whole periods.

        Raises:
            TypeError: see `Similarity.time_scale`.
        """
        return max(1, round(self.duration * self.similarity.time_scale * self.control_rate))

    @property
    def parents(self) -> dict[str, tuple[str, ...]]:
        """Parents of every robot by name, root first; what `nhtrack.network.Network.from_parents` takes."""
        return {self.leader.name: ()} | {follower.name: follower.parents for follower in self.followers}

    @property
    def weights(self) -> dict[str, tuple[float, ...]]:
        """Fold weights of the followers that give them; what `nhtrack.network.Network.from_parents` takes."""
        return {follower.name: follower.weights for follower in self.followers if follower.weights is not None}
