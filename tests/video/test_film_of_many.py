"""The film of a comparison: every robot where its own recording has it, in the colour of its law, and named."""

from __future__ import annotations

import itertools
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from films import film, line_of, pixels_of, shared_scene
from nhtrack import se2, video
from nhtrack.colours import letter_colour, robot_colour
from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.simulation.scene import SceneSpec
from nhtrack.studies.compare.laws_file import load_laws
from nhtrack.studies.compare.result import Comparison, room_of
from nhtrack.studies.compare.run import compare_laws
from nhtrack.video import overlay, scene_renderer
from nhtrack.video import typography as letters
from nhtrack.video.together import together
from recordings import robot_names, synthetic_recording

pytestmark = [pytest.mark.slow, pytest.mark.render]

# A heading through half of its quaternion, and a position copied: a few roundings.
COPIED = 1e-12
SIZE = (640, 480)

Runs = dict[str, Recording]


@pytest.fixture(scope="module", params=["real", "virtual"])
def found(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """Two laws on wheels for a fifth of a second, one follower each, filmed small."""
    virtual = str(request.param == "virtual").lower()
    changes = ["duration=0.2", f"leader.virtual={virtual}", "video.size=[320, 240]", "video.fps=10"]
    scenario, laws = load_laws(lambda: load("tour/hello", changes), ["{name: kanayama, k_x: 0.3}"], load)
    return compare_laws(scenario, laws, tmp_path_factory.mktemp("film"), figures=False, report=False)


def test_every_robot_is_where_its_own_recording_has_it(found: Comparison) -> None:
    runs = found.recordings
    merged = together(runs, room_of(list(runs.values())))
    scene = shared_scene(merged.dataset.attrs["scene"])
    data = mujoco.MjData(scene.model)
    assert merged["qpos"].values.shape == (21, scene.model.nq)
    for row in range(0, 21, 5):
        data.qpos[:] = merged["qpos"].values[row]
        mujoco.mj_kinematics(scene.model, data)
        for name in scene.spec.bodies:
            label = name.removeprefix("follower-")
            run, own = (runs["published"], "leader") if name == "leader" else (runs[label], "follower")
            expected = run["pose"].sel(robot=own).values[row]
            body = data.body(f"{name}/")
            assert body.xpos[:2] == pytest.approx(expected[:2], abs=COPIED)
            rotation = body.xmat.reshape(3, 3)
            turned = np.arctan2(rotation[1, 0], rotation[0, 0]) - expected[2]
            assert float(se2.wrap(np.array([turned]))[0]) == pytest.approx(0.0, abs=COPIED)
    apart = merged["pose"].values[-1, 1, :2] - merged["pose"].values[-1, 2, :2]
    assert np.hypot(*apart) > 1e-3  # two laws, two places


def several(laws: int, followers: int = 1) -> Runs:
    """Returns runs whose followers stand apart at the end."""
    scene = SceneSpec(robot_names(followers)).to_json()
    runs = {}
    for k in range(laws):
        run = synthetic_recording(followers, backend="ideal", samples=41, scene=scene)
        run["pose"].values[:, 1:, 1] += 0.35 * (k + 1)
        runs[f"law-{k}"] = run
    return runs


def near(picture: np.ndarray, colour: str, distance: float) -> np.ndarray:
    """Returns where (height, width) a picture is within a distance of a colour, of 255 for each component."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], float)
    return np.asarray(np.linalg.norm(picture - wanted, axis=-1) < distance)


def test_robots_have_the_colours_of_their_laws_not_of_their_places() -> None:
    merged = together(several(2, followers=2), (-100, 100, -100, 100))
    scene, line, path = film(merged, SIZE)
    with scene_renderer.SceneRenderer(scene, replace(line, trails=()), path, SIZE) as drawn:
        picture = drawn.draw(len(line) - 1)
    seen = [len(pixels_of(picture, place)) for place in range(5)]
    assert min(seen[:3]) > 100
    assert seen[3] == seen[4] == 0  # what the third and the fourth follower would have by their places


@pytest.mark.parametrize("laws", [2, 7])
def test_the_legend_names_every_law_in_its_colour(laws: int) -> None:
    merged = together(several(laws), (-100, 100, -100, 100))
    line = line_of(merged)
    plain = np.full((480, 640, 3), 90, np.uint8)
    written = overlay.Overlay(merged, line, SIZE).write(plain, 0)
    panel = written[:400, : 640 - 180]  # without the map and the signs at the foot
    places = []
    for place in range(1, laws + 1):
        if place != 6:  # the edges of black letters are as grey as the sixth colour
            where = np.argwhere(near(panel, letter_colour(robot_colour(place)), 20))
            assert len(where) > 10
            places.append(tuple(np.median(where, axis=0)))
    for (above, left), (below, right) in itertools.pairwise(places):
        assert below > above + 10 or right > left + 100  # one below the other, in their order, or in the next column
    changed = np.argwhere((panel != 90).any(axis=-1))
    assert changed[:, 0].max() < 0.31 * 480  # the camera keeps robots below


def test_the_legend_tells_the_worst_of_a_law_and_whose_run_ended() -> None:
    runs = several(2, followers=3)
    short = synthetic_recording(3, backend="ideal", samples=41, stop=20.0, scene=SceneSpec(robot_names(3)).to_json())
    merged = together(runs | {"short": short}, (-100, 100, -100, 100))
    line = line_of(merged)
    over = overlay.Overlay(merged, line, SIZE)
    frame = len(line) - 1
    worst = np.hypot(*np.moveaxis(runs["law-0"]["error"].values[-1, 1:, :2], -1, 0)).max()
    told = over.error_lines(frame)
    assert [text.split("  ")[0] for text, _ in told] == ["worst of 3 followers", "law-0", "law-1", "short"]
    assert told[1] == (f"law-0  {letters.running_lengths([worst])[0]}", letter_colour(robot_colour(1)))
    assert told[3] == ("short  ended", letter_colour(robot_colour(3)))
    assert over.error_lines(0)[3][0] != "short  ended"


def test_a_film_of_one_run_has_the_colours_it_says() -> None:
    """By default those of its robots' places, as in recordings from before robots had colours."""
    spec = SceneSpec(robot_names(2))
    old = spec.to_json().replace(', "colours": []', "")
    assert "colours" not in old
    assert SceneSpec.from_json(old) == spec
    pictures = []
    for scene in (old, replace(spec, colours=(0, 1, 2)).to_json(), replace(spec, colours=(0, 2, 1)).to_json()):
        recording = synthetic_recording(2, backend="ideal", samples=11, scene=scene)
        pictures.append(next(iter(video.frames(recording, size=(320, 240), fps=1, quality="draft"))))
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])
