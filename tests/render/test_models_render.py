"""What can be seen of nh_mini and the arena: colours, heading, turning wheels, the metric grid."""

import os
import subprocess
import sys
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

pytestmark = pytest.mark.slow

MODELS = Path(__file__).resolve().parents[2] / "models"
COLOURS = {"blue": (0.0, 0.45, 0.70), "orange": (0.84, 0.37, 0.0), "green": (0.0, 0.62, 0.45)}
SIDE = 1.0  # [m] side of the square that the camera above sees at floor level

# Drawn in a process of its own: MuJoCo binds its OpenGL at import, and other tests may have imported it.
DRAW = """
import sys
from nhtrack import gl
gl.choose_backend()
import mujoco, numpy as np
from dm_control import mjcf
models, out = sys.argv[1:3]
colours = np.array(sys.argv[3].split(","), float).reshape(-1, 3)
arena = mjcf.from_path(models + "/arena/scene.xml")
for index, colour in enumerate(colours):
    robot = mjcf.from_path(models + "/nh_mini/robot.xml")
    robot.model = f"r{index}"
    robot.find("joint", "root").remove()
    robot.find("material", "accent").rgba = (*colour, 1)
    frame = arena.attach(robot)
    frame.pos = (0.1, 0.125 - 0.25 * index, 0.03)
    frame.add("freejoint", name="root")
above = dict(mode="fixed", pos=(0, 0, 5), xyaxes=(1, 0, 0, 0, 1, 0), fovy=2 * np.degrees(np.arctan(0.1)))
arena.worldbody.add("camera", name="above", **above)
aside = dict(mode="fixed", pos=(0.1, 0.6, 0.06), xyaxes=(-1, 0, 0, 0, 0.05, 1), fovy=20)
arena.worldbody.add("camera", name="aside", **aside)
model = mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())
data = mujoco.MjData(model)
pictures = {}
def draw(key, camera, size):
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, *size) as renderer:
        renderer.update_scene(data, camera)
        pictures[key] = renderer.render().copy()
draw("above", "above", (400, 400))
draw("chase", "r0/chase", (480, 640))
draw("onboard", "r2/onboard", (240, 320))
draw("aside", "aside", (240, 320))
data.joint("r0/left_wheel").qpos[0] = np.pi / 3  # half of the spokes' period
draw("aside_turned", "aside", (240, 320))
np.savez(out, **pictures)
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """Three robots in a column at x = 0.1 m, all facing +x; RGB pictures as floats in [0, 1]."""
    out = tmp_path_factory.mktemp("pictures") / "pictures.npz"
    colours = ",".join(str(value) for colour in COLOURS.values() for value in colour)
    environment = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}
    subprocess.run([sys.executable, "-c", DRAW, str(MODELS), str(out), colours], env=environment, check=True)
    with np.load(out) as arrays:
        return {key: arrays[key] / 255 for key in arrays.files}


def of_colour(picture: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    """Mask of the saturated pixels whose colour points the same way as `colour`, bright or in shade."""
    length = np.linalg.norm(picture, axis=-1)
    cosine = picture @ np.array(colour) / (np.maximum(length, 1e-9) * np.linalg.norm(colour))
    return (cosine > 0.985) & (length > 0.2) & (np.ptp(picture, axis=-1) > 0.15)


def test_a_picture_is_a_picture(pictures: dict[str, np.ndarray]) -> None:
    assert pictures["chase"].shape == (480, 640, 3)
    for name, picture in pictures.items():
        assert picture.std() > 0.03, name


def test_every_robot_wears_its_own_colour(pictures: dict[str, np.ndarray]) -> None:
    pixels_per_metre = 400 / SIDE
    for index, (name, colour) in enumerate(COLOURS.items()):
        mask = of_colour(pictures["above"], colour)
        area = mask.sum() / pixels_per_metre**2
        rows, _ = np.nonzero(mask)
        y = (199.5 - np.median(rows)) / pixels_per_metre
        assert 0.003 < area < 0.012, name  # of a footprint of 0.011 m^2
        assert y == pytest.approx(0.125 - 0.25 * index, abs=0.01), name


def test_the_arrow_shows_the_heading_from_afar(pictures: dict[str, np.ndarray]) -> None:
    above = pictures["above"]
    coarse = above.reshape(80, 5, 80, 5, 3).mean(axis=(1, 3))  # a robot is 10 pixels long
    for index in range(3):
        y = 0.125 - 0.25 * index
        row, column = round(39.5 - 80 * y), round(39.5 + 80 * 0.1)
        robot = coarse[row - 3 : row + 4, column - 4 : column + 5]
        whiteness = np.where(np.ptp(robot, axis=-1) < 0.35, robot.min(axis=-1), 0.0)
        ahead, behind = whiteness[1:-1, 5:].max(), whiteness[1:-1, :4].max()
        assert ahead > 0.7, index
        assert ahead > behind + 0.2, index


def test_a_turning_wheel_is_seen_to_turn(pictures: dict[str, np.ndarray]) -> None:
    change = np.abs(pictures["aside_turned"] - pictures["aside"]).max(axis=-1)
    changed = change > 0.2
    rows, columns = np.nonzero(changed)
    assert changed.sum() > 150
    wheel = 0.06 * 240 / (2 * 0.425 * np.tan(np.radians(10)))  # [pixels] seen from 0.425 m
    assert np.ptp(rows) < wheel + 2  # nothing but the wheel
    assert np.ptp(columns) < wheel + 2


def test_grid_lines_cross_the_origin_every_half_metre(pictures: dict[str, np.ndarray]) -> None:
    brightness = pictures["above"].mean(axis=-1)
    profile = np.median(brightness[:60], axis=0)  # floor only: y > 0.35 m
    background = np.median(profile)
    lines = np.nonzero(profile > background + 0.04)[0]
    distance = np.abs(lines[:, None] - np.array([-0.5, 199.5, 399.5]))  # x = -0.5, 0, 0.5 m
    assert distance.min(axis=1).max() < 4
    assert distance[:, 1].min() < 2
    # Tiles are 0.25 m: shades swap at x = -0.25 and 0.25, between the lines.
    left, right = profile[10:90].mean(), profile[110:190].mean()
    assert abs(left - right) > 0.01
    assert np.ptp(profile[10:90]) < abs(left - right)
    assert np.ptp(profile[110:190]) < abs(left - right)


def test_the_picture_in_the_readme_can_be_drawn_again(tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}
    script = MODELS / "nh_mini" / "picture.py"
    subprocess.run([sys.executable, str(script), str(tmp_path / "again.png")], env=environment, check=True)
    again, kept = iio.imread(tmp_path / "again.png"), iio.imread(MODELS / "nh_mini" / "nh_mini.png")
    assert again.shape == kept.shape == (405, 720, 3)
    assert np.abs(again.astype(float) - kept).mean() < 5  # of 255: same view, same light, whichever driver
