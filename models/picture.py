"""Draws the picture of a robot's README: three of it in the arena, placed as the robot's own picture.py says."""

import sys
from pathlib import Path

from nhtrack import gl

gl.choose_backend()  # before MuJoCo looks for a display

import imageio.v3 as iio  # noqa: E402
import mujoco  # noqa: E402

from nhtrack.mjcf import parse_mjcf, read_mjcf  # noqa: E402
from nhtrack.simulation.robot_models import load_robot  # noqa: E402

WIDTH, HEIGHT = 720, 405


def draw(
    folder: Path,
    places: dict[str, tuple[float, float, float]],
    height: float,
    lookat: tuple[float, float, float],
    view: tuple[float, float, float],
) -> None:
    """Draws the picture into the file named on the command line, or into the robot's folder.

    Args:
        folder: of the robot.
        places: x [m], y [m] and heading [rad] of a robot by its colour `#RRGGBB`.
        height: of the axle above the floor [m].
        lookat: the point that the camera looks at [m].
        view: its distance [m], azimuth and elevation [degrees].
    """
    model = _model(folder, places, height)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.lookat, (camera.distance, camera.azimuth, camera.elevation) = lookat, view
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera)
        file = sys.argv[1] if len(sys.argv) > 1 else folder / f"{folder.name}.png"
        iio.imwrite(file, renderer.render())


def _model(folder: Path, places: dict[str, tuple[float, float, float]], height: float) -> mujoco.MjModel:
    """Returns the robots in the arena, drawn finer than a film needs."""
    arena = read_mjcf(folder.parent / "arena" / "scene.xml")
    for index, (colour, (x, y, theta)) in enumerate(places.items()):
        robot = parse_mjcf(load_robot(folder.name).mjcf)
        robot.model = f"robot_{index}"
        robot.find("joint", "root").remove()  # a free joint belongs to a top-level body: the frame
        robot.find("material", "accent").rgba = (*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), 1)
        frame = arena.worldbody.attach(robot)
        frame.pos, frame.euler = (x, y, height), (0, 0, theta)
        frame.add("freejoint", name="root")
    model = mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())
    quality = model.vis.quality
    quality.numslices, quality.numstacks, quality.offsamples, quality.shadowsize = 64, 24, 8, 8192
    return model
