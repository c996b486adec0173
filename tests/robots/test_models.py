"""Bundled robots and the arena: what every robot must satisfy, what nh_mini and burger promise besides, the arena."""

from __future__ import annotations

import tomllib
from typing import NamedTuple

import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.robots.contract import Parts
from nhtrack.simulation.robot_models import load_robot
from papers import MODELS, of_boxes, of_parts, readme_quantity, readme_table

ARENA = MODELS / "arena" / "scene.xml"
GRAVITY = 9.81
TYRES = ("left_tyre", "right_tyre")

# [m] by how much a drawn part may stand out of the hull: too little to be seen when two robots meet; the corners of
# nh_mini's drawn tyres do by 1.1 mm.
STANDING_OUT = 1.5e-3
# A README rounds; beyond its last digit, and beyond a thousandth, it is wrong.
ROUNDED = 1e-3


class Robot(NamedTuple):
    """A bundled robot as it is read, compiled, and its state at the reference configuration."""

    name: str
    parts: Parts
    model: mujoco.MjModel
    data: mujoco.MjData

    @property
    def radius(self) -> float:
        return float(self.model.geom("left_tyre").size[0])

    @property
    def half_separation(self) -> float:
        return float(self.model.body("left_wheel").pos[1])

    @property
    def com(self) -> np.ndarray:
        """Centre of mass of the whole robot in the chassis frame [m]."""
        return np.array(self.data.subtree_com[self.model.body("chassis").id])

    @property
    def mass_matrix(self) -> np.ndarray:
        """MuJoCo's own: root x, y, z, three rotations, left wheel, right wheel; shape (8, 8)."""
        matrix = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, matrix)
        return matrix

    @property
    def hulls(self) -> list[str]:
        return [name for name in self.parts.collision_geoms if name not in (*TYRES, *self.parts.casters)]

    @property
    def swinging(self) -> set[int]:
        """Bodies of casters that swivel."""
        parents = self.model.body_parentid
        wheels = [int(self.model.geom(name).bodyid[0]) for name in self.parts.rolling_casters]
        return {body for wheel in wheels for body in (wheel, int(parents[wheel]))}

    @property
    def caster(self) -> np.ndarray:
        """Where the casters stand, the middle of several [m]."""
        return np.mean([self.data.geom(name).xpos for name in self.parts.casters], axis=0)


def load(name: str, as_written: bool = False) -> Robot:
    reading = load_robot(name)
    file = (MODELS / name / "robot.xml").read_text()  # nothing but the text: none of these has files of its own
    model = mujoco.MjModel.from_xml_string(file if as_written else reading.mjcf)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Robot(name, reading.parts, model, data)


@pytest.fixture(scope="module", params=assets.robots())
def robot(request: pytest.FixtureRequest) -> Robot:
    return load(request.param)


@pytest.fixture(scope="module")
def nh_mini() -> Robot:
    return load("nh_mini", as_written=True)


@pytest.fixture(scope="module")
def burger() -> Robot:
    return load("burger", as_written=True)


# shapes and supports, worked out independently of the library ---------------------------------------------------------


def shape_of(model: mujoco.MjModel, name: str | int) -> str:
    """What a geom is: sphere, capsule, ellipsoid, cylinder or box."""
    return mujoco.mjtGeom(int(model.geom(name).type[0])).name.removeprefix("mjGEOM_").lower()


def half_extents(model: mujoco.MjModel, index: int) -> np.ndarray:
    """Half the size of a geom along its own axes [m], shape (3,)."""
    shape, size = shape_of(model, index), model.geom_size[index]
    if shape == "sphere":
        return np.full(3, size[0])
    if shape == "cylinder":
        return np.array([size[0], size[0], size[1]])
    if shape == "capsule":
        return np.array([size[0], size[0], size[1] + size[0]])
    assert shape in ("box", "ellipsoid"), model.geom(index).name
    return np.array(size)


def outline(robot: Robot, index: int) -> np.ndarray:
    """Points that a geom covers when seen from above, the outermost among them; chassis frame [m], shape (k, 2)."""
    angle = np.linspace(0, 2 * np.pi, 73)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    shape = shape_of(robot.model, index)
    if shape == "box":
        unit = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    elif shape == "cylinder":
        unit = np.vstack([np.column_stack([ring, np.full(len(ring), end)]) for end in (-1.0, 1.0)])
    else:  # ellipsoids, spheres, and of a capsule the ellipsoid that it contains
        unit = np.vstack([np.insert(ring, axis, 0.0, axis=1) for axis in range(3)])
    local = unit * half_extents(robot.model, index)
    return np.asarray((robot.data.geom_xpos[index] + local @ robot.data.geom_xmat[index].reshape(3, 3).T)[:, :2])


def distance_outside(robot: Robot, points: np.ndarray) -> np.ndarray:
    """How far points are outside the hull, seen from above [m], shape (k,); the hull is upright boxes and cylinders."""
    nearest = np.full(len(points), np.inf)
    for name in robot.hulls:
        geom = robot.model.geom(name)
        away = points - geom.pos[:2]
        if shape_of(robot.model, name) == "cylinder":
            outside = np.hypot(*away.T) - geom.size[0]
        else:
            outside = (np.abs(away) - geom.size[:2]).max(axis=1)
        nearest = np.minimum(nearest, outside)
    return nearest


def reach(robot: Robot) -> float:
    """How far the hull reaches from the axle midpoint [m]."""
    corners = [outline(robot, robot.model.geom(name).id) for name in robot.hulls]
    return float(np.hypot(*np.vstack(corners).T).max())


def support_loads(robot: Robot) -> np.ndarray:
    """Loads [N] on left tyre, right tyre, casters: three points carry a weight at the centre of mass."""
    points = np.array([*(robot.data.geom(name).xpos for name in TYRES), robot.caster])
    balance = np.vstack([np.ones(3), points[:, 0], points[:, 1]])
    return np.linalg.solve(balance, GRAVITY * robot.model.body_mass.sum() * np.array([1.0, *robot.com[:2]]))


def lifting_braking(robot: Robot) -> float:
    """Deceleration [m/s^2] at which the caster leaves the floor: m g d = (m h + 2 I_w / r) a."""
    matrix, r = robot.mass_matrix, robot.radius
    return float(-matrix[0, 0] * GRAVITY * robot.com[0] / (matrix[0, 0] * (robot.com[2] + r) + 2 * matrix[6, 6] / r))


def spinning_forward(robot: Robot) -> float:
    """Acceleration [m/s^2] at which the wheels spin on friction 1.

    The floor pushes the tyres with m a, at most their load: m a = m g - N, where the caster at c_x < 0 bears
    N = (m g d + (m h + 2 I_w / r) a) / |c_x|.
    """
    matrix, r = robot.mass_matrix, robot.radius
    mass, behind = matrix[0, 0], -robot.caster[0]
    pitching = mass * (robot.com[2] + r) + 2 * matrix[6, 6] / r
    return float(mass * GRAVITY * (1 + robot.com[0] / behind) / (mass + pitching / behind))


def sideways_tipping(robot: Robot) -> float:
    """Sideways acceleration [m/s^2] at which a robot tips over the line from a tyre to the caster, seen from above."""
    b, caster = robot.half_separation, robot.caster[0]
    normal = np.array([-b, -caster]) / np.hypot(b, caster)
    arm = normal @ (np.array([0.0, b]) - robot.com[:2])
    return float(GRAVITY * arm / (robot.com[2] + robot.radius))


def torque_for(robot: Robot, acceleration: float) -> float:
    """Torque [N m] of each wheel that accelerates a robot straight ahead without slip."""
    matrix, r = robot.mass_matrix, robot.radius
    return float(acceleration * r / 2 * (matrix[0, 0] + 2 * matrix[6, 6] / r**2))


# structure ------------------------------------------------------------------------------------------------------------


def test_a_robot_comes_with_its_papers(robot: Robot) -> None:
    for file in ("README.md", "CHANGELOG.md", "picture.py", f"{robot.name}.png"):
        assert (MODELS / robot.name / file).is_file(), file
    readme = (MODELS / robot.name / "README.md").read_text()
    assert f"]({robot.name}.png)" in readme
    assert "What is left out" in readme


def test_the_hull_clears_the_floor_and_encloses_the_robot(robot: Robot) -> None:
    for name in robot.hulls:
        hull = robot.model.geom(name)
        assert shape_of(robot.model, name) in ("box", "cylinder")
        np.testing.assert_array_equal(hull.quat, [1, 0, 0, 0])
        assert hull.pos[2] - half_extents(robot.model, hull.id)[2] > -robot.radius + 0.005
    for name in TYRES:
        assert distance_outside(robot, outline(robot, robot.model.geom(name).id)).max() < 0, name
    for index in range(robot.model.ngeom):
        if robot.model.geom_bodyid[index] not in robot.swinging:  # they swing out and back in
            assert distance_outside(robot, outline(robot, index)).max() < STANDING_OUT, robot.model.geom(index).name


def test_only_named_primitives_collide(robot: Robot) -> None:
    model = robot.model
    colliding = {model.geom(i).name for i in range(model.ngeom) if model.geom_contype[i] or model.geom_conaffinity[i]}
    assert robot.hulls
    assert colliding == {*TYRES, *robot.parts.casters, *robot.hulls}
    for index in range(model.ngeom):
        geom = model.geom(index)
        assert geom.name
        assert (geom.group == 3) == (geom.name in colliding), geom.name


def test_the_robot_is_its_own_mirror_image(robot: Robot) -> None:
    model, data = robot.model, robot.data

    def shape(index: int, mirror: np.ndarray) -> tuple[float, ...]:
        axes = mirror @ data.geom_xmat[index].reshape(3, 3)
        spread = axes @ np.diag(half_extents(model, index) ** 2) @ axes.T  # the same for every way to write a shape
        place = mirror @ data.geom_xpos[index]
        numbers = np.round([*place, *(1e3 * spread[np.triu_indices(3)])], 9) + 0.0  # + 0.0 turns -0.0 into 0.0
        return (float(model.geom_type[index]), float(model.geom_matid[index]), *numbers)

    everything = range(model.ngeom)
    across = np.diag([1.0, -1.0, 1.0])
    assert sorted(shape(i, across) for i in everything) == sorted(shape(i, np.eye(3)) for i in everything)
    mirror = np.diag([1, -1, 1, -1, 1, -1, 0, 0])
    mirror[6, 7] = mirror[7, 6] = 1
    matrix = robot.mass_matrix[:8, :8]
    np.testing.assert_allclose(mirror @ matrix @ mirror, matrix, rtol=0, atol=1e-15 * max(1.0, np.abs(matrix).max()))


def test_a_robot_can_be_recoloured_and_looked_at(robot: Robot) -> None:
    assert np.sum(robot.model.geom_matid == robot.model.material("accent").id) >= 5
    assert {robot.model.camera(i).name for i in range(robot.model.ncam)} == {"chase", "onboard"}


def test_one_camera_follows_the_robot_and_one_looks_out_of_it(robot: Robot) -> None:
    chase, onboard = robot.data.camera("chase"), robot.data.camera("onboard")
    ahead = -chase.xmat.reshape(3, 3)[:, 2]
    off_axis = np.arccos(ahead @ -chase.xpos / np.linalg.norm(chase.xpos))
    assert off_axis < np.radians(robot.model.camera("chase").fovy[0] / 2)  # the axle midpoint is in the picture
    assert ahead[0] > 0.7
    assert chase.xpos[0] < -reach(robot)
    ahead = -onboard.xmat.reshape(3, 3)[:, 2]
    assert ahead[0] > 0.95
    start = onboard.xpos + 0.02 * ahead  # the arena's near clipping plane
    drawn = np.array([0, 0, 1, 0, 0, 0], dtype=np.uint8)
    hit = mujoco.mj_ray(robot.model, robot.data, start, ahead, drawn, 1, -1, np.zeros(1, np.int32))
    assert hit == -1  # nothing of the robot's own is in front


# mass, statics, motors ------------------------------------------------------------------------------------------------


def triple(cell: str) -> np.ndarray:
    return np.array([float(value) for value in cell.split(",")])


def chassis_inertia(robot: Robot) -> np.ndarray:
    chassis, axes = robot.model.body("chassis"), np.zeros(9)
    mujoco.mju_quat2Mat(axes, chassis.iquat)
    return np.asarray(axes.reshape(3, 3) @ np.diag(chassis.inertia) @ axes.reshape(3, 3).T)


def test_the_numbers_in_the_readme_are_the_numbers_of_the_mjcf(robot: Robot) -> None:
    matrix, r, b = robot.mass_matrix, robot.radius, robot.half_separation
    spin = 2 * matrix[6, 6] / r**2
    expected = {
        "r": r,
        "b": b,
        "m": matrix[0, 0],
        "-d": -robot.com[0],
        "h": robot.com[2] + r,
        "J_axle": matrix[5, 5],
        "m_eff": matrix[0, 0] + spin,
        "J_eff": matrix[5, 5] + spin * b**2,
    }
    printed = {row[1]: row[2] for row in readme_table(robot.name, "Numbers")}
    for symbol, value in expected.items():
        assert symbol in printed, symbol
        number, half_unit = readme_quantity(printed[symbol])
        assert abs(number - value) <= min(1.001 * half_unit, ROUNDED * value), symbol


def test_the_weight_rests_on_three_points(robot: Robot) -> None:
    loads = support_loads(robot)
    weight = GRAVITY * robot.model.body_mass.sum()
    assert loads[0] == pytest.approx(loads[1], rel=1e-12)
    assert loads.sum() == pytest.approx(weight, rel=1e-12)
    assert loads[0] > 0
    assert 0.05 < loads[2] / weight < 0.40


# three together -------------------------------------------------------------------------------------------------------


# nh_mini --------------------------------------------------------------------------------------------------------------


def test_the_mass_budget_of_nh_mini_gives_the_inertia_in_the_mjcf(nh_mini: Robot) -> None:
    rows = readme_table("nh_mini", "Mass budget of the chassis")
    mass = 1e-3 * np.array([float(row[1]) for row in rows])
    at, size = (1e-3 * np.array([triple(row[column]) for row in rows]) for column in (2, 3))
    com, inertia = of_boxes(mass, at, size)
    chassis = nh_mini.model.body("chassis")
    assert chassis.mass[0] == pytest.approx(mass.sum(), rel=1e-9)
    np.testing.assert_allclose(chassis.ipos, com, rtol=0, atol=1e-9)
    np.testing.assert_allclose(chassis_inertia(nh_mini), inertia, rtol=0, atol=1e-12)


def test_a_wheel_of_nh_mini_is_a_solid_disc(nh_mini: Robot) -> None:
    mass, radius, width = 0.01134, 0.03, 0.008
    disc = [mass * (3 * radius**2 + width**2) / 12, mass * radius**2 / 2]
    wheel = nh_mini.model.body("left_wheel")
    assert nh_mini.radius == radius
    assert wheel.mass[0] == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(wheel.inertia, [disc[0], disc[1], disc[0]], rtol=1e-12)


def test_the_motors_of_nh_mini_are_the_gearmotor_of_the_readme(nh_mini: Robot) -> None:
    stall = nh_mini.model.numeric("motor_stall_torque").data[0]
    no_load = nh_mini.model.numeric("motor_no_load_speed").data[0]
    assert stall == pytest.approx(0.01 * 9.80665, rel=1e-12)  # 1.0 kgf cm
    assert no_load == pytest.approx(450 * 2 * np.pi / 60, rel=1e-12)
    assert nh_mini.model.actuator("left_motor").ctrlrange[1] == pytest.approx(0.4 * stall, rel=1e-12)


def test_the_motors_of_nh_mini_can_drive_but_not_lift_the_caster(nh_mini: Robot) -> None:
    torque = nh_mini.model.actuator("left_motor").ctrlrange[1]
    no_load = nh_mini.model.numeric("motor_no_load_speed").data[0]
    stall = nh_mini.model.numeric("motor_stall_torque").data[0]
    acceleration = torque / torque_for(nh_mini, 1.0)
    assert nh_mini.radius * no_load * (1 - torque / stall) > 0.8  # [m/s] up to which the limit can be held
    assert 3.0 < acceleration < lifting_braking(nh_mini)


def test_a_sideways_push_slides_nh_mini_before_it_tips(nh_mini: Robot) -> None:
    assert sideways_tipping(nh_mini) > GRAVITY  # friction 1 lets go at one g


# burger ---------------------------------------------------------------------------------------------------------------


def test_the_chassis_of_burger_is_base_lidar_and_caster(burger: Robot) -> None:
    rows = readme_table("burger", "Inertia of the chassis")
    mass = np.array([float(row[1]) for row in rows])
    at = 1e-3 * np.array([triple(row[2]) for row in rows])
    own = np.zeros((len(rows), 3, 3))
    for tensor, row in zip(own, rows, strict=True):
        xx, yy, zz, xz = [float(value) for value in row[3].split(",")]
        tensor[:] = [[xx, 0, xz], [0, yy, 0], [xz, 0, zz]]
    com, inertia = of_parts(mass, at, own)
    chassis = burger.model.body("chassis")
    assert chassis.mass[0] == pytest.approx(mass.sum(), rel=1e-9)
    np.testing.assert_allclose(chassis.ipos, com, rtol=0, atol=1e-9)
    np.testing.assert_allclose(chassis_inertia(burger), inertia, rtol=0, atol=1e-11)


def test_the_parts_of_burger_bear_out_the_base_s_centre_and_inertia() -> None:
    base = readme_table("burger", "Inertia of the chassis")[0]
    rows = readme_table("burger", "Mass budget of the base")
    mass = 1e-3 * np.array([float(row[1]) for row in rows])
    at, size = (1e-3 * np.array([triple(row[column]) for row in rows]) for column in (2, 3))
    com, inertia = of_boxes(mass, at, size)
    published = triple(base[3])
    assert mass.sum() == pytest.approx(float(base[1]), rel=1e-9)
    np.testing.assert_allclose(com, 1e-3 * triple(base[2]), rtol=0, atol=0.5e-4)  # rounded to 0.1 mm
    np.testing.assert_allclose(np.diag(inertia) / published[:3], [1.09, 1.10, 1.06], rtol=0, atol=0.005)


def test_burger_has_the_servo_of_the_readme_and_all_of_its_torque(burger: Robot) -> None:
    printed = {row[0]: readme_quantity(row[1])[0] for row in readme_table("burger", "Motors")}
    model = burger.model
    no_load = model.numeric("motor_no_load_speed").data[0]
    assert model.numeric("motor_stall_torque").data[0] == printed["stall torque"] == 1.4
    assert model.actuator("left_motor").ctrlrange[1] == printed["torque limit (`ctrlrange`)"] == 1.4
    assert no_load == pytest.approx(57 * 2 * np.pi / 60, rel=1e-12)
    assert no_load == pytest.approx(printed["no-load speed"], abs=0.0005)


def test_the_floor_gives_way_long_before_the_servos_of_burger(burger: Robot) -> None:
    limit = burger.model.actuator("left_motor").ctrlrange[1]
    assert spinning_forward(burger) == pytest.approx(3.19, abs=0.005)  # [m/s^2], as the README says
    assert lifting_braking(burger) == pytest.approx(3.58, abs=0.005)
    assert sideways_tipping(burger) == pytest.approx(4.6, abs=0.05)
    assert torque_for(burger, lifting_braking(burger)) < 0.05 * limit
    assert limit / torque_for(burger, 1.0) == pytest.approx(81.6, abs=0.05)


# the arena ------------------------------------------------------------------------------------------------------------


def test_the_arena_compiles_alone() -> None:
    arena = mujoco.MjModel.from_xml_path(str(ARENA))
    floor = arena.geom("floor")
    assert shape_of(arena, "floor") == "plane"
    np.testing.assert_array_equal(floor.size[:2], [0, 0])  # endless
    assert floor.pos[2] == 0
    assert arena.material("floor").reflectance == 0
    key = arena.light("key")
    assert key.type == mujoco.mjtLightType.mjLIGHT_SPOT
    assert key.castshadow
    assert arena.vis.global_.offwidth >= 1920
    assert arena.vis.global_.offheight >= 1080


def test_the_models_travel_with_the_package() -> None:
    project = tomllib.loads((MODELS.parent / "pyproject.toml").read_text())
    assert "models" in project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
