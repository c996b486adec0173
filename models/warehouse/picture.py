"""Draws warehouse.png: three carts in the arena. Run `python models/warehouse/picture.py [FILE]`."""

import sys
from pathlib import Path

from nhtrack import gl

gl.choose_backend()  # before MuJoCo and dm_control look for a display

import imageio.v3 as iio  # noqa: E402
import mujoco  # noqa: E402
from dm_control import mjcf  # noqa: E402

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 720, 405
PLACES = {"#0072B2": (0.0, 0.0, 0.15), "#D55E00": (-0.70, 0.85, -0.30), "#009E73": (-0.60, -0.95, 0.55)}


def make_model() -> mujoco.MjModel:
    """Returns three carts in the arena, drawn finer than a video needs."""
    arena = mjcf.from_path(str(HERE.parent / "arena" / "scene.xml"))
    for index, (colour, (x, y, theta)) in enumerate(PLACES.items()):
        robot = mjcf.from_path(str(HERE / "robot.xml"))
        robot.model = f"robot_{index}"
        robot.find("joint", "root").remove()  # a free joint belongs to a top-level body: the frame
        robot.find("material", "accent").rgba = (*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), 1)
        frame = arena.worldbody.attach(robot)
        frame.pos, frame.euler = (x, y, 0.1), (0, 0, theta)
        frame.add("freejoint", name="root")
    model = mujoco.MjModel.from_xml_string(arena.to_xml_string(), arena.get_assets())
    quality = model.vis.quality
    quality.numslices, quality.numstacks, quality.offsamples, quality.shadowsize = 64, 24, 8, 8192
    return model


def main() -> None:
    """Draws the picture into the file named on the command line, or beside this script."""
    model = make_model()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = (-0.38, 0.02, 0.10), 2.5, 214, -21
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera)
        iio.imwrite(sys.argv[1] if len(sys.argv) > 1 else HERE / "warehouse.png", renderer.render())


if __name__ == "__main__":
    main()
