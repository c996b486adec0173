"""Films: what the frames show, measured in their pixels, and the files they become."""

from __future__ import annotations

import multiprocessing
from dataclasses import replace

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from films import SMALL, film, filmable, line_of, parted, pixels_of, projected
from nhtrack import gl, video
from nhtrack.errors import RecordingError, RenderError, RobotError
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.video import (
    bodies,
    camera,
    encode,
    frame_renderer,
    overlay,
    render_options,
    render_pool,
    scene_renderer,
    timeline,
)
from nhtrack.video import (
    typography as letters,
)
from recordings import synthetic_recording

pytestmark = pytest.mark.render

DRAFT = render_options.QUALITIES["draft"]

# --- times and states -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("duration", "speed"), [(1.0, 1), (25.0, 1), (26.0, 2), (80.0, 4), (800.0, 40), (9000.0, 400)])
def test_speed_is_the_slowest_round_one_that_keeps_the_film_short(duration, speed):
    assert timeline.pick_speed(duration) == speed


def test_frames_are_evenly_spaced_and_interpolated():
    recording = filmable(samples=161)  # one sample every half second
    scene = make_scene(SceneSpec.from_json(recording.dataset.attrs["scene"]))
    line = timeline.make_timeline(recording, scene, fps=30, speed=3.0)
    assert len(line) == int(80 / 3 * 30) + 1
    assert np.diff(line.time) == pytest.approx(0.1)
    pose = recording["pose"].values
    assert line.pose[5] == pytest.approx(pose[1])  # t = 0.5 s is a sample
    assert line.pose[7] == pytest.approx(0.6 * pose[1] + 0.4 * pose[2])


def test_recorded_coordinates_are_replayed_and_stay_on_the_quaternion_sphere():
    plain = filmable(samples=41)
    scene = make_scene(SceneSpec.from_json(plain.dataset.attrs["scene"]))
    qpos = scene.qpos_of(plain["pose"].values, np.zeros((41, 2, 2)))
    plain.dataset["qpos"] = (("time", "coordinate"), qpos)
    line = timeline.make_timeline(plain, scene, fps=10, speed=4.0)
    assert line.qpos[::5] == pytest.approx(qpos[::1], abs=1e-12)
    roots = scene.addresses.root_qpos
    for root in roots:
        assert np.linalg.norm(line.qpos[:, root + 3 : root + 7], axis=-1) == pytest.approx(1.0, abs=1e-12)


def test_wheels_turn_where_only_their_speed_is_known():
    recording = filmable(samples=401)
    scene, line, _ = film(recording)
    wheels = line.qpos[:, scene.addresses.wheel_qpos]
    step = np.hypot(*np.diff(recording["pose"].values[:, 0, :2], axis=0).T)
    travelled = wheels[-1, 0].mean() * 0.016  # the formula's wheel radius
    assert travelled == pytest.approx(step.sum(), rel=1e-3)


def test_trails_keep_to_the_path_with_few_vertices():
    recording = filmable(3, samples=801)
    pose = recording["pose"].values
    trails = timeline.make_trails(recording.time, pose, 200)
    assert sum(trail.time.size for trail in trails) <= 200
    for place, trail in enumerate(trails):
        at = np.stack([np.interp(recording.time, trail.time, trail.points[:, k]) for k in (0, 1)], axis=-1)
        gap = [np.min(np.hypot(*(at - point).T)) for point in pose[::20, place, :2]]
        assert max(gap) < 0.02


# --- the camera -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("followers", [1, 15])
@pytest.mark.parametrize("name", ["group", "isometric", "top"])
def test_every_robot_is_in_every_picture(followers, name):
    recording = filmable(followers)
    scene, line, path = film(recording, (640, 480), 10, name)
    fovy = float(scene.model.vis.global_.fovy)
    for frame in range(0, len(line), 7):
        for pose in line.pose[frame]:
            x, y = projected(path, frame, np.array([*pose[:2], 0.03]), fovy, (640, 480))
            assert 10 < x < 630
            assert 0.29 * 480 - 1 < y < 470  # below title and map


def test_group_camera_zooms_in_and_never_jumps():
    line_film = film(filmable(), fps=30)
    path = line_film[2]
    assert path.distance[-1] < path.distance[0] / 3
    per_second = np.abs(np.diff(np.log(path.distance))) * 30
    assert per_second.max() < 0.6
    jerk = np.diff(path.lookat, n=2, axis=0)
    assert np.abs(jerk).max() < 2e-4 * path.distance.max()


def test_group_camera_is_with_the_robots_at_both_ends():
    scene, line, path = film(filmable(), (640, 480), 30)
    fovy = float(scene.model.vis.global_.fovy)
    for frame in (0, len(line) - 1):
        seen = [projected(path, frame, np.array([*pose[:2], 0.03]), fovy, (640, 480)) for pose in line.pose[frame]]
        middle = (np.min(seen, axis=0) + np.max(seen, axis=0)) / 2
        assert middle == pytest.approx([320, 264], abs=60)


def test_chase_looks_the_way_the_first_follower_goes():
    _, line, path = film(filmable(3), fps=10, name="chase")
    assert np.abs(np.radians(path.azimuth) - line.pose[:, 1, 2]).max() < 0.6
    assert path.lookat[:, :2] == pytest.approx(line.pose[:, 1, :2], abs=0.1)


def test_unknown_camera():
    with pytest.raises(RenderError, match="no camera 'isometrc'; did you mean 'isometric'"):
        camera.plan_camera("isometrc", np.zeros((2, 1, 3)), 40.0, 1.0, 30)


def test_coincident_robots_show_the_last():
    positions = np.array([[0.0, 0.0], [0.001, 0.0], [1.0, 0.0]])
    assert bodies.fading(positions) == pytest.approx([0.0, 1.0, 1.0])
    assert 0.0 < bodies.fading(np.array([[0.0, 0.0], [0.04, 0.0]]))[0] < 1.0


@pytest.mark.parametrize(
    ("metres", "texts"),
    [
        ([2.0], [" 2.00 m"]), ([0.123], ["  123 mm"]), ([0.0123], [" 12.3 mm"]), ([0.0012], [" 1.20 mm"]),
        ([3.2e-7], ["  0.3 µm"]), ([0.0], ["  0.0 µm"]), ([np.nan], ["unknown"]),
        ([1.18, 0.9996, 1e-3, np.nan], [" 1.18 m", " 1.00 m", " 0.00 m", "unknown"]),
    ],
)
def test_lengths_have_one_unit_that_suits_the_largest(metres, texts):
    assert letters.running_lengths(metres) == texts


# --- pictures ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_robots_are_drawn_where_they_are_and_move():
    recording = filmable()
    scene, line, path = film(recording, (640, 480))
    fovy = float(scene.model.vis.global_.fovy)
    with scene_renderer.SceneRenderer(scene, line, path, (640, 480)) as drawn:
        drawn._floor._timeline = replace(line, trails=())
        centres = []
        for frame in (0, 2, 3):
            picture = drawn.draw(frame)
            assert picture.shape == (480, 640, 3)
            assert picture.std() > 5.0
            for place in (0, 1):
                seen = pixels_of(picture, place)
                assert len(seen) > 30
                expected = projected(path, frame, np.array([*line.pose[frame, place, :2], 0.03]), fovy, (640, 480))
                assert np.median(seen, axis=0) == pytest.approx(expected, abs=12)
                centres.append(np.median(seen, axis=0))
    assert np.linalg.norm(centres[1] - centres[5]) > 20


@pytest.mark.slow
def test_virtual_leader_is_a_marker_in_its_place():
    recording = filmable(virtual=True)
    scene, line, path = film(recording, (640, 480))
    fovy = float(scene.model.vis.global_.fovy)
    assert scene.model.nq == 9
    with scene_renderer.SceneRenderer(scene, line, path, (640, 480), DRAFT) as drawn:
        seen = pixels_of(drawn.draw(1), 0)
        marker = drawn._data.body(scene.spec.robots[0]).xmat.reshape(3, 3)
        assert np.arctan2(marker[1, 0], marker[0, 0]) == pytest.approx(line.pose[1, 0, 2])
    expected = projected(path, 1, np.array([*line.pose[1, 0, :2], 0.0]), fovy, (640, 480))
    assert np.median(seen, axis=0) == pytest.approx(expected, abs=25)


@pytest.mark.slow
def test_trails_are_drawn_up_to_now():
    recording = filmable()
    scene, line, path = film(recording, (640, 480), name="isometric")
    seen = {}
    # At a pace of 1000 nothing is old, at 1 all but the end is.
    lines = {"none": replace(line, trails=()), "fresh": replace(line, speed=1000.0), "old": replace(line, speed=1.0)}
    for name, each in lines.items():
        with scene_renderer.SceneRenderer(scene, each, path, (640, 480), DRAFT) as drawn:
            seen[name] = [len(pixels_of(drawn.draw(frame), 0)) for frame in (0, len(line) - 1)]
    first, last = (seen["fresh"][k] - seen["none"][k] for k in (0, 1))
    assert first < 100 < 300 < last
    assert seen["old"][1] < seen["fresh"][1] - 200


@pytest.mark.slow
@pytest.mark.parametrize(("stop", "frames"), [(0.0, 1), (10.0, 3)])
def test_interrupted_runs_are_shown_as_far_as_they_went(stop, frames):
    pictures = video.frames(filmable(samples=81, stop=stop), size=SMALL, fps=1, speed=5.0, quality="draft")
    assert len(list(pictures)) == frames


@pytest.mark.slow
def test_overlay_is_written_over_the_picture_and_nowhere_else():
    recording = filmable(15)
    line = line_of(recording)
    plain = np.full((480, 640, 3), 90, np.uint8)
    written = overlay.Overlay(recording, line, (640, 480)).write(plain, 0)
    changed = np.argwhere((written != plain).any(axis=-1))
    rows = np.unique(changed[:, 0])
    assert rows[rows < 300].max() < 480 * 0.45
    assert rows[rows >= 300].min() > 480 - 40  # the legend at the foot
    assert (written[20:60, 260:380] == 90).all()  # between title and map


# --- processes, qualities, formats ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_two_processes_draw_the_same_pixels_as_one_and_end_with_the_film(monkeypatch):
    monkeypatch.setattr(render_pool, "_WORTH", 3)
    told: list[tuple[int, int]] = []
    recording = parted()
    before = recording.dataset.copy(deep=True)
    options = {"size": SMALL, "fps": 1, "speed": 8.0}
    one = list(video.frames(recording, **options))
    assert len(one) == 11
    pictures = video.frames(recording, **options, processes=2, progress=lambda *n: told.append(n))
    two = [next(pictures) for _ in one]
    assert len(multiprocessing.active_children()) == 2
    pictures.close()  # nobody has asked for what comes after the last picture
    assert not multiprocessing.active_children()
    assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))
    assert told == [(k, 11) for k in range(1, 11)]
    assert recording.dataset.identical(before)


@pytest.mark.slow
def test_what_a_process_cannot_do_is_told_by_its_own_error(monkeypatch):
    monkeypatch.setattr(render_pool, "_WORTH", 4)
    recording = parted()
    recording.dataset.attrs["scene"] = recording.dataset.attrs["scene"].replace("nh_mini", "nobody")
    with pytest.raises(RobotError, match="no robot 'nobody'"):
        next(video.frames(recording, size=SMALL, fps=1, speed=4.0, processes=2))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "quality"), [("split", "high"), ("group", "draft")])
def test_every_quality_draws(name, quality):
    pictures = list(video.frames(filmable(samples=21), size=SMALL, fps=1, camera=name, quality=quality, speed=80.0))
    assert len(pictures) == 2
    assert all(picture.shape == (240, 320, 3) and picture.std() > 5 for picture in pictures)


@pytest.mark.slow
def test_animation_is_a_gif_of_the_right_pace(tmp_path):
    path = video.render_film(filmable(samples=81), tmp_path / "film.gif", size=SMALL, fps=10, speed=80.0)
    with Image.open(path) as animation:
        assert animation.format == "GIF"
        assert animation.n_frames == 11
        assert animation.size == SMALL
        assert animation.info["duration"] == 100
        assert animation.info["loop"] == 0
    assert list(tmp_path.iterdir()) == [path]


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_film_is_readable_of_the_right_length_and_alone(tmp_path):
    told = []
    recording = filmable(samples=81)
    path = video.render_film(
        recording, tmp_path / "film.mp4", size=SMALL, fps=10, speed=80.0, progress=lambda *n: told.append(n)
    )
    assert path == tmp_path / "film.mp4"
    assert list(tmp_path.iterdir()) == [path]
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames == 11
    assert seconds == pytest.approx(1.1, abs=0.11)
    assert told == [(k, 11) for k in range(1, 12)]
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    first = np.frombuffer(next(reader), np.uint8).reshape(240, 320, 3)
    reader.close()
    assert about["codec"] == "h264"
    assert about["pix_fmt"].startswith("yuv420p")
    assert about["size"] == SMALL
    assert first.std() > 5.0
    head = path.read_bytes()[:4096]
    assert b"moov" in head  # the index comes first: a browser can start at once


@pytest.mark.slow
def test_failure_half_way_leaves_no_file(tmp_path):
    def stop(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        video.render_film(filmable(samples=41), tmp_path / "film.mp4", size=SMALL, fps=2, progress=stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_film_cut_short_by_the_disk_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr(imageio_ffmpeg, "count_frames_and_secs", lambda _: (1, 0.1))
    pictures = [np.full((64, 64, 3), k, np.uint8) for k in range(5)]
    with pytest.raises(RenderError, match="ffmpeg wrote 1 of 5 frames"):
        encode.write_film(pictures, tmp_path / "film.mp4", (64, 64), 10)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"path": "film.avi"}, r"film.avi: expected a name ending in .mp4 or .gif"),
        ({"camera": "grup"}, "camera: no such choice as the text 'grup'; did you mean 'group'"),
        ({"quality": "hihg"}, "quality: no such choice as the text 'hihg'; did you mean 'high'"),
        ({"size": (641, 480)}, r"size\[0\]: video needs even sizes, got 641"),
        ({"size": (8192, 8192)}, "size: a picture of a film has at most 8192 x 4320 pixels"),
        ({"fps": 0}, "fps: expected a value at least 1"),
        ({"fps": 1000}, "fps: expected a value at most 120"),
        ({"processes": 0}, "processes 0: expected at least 1"),
        ({"speed": 0.0}, "speed: expected a value greater than 0, got 0"),
        ({"speed": float("nan")}, "speed: expected a finite number, got nan"),
        ({"speed": 1e-9}, "speed: .* frames, at most 200000: .* would do"),
    ],
)
def test_bad_arguments_stop_before_any_work(tmp_path, arguments, message):
    path = tmp_path / arguments.pop("path", "film.mp4")
    with pytest.raises(RenderError, match=message):
        video.render_film(filmable(samples=5), path, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_missing_opengl_stops_before_any_work(tmp_path, monkeypatch):
    def nothing_draws() -> str:
        raise RenderError("no off-screen OpenGL: install libegl1")

    monkeypatch.setattr(gl, "choose_backend", nothing_draws)
    monkeypatch.setattr(frame_renderer, "make_scene", lambda _: pytest.fail("work was begun"))
    with pytest.raises(RenderError, match="install libegl1"):
        video.render_film(filmable(samples=5), tmp_path / "film.mp4")
    assert list(tmp_path.iterdir()) == []


def test_missing_ffmpeg_stops_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", "/nonexistent/ffmpeg")
    monkeypatch.setattr(gl, "choose_backend", lambda: pytest.fail("work was begun"))
    encode.find_encoder.cache_clear()
    try:
        with pytest.raises(RenderError, match="no working ffmpeg"):
            video.render_film(filmable(samples=5), tmp_path / "film.mp4")
    finally:
        encode.find_encoder.cache_clear()
    assert list(tmp_path.iterdir()) == []


def test_recording_without_a_scene_cannot_be_filmed():
    with pytest.raises(RecordingError, match="which scene"):
        next(video.frames(synthetic_recording(samples=5)))
