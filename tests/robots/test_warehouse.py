"""The warehouse cart: its mass budget, wheel and motors against its README, the deck and what it may carry."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.simulation.robot_models import load_robot
from papers import numbers, of_boxes, readme_table

FOLDER = assets.find_robot("warehouse").parent
GRAVITY = 9.81
RPM = 2 * np.pi / 60

# The README gives masses to a gram and the file centres to ten digits: rounding of the last one, relative.
WRITTEN = 1e-9
# [m] and [kg m^2] of the chassis, whose inertia is written to twelve digits: some hundred rounded sums of order 10.
CENTRE, INERTIA = 1e-9, 1e-10
# Torques and speeds are written to nine digits or more.
MOTOR = 1e-9
# The README rounds loads [N] to one decimal, accelerations [m/s^2] and a height [m] to two.
SHOWN_NEWTON, SHOWN_ACCELERATION, SHOWN_HEIGHT = 0.051, 0.0051, 0.0051
# A support that keeps this share of the cart's weight with any payload is not about to lift.
LEAST_SHARE = 0.1


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(FOLDER / "robot.xml"))


@pytest.fixture(scope="module")
def drive() -> DiffDrive:
    return load_robot("warehouse").model


# reading the README ---------------------------------------------------------------------------------------------------


def motor_data() -> dict[str, list[float]]:
    return {row[0].split(" (")[0]: numbers(row[1]) for row in readme_table("warehouse", "Motors")}


def deck_data() -> dict[str, np.ndarray]:
    """Lengths in m, masses in kg."""
    scale = {"mm": 1e-3, "kg": 1.0}
    return {row[0]: np.array(numbers(row[1])) * scale[row[1].split()[-1]] for row in readme_table("warehouse", "Deck")}


def allowed_corners() -> list[tuple[float, float]]:
    """Corners of the rectangle for the payload's centre of mass, chassis frame [m]: front left first."""
    deck = deck_data()
    centre = deck["centre in the chassis frame"]
    half = deck["rectangle for the payload's centre of mass, about the deck's centre"] / 2
    return [(centre[0] + sx * half[0], centre[1] + sy * half[1]) for sx in (1, -1) for sy in (1, -1)]


# statics, worked out independently of the library ---------------------------------------------------------------------


def moments(model: mujoco.MjModel) -> tuple[float, np.ndarray]:
    """Mass [kg] and centre of mass in the chassis frame [m] of the cart alone."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(model.body_mass.sum()), np.array(data.subtree_com[model.body("chassis").id])


def loads(model: mujoco.MjModel, payload: float = 0.0, place: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Loads [N] on left tyre, right tyre, caster of the cart at rest with a payload [kg] over a place [m]."""
    mass, com = moments(model)
    b, c = float(model.body("left_wheel").pos[1]), float(model.geom("caster").pos[0])
    points = np.array([(0.0, b), (0.0, -b), (c, 0.0)])
    first = mass * com[:2] + payload * np.array(place)
    balance = np.vstack([np.ones(3), points.T])
    return GRAVITY * np.linalg.solve(balance, np.array([mass + payload, *first]))


def lifting_torque(model: mujoco.MjModel) -> float:
    """Braking torque [N m] of each wheel at which the caster leaves the floor.

    Pitch about the axle's ground point: m g d = (m h + 2 I / r) a, with the wheel's own inertia I; the rotor, which is
    felt at the wheel through the gear, turns too little to matter.
    """
    mass, com = moments(model)
    wheel, radius = model.body("left_wheel").inertia[1], model.geom("left_tyre").size[0]
    braking = -mass * GRAVITY * com[0] / (mass * (com[2] + radius) + 2 * wheel / radius)
    felt = mass + 2 * (wheel + model.joint("left_wheel").armature[0]) / radius**2
    return float(braking * radius * felt / 2)


# mass and motors ------------------------------------------------------------------------------------------------------


def test_the_mass_budget_in_the_readme_gives_the_inertia_in_the_mjcf(model: mujoco.MjModel) -> None:
    rows = readme_table("warehouse", "Mass budget of the chassis")
    mass = np.array([float(row[1]) for row in rows])
    at, size = (1e-3 * np.array([numbers(row[column]) for row in rows]) for column in (2, 3))
    com, inertia = of_boxes(mass, at, size)
    chassis, axes = model.body("chassis"), np.zeros(9)
    mujoco.mju_quat2Mat(axes, chassis.iquat)
    rotation = axes.reshape(3, 3)
    assert chassis.mass[0] == pytest.approx(mass.sum(), rel=WRITTEN)
    np.testing.assert_allclose(chassis.ipos, com, rtol=0, atol=CENTRE)
    np.testing.assert_allclose(rotation @ np.diag(chassis.inertia) @ rotation.T, inertia, rtol=0, atol=INERTIA)


def test_the_wheel_is_the_sum_of_its_rings(model: mujoco.MjModel) -> None:
    rows = readme_table("warehouse", "The wheel")
    mass = np.array([float(row[1]) for row in rows])
    outer, inner, width = 1e-3 * np.array([numbers(row[2]) for row in rows]).T
    squares = (outer**2 + inner**2) / 4
    spin, across = mass @ squares / 2, mass @ (3 * squares + width**2) / 12
    for side in ("left", "right"):
        wheel = model.body(f"{side}_wheel")
        assert wheel.mass[0] == pytest.approx(mass.sum(), rel=WRITTEN)
        np.testing.assert_allclose(wheel.inertia, [across, spin, across], rtol=WRITTEN)
    assert outer.max() / 2 == model.geom("left_tyre").size[0]


@pytest.mark.parametrize(
    ("ring", "density"), [("polyurethane tread", 1200.0), ("rim", 2700.0), ("web", 2700.0), ("hub", 2700.0)]
)
def test_a_ring_weighs_what_its_volume_does(ring: str, density: float) -> None:
    row = next(row for row in readme_table("warehouse", "The wheel") if row[0] == ring)
    outer, inner, width = 1e-3 * np.array(numbers(row[2]))
    assert float(row[1]) == pytest.approx(density * np.pi / 4 * (outer**2 - inner**2) * width, abs=0.51e-3)


def test_torque_and_speed_follow_from_motor_gear_and_terminal(model: mujoco.MjModel) -> None:
    data = motor_data()
    constant, ratio = data["torque constant"][0], data["gear ratio"][0]
    efficiency, speed = data["efficiency of the gear"][0], data["speed limit of the motor at 48 V"][0]
    rated_current = data["rated and largest current of the motor"][0]
    terminal = data["rated and largest current of the terminal"][0]
    rated = rated_current * constant * ratio * efficiency
    no_load = 48 / np.sqrt(2) * np.sqrt(3) / constant / ratio
    assert model.numeric("motor_no_load_speed").data[0] == pytest.approx(no_load, rel=MOTOR)
    stall = rated / (1 - speed * RPM / ratio / no_load)
    assert model.numeric("motor_stall_torque").data[0] == pytest.approx(stall, rel=MOTOR)
    limit = terminal * constant * ratio * efficiency
    assert terminal < rated_current
    assert limit < data["nominal and largest torque of the gear"][0]
    for side in ("left", "right"):
        np.testing.assert_allclose(model.actuator(f"{side}_motor").ctrlrange, [-limit, limit], rtol=MOTOR)


def test_the_armature_is_rotor_and_gear_felt_through_the_gear(model: mujoco.MjModel) -> None:
    data = motor_data()
    felt = 1e-4 * (data["rotor inertia"][0] + data["inertia of the gear at the motor"][0]) * data["gear ratio"][0] ** 2
    for side in ("left", "right"):
        assert model.joint(f"{side}_wheel").armature[0] == pytest.approx(felt, rel=WRITTEN)


def test_full_torque_neither_lifts_the_caster_nor_spins_the_wheels(model: mujoco.MjModel, drive: DiffDrive) -> None:
    limit = drive.motor.torque_limit
    assert lifting_torque(model) / limit == pytest.approx(5.5, abs=0.05)  # as the README says
    for sign in (1.0, -1.0):
        u_x, u_theta = drive.acceleration(np.zeros(()), np.zeros(()), sign * np.array([limit, limit]))
        assert abs(u_x) == pytest.approx(1.75, abs=SHOWN_ACCELERATION)
        used = drive.friction_utilisation(np.zeros(()), np.zeros(()), u_x, u_theta, friction=1.0)
        assert used.max() < 0.27 + SHOWN_ACCELERATION
    _, turning = drive.acceleration(np.zeros(()), np.zeros(()), np.array([-limit, limit]))
    assert turning == pytest.approx(4.88, abs=SHOWN_ACCELERATION)


# deck and payload -----------------------------------------------------------------------------------------------------


def test_the_deck_is_the_top_of_the_hull(model: mujoco.MjModel) -> None:
    deck, hull, radius = deck_data(), model.geom("hull"), model.geom("left_tyre").size[0]
    height = deck["height above the floor"][0]
    assert hull.pos[2] + hull.size[2] + radius == pytest.approx(height, rel=WRITTEN)
    mat = model.geom("deck")
    assert mat.pos[2] + mat.size[2] + radius == pytest.approx(height, rel=WRITTEN)
    np.testing.assert_allclose(mat.pos[:2], deck["centre in the chassis frame"], rtol=0, atol=CENTRE)
    np.testing.assert_allclose(2 * mat.size[:2], deck["size"], rtol=WRITTEN)


def test_the_rectangle_is_drawn_on_the_deck(model: mujoco.MjModel) -> None:
    corners = np.array(allowed_corners())
    front, rear = (model.geom(f"deck_line_{end}").pos[0] for end in ("front", "rear"))
    left, right = (model.geom(f"deck_line_{side}").pos[1] for side in ("left", "right"))
    np.testing.assert_allclose([front, rear], [corners[:, 0].max(), corners[:, 0].min()], rtol=0, atol=CENTRE)
    np.testing.assert_allclose([left, right], [corners[:, 1].max(), corners[:, 1].min()], rtol=0, atol=CENTRE)


def test_three_supports_stay_loaded_with_the_largest_payload_anywhere_in_the_rectangle(model: mujoco.MjModel) -> None:
    payload = deck_data()["largest payload"][0]
    weight = GRAVITY * model.body_mass.sum()
    corners = np.array(allowed_corners())
    grid = itertools.product(*np.linspace(corners.min(axis=0), corners.max(axis=0), 9).T)
    least = min(float(loads(model, payload, place).min()) for place in grid)
    assert least > LEAST_SHARE * weight
    assert least == pytest.approx(min(loads(model, payload, corner).min() for corner in allowed_corners()), rel=WRITTEN)


def test_the_loads_in_the_readme_are_those_of_statics(model: mujoco.MjModel) -> None:
    deck = deck_data()
    centre = tuple(deck["centre in the chassis frame"])
    front, rear = allowed_corners()[0], allowed_corners()[2]
    for row, place in zip(readme_table("warehouse", "Deck", 1), (centre, front, rear), strict=True):
        near, far, caster = loads(model, deck["largest payload"][0], place)
        printed = [numbers(cell)[0] for cell in row[1:]]
        np.testing.assert_allclose(printed, [caster, near, far], rtol=0, atol=SHOWN_NEWTON)


def test_full_braking_tips_no_ordinary_load_at_the_front(model: mujoco.MjModel, drive: DiffDrive) -> None:
    """Pitch about the axle's ground point as in `lifting_torque`, the payload a point at the height sought."""
    mass, com = moments(model)
    payload, place = deck_data()["largest payload"][0], allowed_corners()[0]
    radius, wheel = drive.wheel_radius, model.body("left_wheel").inertia[1]
    braking = 2 * drive.motor.torque_limit / radius / (drive.m_eff + payload)
    assert braking == pytest.approx(0.90, abs=SHOWN_ACCELERATION)
    held = -GRAVITY * (mass * com[0] + payload * place[0]) / braking - mass * (com[2] + radius) - 2 * wheel / radius
    assert held / payload - deck_data()["height above the floor"][0] == pytest.approx(0.47, abs=SHOWN_HEIGHT)


# in motion; that it rests and drives as the ideal one is tested of all robots alike ----------------------------------
