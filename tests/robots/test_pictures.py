"""What can be seen of the bundled robots and the arena: colours, heading, turning wheels, the metric grid."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import imageio.v3 as iio
import mujoco
import numpy as np
import pytest

from nhtrack import assets
from nhtrack.simulation.robot_models import load_robot

pytestmark = [pytest.mark.slow, pytest.mark.render]

MODELS = Path(__file__).resolve().parents[2] / "models"
COLOURS = {"blue": (0.0, 0.45, 0.70), "orange": (0.84, 0.37, 0.0), "green": (0.0, 0.62, 0.45)}
SIDE = 400  # [pixels] of the pictures, which are square
REACH = 0.06  # [m] of nh_mini: places and cameras are scaled by a robot's reach over this one
TURN = 0.5  # [rad] of the wheel, no multiple of the period of three to nine spokes

# Draws all robots in a process of its own: MuJoCo binds its OpenGL at import, and other tests may have imported it. The
# script of the first picture is the first to ask for OpenGL, as it is when it runs alone.
DRAW = """
import json, runpy, sys
models, out, side, turn, colours, robots = map(json.loads, sys.argv[1:])
for name in robots:
    sys.argv = ["picture.py", f"{out}/{name}.png"]
    runpy.run_path(f"{models}/{name}/picture.py", run_name="__main__")
import mujoco, numpy as np
from pathlib import Path
from nhtrack.mjcf import parse_mjcf, read_mjcf
from nhtrack.simulation.robot_models import load_robot
for name, (radius, scale, height, *centre) in robots.items():
    arena = read_mjcf(Path(models, "arena/scene.xml"))
    arena.visual.quality.shadowsize = 1024
    for index, colour in enumerate(colours):
        robot = parse_mjcf(load_robot(name).mjcf)
        robot.model = f"r{index}"
        robot.find("joint", "root").remove()
        robot.find("material", "accent").rgba = (*colour, 1)
        frame = arena.worldbody.attach(robot)
        frame.pos = (0.1 * scale, (0.125 - 0.25 * index) * scale, radius)
        frame.add("freejoint", name="root")
    above, overhead = (2 * np.degrees(np.arctan(half * scale / height)) for half in (0.5, 0.1))
    over = (0.1 * scale + centre[0], -0.125 * scale + centre[1], height)
    for camera, pos, xyaxes, fovy in (
        ("above", (0, 0, height), (1, 0, 0, 0, 1, 0), above),
        ("overhead", over, (1, 0, 0, 0, 1, 0), overhead),
        ("aside", (0.1 * scale, 0.6 * scale, 0.06 * scale), (-1, 0, 0, 0, 0.05, 1), 20),
    ):
        arena.worldbody.add("camera", name=camera, mode="fixed", pos=pos, xyaxes=xyaxes, fovy=fovy)
    model = mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())
    data = mujoco.MjData(model)
    pictures = {}
    with mujoco.Renderer(model, side, side) as renderer:
        for key in ("above", "overhead", "r0/chase", "r2/onboard", "aside", "aside_turned"):
            data.joint("r0/left_wheel").qpos[0] = turn * (key == "aside_turned")
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, key.removesuffix("_turned"))
            pictures[key.split("/")[-1]] = renderer.render().copy()
    np.savez(f"{out}/{name}.npz", **pictures)
"""


class Seen(NamedTuple):
    """Three robots in a column, all facing +x: what they measure, and pictures of them as RGB floats in [0, 1]."""

    radius: float
    half_separation: float
    hull: np.ndarray  # [[x_min, y_min], [x_max, y_max]] of the hull in the chassis frame [m]
    top: float  # of the hull, above the floor [m]
    scale: float
    height: float  # of the cameras above the floor [m]
    pictures: dict[str, np.ndarray]

    @property
    def pixels_per_metre(self) -> float:
        """At floor level in the picture from above, whose side is `scale` metres."""
        return SIDE / self.scale

    def place(self, index: int) -> tuple[float, float]:
        """Where the axle midpoint of a robot is [m]."""
        return 0.1 * self.scale, (0.125 - 0.25 * index) * self.scale


def measure(name: str) -> tuple[float, float, np.ndarray, float]:
    """Wheel radius, half wheel separation, rectangle around the hull, its top above the floor [m]."""
    reading = load_robot(name)
    model, parts = mujoco.MjModel.from_xml_string(reading.mjcf), reading.parts
    hulls = [model.geom(name) for name in parts.collision_geoms if name not in (*parts.tyres, *parts.casters)]
    centre = np.array([geom.pos for geom in hulls])
    boxes = [geom.type[0] == mujoco.mjtGeom.mjGEOM_BOX for geom in hulls]  # the others are upright cylinders
    half = np.array([geom.size if box else geom.size[[0, 0, 1]] for geom, box in zip(hulls, boxes, strict=True)])
    lowest, highest = (centre - half).min(axis=0), (centre + half).max(axis=0)
    radius = float(model.geom("left_tyre").size[0])
    hull = np.array([lowest[:2], highest[:2]])
    return radius, float(model.body("left_wheel").pos[1]), hull, float(highest[2] + radius)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with every robot's picture of the readme, and its pictures for `Seen`."""
    out = tmp_path_factory.mktemp("pictures")
    sizes = {}
    for name in assets.robots():
        radius, _, hull, _ = measure(name)
        sizes[name] = (radius, *frame(hull), *hull.mean(axis=0))
    arguments = (str(MODELS), str(out), SIDE, TURN, list(COLOURS.values()), sizes)
    environment = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}
    subprocess.run([sys.executable, "-c", DRAW, *map(json.dumps, arguments)], env=environment, check=True)
    return out


def frame(hull: np.ndarray) -> tuple[float, float]:
    """Returns how much larger than nh_mini's a robot's scene is, and how high its cameras are [m]."""
    scale = float(np.abs(hull).max()) / REACH
    return scale, min(3 * scale, 12.0)  # farther away the arena is haze


def look(drawn: Path, name: str) -> Seen:
    radius, half_separation, hull, top = measure(name)
    with np.load(drawn / f"{name}.npz") as arrays:
        pictures = {key: arrays[key] / 255 for key in arrays.files}
    return Seen(radius, half_separation, hull, top, *frame(hull), pictures)


@pytest.fixture(scope="module", params=assets.robots())
def seen(request: pytest.FixtureRequest, drawn: Path) -> Seen:
    return look(drawn, request.param)


def of_colour(picture: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    """Mask of the saturated pixels whose colour points the same way as `colour`, bright or in shade."""
    length = np.linalg.norm(picture, axis=-1)
    cosine = picture @ np.array(colour) / (np.maximum(length, 1e-9) * np.linalg.norm(colour))
    return (cosine > 0.985) & (length > 0.2) & (np.ptp(picture, axis=-1) > 0.15)


def test_every_robot_wears_its_own_colour(seen: Seen) -> None:
    length, width = np.ptp(seen.hull, axis=0)
    for index, (name, colour) in enumerate(COLOURS.items()):
        mask = of_colour(seen.pictures["above"], colour)
        area = mask.sum() / seen.pixels_per_metre**2
        rows, _ = np.nonzero(mask)
        y = ((SIDE - 1) / 2 - rows.mean()) / seen.pixels_per_metre
        assert 0.05 < area / (length * width) < 0.9, name
        expected = seen.place(index)[1]
        outward = abs(expected) * seen.top / (seen.height - seen.top)  # by which the robot's top is seen displaced
        assert y == pytest.approx(expected, abs=0.01 * seen.scale + outward), name


def test_the_heading_can_be_told_from_afar(seen: Seen) -> None:
    """A robot of some ten pixels wears a mark, whiter than all else along its middle, ahead of its centre."""
    coarse = seen.pictures["overhead"].reshape(20, 20, 20, 20, 3).mean(axis=(1, 3))  # 0.2 of the scale
    places = (np.arange(20) - 9.5) * 0.01 * seen.scale
    middle = np.abs(places) < seen.half_separation / 2
    inside = np.abs(places) < np.ptp(seen.hull[:, 0]) / 2 - 0.01 * seen.scale  # by a pixel: no floor
    whiteness = coarse[middle].min(axis=-1).max(axis=0)
    ahead, behind = whiteness[inside & (places > 0)].max(), whiteness[inside & (places < 0)].max()
    assert ahead > behind + 0.2


def test_a_turning_wheel_is_seen_to_turn(seen: Seen) -> None:
    change = np.abs(seen.pictures["aside_turned"] - seen.pictures["aside"]).max(axis=-1)
    changed = change > 0.2
    rows, columns = np.nonzero(changed)
    distance = 0.475 * seen.scale - seen.half_separation
    wheel = 2 * seen.radius * SIDE / (2 * distance * np.tan(np.radians(10)))  # [pixels] across
    assert changed.sum() > 0.02 * np.pi / 4 * wheel**2
    assert np.ptp(rows) < wheel + 2  # nothing but the wheel
    assert np.ptp(columns) < wheel + 2


@pytest.mark.parametrize("name", assets.robots())
def test_the_picture_in_the_readme_can_be_drawn_again(name: str, drawn: Path) -> None:
    again, kept = iio.imread(drawn / f"{name}.png"), iio.imread(MODELS / name / f"{name}.png")
    assert again.shape == kept.shape == (405, 720, 3)
    assert np.abs(again.astype(float) - kept).mean() < 5  # of 255: same view, same light, whichever driver


# the arena ------------------------------------------------------------------------------------------------------------
