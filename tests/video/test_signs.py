"""What films show besides robots: twins, slots, skid marks, wheels' colours, the live plot, the map and the legend."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from films import SMALL, film, filmable, line_of, parted, pixels_of, projected, shared_scene
from nhtrack import se2
from nhtrack.colours import TOUCH, letter_colour, rgb, robot_colour
from nhtrack.ground import Ground, Patch
from nhtrack.simulation.scene import SceneSpec, make_scene
from nhtrack.video import (
    bodies,
    chart,
    floor,
    legend,
    map,
    overlay,
    render_options,
    scene_renderer,
    timeline,
)
from nhtrack.video import (
    typography as letters,
)
from recordings import HALF_SEPARATION

pytestmark = pytest.mark.render

# --- twins, slots, wheels and skid marks ------------------------------------------------------------------------------


def test_twins_of_wheels_are_shown_and_of_ideal_runs_not():
    line = line_of(parted())
    assert np.hypot(*(line.twin - line.pose)[..., :2].reshape(-1, 2).T) == pytest.approx(0.3, abs=0.01)
    assert line_of(filmable()).twin is None


def test_wheels_of_twins_roll_without_slip():
    pose = np.zeros((101, 1, 3))
    angle = np.linspace(0, 2 * np.pi, 101)
    pose[:, 0] = np.stack([np.sin(angle), 1 - np.cos(angle), angle], axis=-1)  # a circle of 1 m, to the left
    turned = bodies.wheel_angles(pose, 0.05, 0.2)[-1, 0]
    assert turned == pytest.approx([2 * np.pi * 0.8 / 0.05, 2 * np.pi * 1.2 / 0.05], rel=1e-3)


def test_slots_are_those_that_are_not_a_robots_own_pose():
    recording = filmable(2, samples=41)
    pose = recording["pose"].values
    tracked = np.full_like(pose, np.nan)
    tracked[:, 1:] = pose[:, :1]
    recording.dataset["leader_pose"] = (recording["pose"].dims, tracked)
    assert np.isnan(line_of(recording).slot).all()
    tracked[:, 2, 0] += 0.4
    slot = line_of(recording).slot
    assert np.isnan(slot[:, :2]).all()
    assert slot[:, 2, 0] == pytest.approx(line_of(recording).pose[:, 0, 0] + 0.4)


def test_skid_marks_lie_where_a_sliding_wheel_went():
    recording = parted(samples=81)
    shape = recording["friction_utilisation"].shape
    used, slip = np.zeros(shape), np.zeros(shape)
    used[20:31, 1, 0], slip[20:31, 1, 0] = 1.0, 0.05
    recording.dataset["friction_utilisation"][:] = used
    recording.dataset["longitudinal_slip"][:] = slip
    recording.dataset["lateral_slip"][:] = 0.0
    line = line_of(recording)
    pose = recording["pose"].values
    left = np.asarray(se2.act(pose[:, 1], np.broadcast_to([0.0, HALF_SEPARATION], (len(pose), 2))))
    assert line.skids[0].points[0] == pytest.approx(left[19])
    assert line.skids[-1].points[1] == pytest.approx(left[30])
    assert [skid.time for skid in line.skids] == pytest.approx(recording.time[20:31])
    for before, after in zip(line.skids, line.skids[1:], strict=False):
        assert before.points[1] == pytest.approx(after.points[0])


@pytest.mark.parametrize("every", [1, 2])
def test_many_skid_marks_are_thinned(every):
    """Those of wheels that slide all the time, and of wheels that chatter."""
    recording = parted(samples=2001)
    recording.dataset["longitudinal_slip"][:] = 1.0
    recording.dataset["friction_utilisation"][:] = 0.0
    recording.dataset["friction_utilisation"][::every] = 1.0
    assert 0.5 * timeline.MOST_SKIDS < len(line_of(recording).skids) < 1.1 * timeline.MOST_SKIDS


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 1.0, 1.7, np.inf, np.nan])
def test_wheels_grow_brighter_as_they_use_their_friction(share):
    dark = np.array([0.05, 0.05, 0.05])
    colour = bodies.utilisation_colour(share, dark)
    assert ((colour >= 0) & (colour <= 1)).all()
    if share >= 1:
        assert colour == pytest.approx(bodies.utilisation_colour(1.0, dark))
    weight = np.array([0.30, 0.59, 0.11])
    ramp = [bodies.utilisation_colour(value, dark) @ weight for value in np.linspace(0, 1, 21)]
    assert (np.diff(ramp) > 0).all()


@pytest.fixture(scope="module")
def filmed():
    """Scene, timeline and camera path of `parted`, and its stage."""
    scene, line, path = film(parted(), (640, 480))
    with scene_renderer.SceneRenderer(scene, line, path, (640, 480)) as drawn:
        yield scene, line, path, drawn


@pytest.fixture(scope="module")
def marked():
    """The same with a marker for a leader, and one tyre of its first follower at the limit of its friction."""
    recording = parted(followers=2, virtual=True)
    recording.dataset["friction_utilisation"][:] = np.array([[np.nan, np.nan], [1.0, 0.0], [0.0, 0.0]])
    scene, line, path = film(recording, fps=4)
    with scene_renderer.SceneRenderer(scene, line, path, SMALL, render_options.QUALITIES["draft"]) as drawn:
        yield scene, line, path, drawn


@pytest.mark.slow
def test_ghosts_show_where_twins_are_and_nothing_where_they_coincide(filmed, monkeypatch):
    scene, line, path, drawn = filmed
    frame, bare = 3, replace(line, twin=None)
    monkeypatch.setattr(drawn._floor, "_timeline", bare)  # no rings
    haunted = drawn.draw(frame).astype(float)
    monkeypatch.setattr(drawn, "_timeline", bare)
    fovy = float(scene.model.vis.global_.fovy)
    changed = np.argwhere(np.abs(haunted - drawn.draw(frame)).max(axis=-1) > 25)[:, ::-1]
    places = [projected(path, frame, np.array([*twin[:2], 0.03]), fovy, (640, 480)) for twin in line.twin[frame]]
    nearest = np.min([np.linalg.norm(changed - place, axis=-1) for place in places], axis=0)
    assert len(changed) > 200
    assert np.quantile(nearest, 0.95) < 60
    body = bodies.Bodies(scene)
    assert body.show_ghosts(line.pose[frame, :, :2], line.twin[frame, :, :2])
    assert not body.show_ghosts(line.pose[frame, :, :2], line.pose[frame, :, :2])
    assert not body.show_ghosts(line.pose[frame, :, :2], np.full((2, 2), np.nan))


def opacity_of(scene, place: int) -> float:
    """Returns how solid the robot at a place of the bodies is drawn."""
    own = (bodies.owners(scene) == place) & (scene.model.geom_group == 2)
    return float(scene.model.geom_rgba[own, 3].max())


@pytest.mark.slow
def test_robots_look_the_same_with_materials_of_their_own_and_with_shared_ones():
    spec = SceneSpec(("leader", "a", "b"), colours=(0, 3, 3))
    looks = []
    for share in (False, True):
        scene = make_scene(spec, share_materials=share)
        body = bodies.Bodies(scene)
        body.show(np.array([[0.0, 0.0], [0.03, 0.0], [1.0, 0.0]]), None)
        model = scene.model
        shown = [model.geom_rgba, *(values[model.geom_matid] for values in (model.mat_specular, model.mat_emission))]
        looks.append([*shown, model.mat_shininess[model.geom_matid]])
    for own, shared in zip(*looks, strict=True):
        np.testing.assert_array_equal(own, shared)


def test_a_fleet_s_discs_leave_their_neighbours_places_and_its_robots_their_small_parts():
    places = np.array([[0.5 * (k % 12), 0.5 * (k // 12)] for k in range(144)])
    assert floor.disc_radius(places[None]) == pytest.approx(0.25)
    scene = make_scene(SceneSpec(("a", "b")), share_materials=True)
    bodies.Bodies(scene).leave_out(0.03)
    hidden = scene.model.geom_group == bodies.HIDDEN
    assert hidden[scene.model.geom("b/left_lamp").id]
    assert not hidden[scene.model.geom("b/shell_front").id]
    assert not hidden[scene.model.geom("floor").id]


# --- floor marks: geoms, read without drawing -------------------------------------------------------------------------


def marks(scene, line, frame: int, distance: float = 1.0) -> list[dict]:
    """Returns what a film's floor marks add to the scene in a frame: type, colour and ends or centre of each."""
    visual = mujoco.MjvScene(scene.model, 5000)
    floor.FloorLines(scene, line, 1.0, 480, shadows=False).add(visual, frame, distance)
    found = []
    for geom in visual.geoms[: visual.ngeom]:
        start, along = geom.pos.copy(), geom.mat[:, 2] * geom.size[2]
        is_line, ends = geom.type == mujoco.mjtGeom.mjGEOM_LINE, np.stack([start, start + along])[:, :2]
        found.append({"line": is_line, "rgb": geom.rgba[:3].copy(), "radius": geom.size[0], "ends": ends})
    return found


@pytest.mark.slow
def test_skid_marks_appear_when_they_are_made():
    scene, line, _ = film(parted())
    points = np.array([[0.0, 0.0], [0.1, 0.0]])
    skids = tuple(timeline.Skid(float(line.time[frame]), points + frame) for frame in (2, 5))
    for frame, count in ((1, 0), (2, 1), (4, 1), (5, 2)):
        found = marks(scene, replace(line, skids=skids), frame)
        drawn = [mark["ends"] for mark in found if mark["rgb"] == pytest.approx(floor.RUBBER[:3])]
        assert len(drawn) == count
        assert all(ends == pytest.approx(skid.points, abs=1e-6) for ends, skid in zip(drawn, skids, strict=False))


def test_rings_are_below_twins_and_slots_where_robots_ought_to_be():
    scene, line, _ = film(parted())
    slot = np.full_like(line.pose, np.nan)
    slot[:, 1] = line.pose[:, 1] + [0.5, 0.0, 0.0]
    found = marks(scene, replace(line, slot=slot, trails=()), 3)
    rings = [mark for mark in found if not mark["line"] and np.ptp(mark["rgb"]) < 0.05]
    assert [mark["ends"][0] for mark in rings] == [pytest.approx(twin[:2], abs=1e-6) for twin in line.twin[3]]
    corners = np.array([mark["ends"][0] for mark in found if mark["line"]])
    expected = se2.act(slot[3, 1][None], floor.SLOT_SIZE * floor.SLOT[:-1])
    assert corners[:5] == pytest.approx(np.asarray(expected), abs=1e-6)


def test_chevrons_are_ahead_of_robots_and_the_roots_disc_below_it():
    scene, line, _ = film(filmable())
    found = marks(scene, replace(line, trails=()), 3, distance=10.0)
    disc = next(mark for mark in found if not mark["line"])
    assert disc["ends"][0] == pytest.approx(line.pose[3, 0, :2], abs=1e-6)
    tips = [mark["ends"][1] for mark in found if mark["line"]][::2]
    for pose, tip in zip(line.pose[3], tips, strict=True):
        ahead = np.asarray(se2.between(pose, np.array([*tip, pose[2]])))
        assert ahead[0] > floor.HULL
        assert ahead[1] == pytest.approx(0.0, abs=1e-6)


# --- map --------------------------------------------------------------------------------------------------------------


def map_without_trails():
    line = line_of(filmable())
    nowhere = tuple(timeline.Trail(np.array([np.inf]), np.zeros((1, 2))) for _ in line.trails)
    return map.Map(replace(line, trails=nowhere), robot_colour, 480, 360, 2.0)


def test_map_has_x_to_the_right_y_up_and_its_bar_is_to_scale():
    inset = map_without_trails()
    seen = []
    for offset in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5)):
        pose = np.zeros((2, 3))
        pose[:, :2] = inset.middle
        pose[0, :2] += offset
        pose[1, :2] -= 1.0  # out of the way
        seen.append(np.median(pixels_of(np.asarray(inset.draw(pose, 0).convert("RGB")), 0), axis=0))
    right, up = seen[1] - seen[0], seen[2] - seen[0]
    assert right == pytest.approx([0.5 * inset.scale, 0.0], abs=1.5)
    assert up == pytest.approx([0.0, -0.5 * inset.scale], abs=1.5)
    foot = np.asarray(inset._faint)[-round(5 * 2.0 * map._FINE)]  # the row of the bar
    grey = np.flatnonzero((foot[:, :3] == letters.GREY).all(axis=-1))
    bar = grey[: 1 + np.argmax(np.append(np.diff(grey), 2) > 1)].size / map._FINE
    metres = map.round_length(0.3 * inset._size[0] / inset.scale)
    assert bar == pytest.approx(metres * inset.scale, abs=3.0)  # ticks at its ends stand out


def test_map_is_bright_up_to_now():
    line = line_of(filmable())
    inset = map.Map(line, robot_colour, 480, 360, 2.0)
    maps = [inset.draw(line.pose[frame], frame).convert("RGB") for frame in (0, len(line) // 2, len(line) - 1)]
    bright = [len(pixels_of(np.asarray(picture), 0)) for picture in maps]
    assert bright[0] + 200 < bright[1] < bright[2] - 200


# --- ghosts, virtual leaders ------------------------------------------------------------------------------------------


def test_ghosts_are_fainter_the_nearer_their_robots():
    scene = film(parted())[0]
    body, here = bodies.Bodies(scene), np.array([[0.0, 0.0], [5.0, 0.0]])
    opacity = []
    for apart in (0.0, 0.03, 0.05, 0.3):
        body.show_ghosts(here, here + np.array([0.0, apart]))
        opacity.append(opacity_of(scene, 1))
    assert opacity == pytest.approx([0.0, bodies.GHOST / 3, bodies.GHOST * 7 / 9, bodies.GHOST])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["filmed", "marked"])
def test_ghosts_stand_and_roll_as_twins_do(name, request):
    scene, line, _, drawn = request.getfixturevalue(name)
    first = scene.spec.first_body
    drawn.draw(3)
    for body, twin in zip(scene.spec.bodies, line.twin[3, first:], strict=True):
        ghost = drawn._twin_data.body(f"{body}/")
        assert ghost.xpos[:2] == pytest.approx(twin[:2])
        assert np.arctan2(ghost.xmat[3], ghost.xmat[0]) == pytest.approx(np.asarray(se2.wrap(twin[2])))
    twin = line.twin[:, first:]
    way = np.asarray(se2.between(twin[:-1], twin[1:]))[..., 0].sum(axis=0)
    wheels = drawn._twin_qpos[:, scene.addresses.wheel_qpos].mean(axis=-1)
    rolled = (wheels[-1] - wheels[0]) * scene.drive.wheel_radius
    assert rolled == pytest.approx(way, rel=0.05)  # chords are shorter than arcs


@pytest.mark.slow
def test_followers_of_a_marker_have_their_own_tyres_colour_and_ghost(marked, monkeypatch):
    scene, line, _, drawn = marked
    twin = line.twin.copy()
    twin[:, 1:] = line.pose[:, 1:]  # the followers are where they ought to be, whatever the leader's twin does
    monkeypatch.setattr(drawn, "_timeline", replace(line, twin=twin))
    drawn._add_robots(3)
    left, right = (scene.model.geom_rgba[tyre[0], :3].copy() for tyre in drawn._bodies._tyres[0])
    before = drawn._visual.ngeom
    drawn._add_ghosts(3)
    assert drawn._visual.ngeom == before
    assert left == pytest.approx(bodies.utilisation_colour(1.0, left), abs=1e-6)
    assert right == pytest.approx(drawn._bodies._dark[1], abs=1e-6)


@pytest.mark.slow
def test_followers_of_a_marker_fade_by_their_own_places(marked, monkeypatch):
    scene, line, _, drawn = marked
    pose = line.pose.copy()
    pose[:, 2] = pose[:, 1]  # the followers stand in one place
    pose[:, 0] = pose[:, 1] + [1.0, 0.0, 0.0]
    monkeypatch.setattr(drawn, "_timeline", replace(line, pose=pose))
    drawn._add_robots(3)
    assert [opacity_of(scene, place) for place in range(len(scene.spec.bodies))] == [0.0, 1.0]


# --- what is written --------------------------------------------------------------------------------------------------


def test_panel_tells_the_time_and_each_followers_error():
    recording = filmable(3)
    line = line_of(recording)
    panel = overlay.Overlay(recording, line, (640, 480))
    assert panel.clock_text(3) == f"t = {line.time[3]:5.1f} s    {line.speed:g}x"
    told = letters.running_lengths(line.distance[3, 1:].tolist())
    expected = [(f"f{k}  {text}", letter_colour(robot_colour(k))) for k, text in enumerate(told, start=1)]
    assert panel.error_lines(3) == expected
    assert len({text for text, _ in expected}) == 3


def test_panel_tells_how_far_the_furthest_twin_is():
    recording = parted()
    line = line_of(recording)
    twin = line.twin.copy()
    twin[:, 0] = line.pose[:, 0]
    panel = overlay.Overlay(recording, replace(line, twin=twin), (640, 480))
    apart = np.hypot(*(twin - line.pose)[3, 1, :2])
    assert panel.gap_lines(3) == [f"from ideal  {letters.running_lengths([apart])[0]}"]


@pytest.mark.slow
def test_picture_says_that_a_run_was_interrupted_in_its_last_frame_only():
    pictures = {}
    for outcome in ("completed", "interrupted"):
        recording = filmable(samples=81, outcome=outcome)
        line = line_of(recording)
        panel = overlay.Overlay(recording, line, (640, 480))
        plain = np.full((480, 640, 3), 90, np.uint8)
        pictures[outcome] = [panel.write(plain, frame) for frame in (0, len(line) - 1)]
    first = (pictures["completed"][0] != pictures["interrupted"][0]).any()
    dark = {outcome: (seen[1] < 60).sum() for outcome, seen in pictures.items()}
    assert not first
    assert dark["interrupted"] > dark["completed"] + 50


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "scale"), [("nh_mini", 1.0), ("burger", 1.68), ("pioneer", 4.45), ("warehouse", 9.51)]
)
def test_scale_of_robots(robot, scale):
    assert bodies.robot_scale(make_scene(SceneSpec(("leader",), robot=robot))) == pytest.approx(scale, rel=0.01)


@pytest.mark.slow
def test_robots_are_solid_again_after_their_ghosts(filmed):
    drawn = filmed[-1]
    before = drawn.draw(3)
    drawn.draw(4)
    assert np.array_equal(drawn.draw(3), before)


def test_share_of_friction_is_interpolated_and_known_where_it_is_infinite():
    recording = parted(samples=161)
    used = recording["friction_utilisation"].values
    used[40:60] = np.inf  # a wheel that bears no load
    line = timeline.make_timeline(recording, shared_scene(recording.dataset.attrs["scene"]), fps=2, speed=1.0)
    assert line.utilisation[:38] == pytest.approx(used[:38])
    assert (line.utilisation[41:59] == 1.0).all()


@pytest.mark.slow
def test_an_empty_panel_tells_no_future():
    recording = parted()
    recording.dataset["error"][:] = np.nan  # one robot alone
    line = line_of(recording)
    for size in ((230, 360), (320, 150)):
        live = chart.Chart(recording, line, size)
        shown = (live.draw(len(line) // 10) != live.draw(0)).any(axis=(0, 2))
        whole = (live.draw(len(line) - 1) != live.draw(0)).any(axis=(0, 2))
        assert 0 < shown.sum() < 0.2 * whole.sum()


@pytest.mark.parametrize("size", [(64, 480), (100, 1080), (640, 64)])
def test_narrow_pictures_have_a_map(size):
    recording = filmable()
    line = line_of(recording)
    plain = np.zeros((*size[::-1], 3), np.uint8)
    assert overlay.Overlay(recording, line, size).write(plain, 0).shape == plain.shape


# --- live plot, legend, map -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(640, 480), (1280, 720), (1920, 1080), (480, 640)])
def test_split_screen_fills_the_picture(size):
    view, beside = chart.split(size)
    across = view[0] + beside.size[0] == size[0] and beside.size[1] == size[1] == view[1]
    above = view[1] + beside.size[1] == size[1] and beside.size[0] == size[0] == view[0]
    assert across != above
    assert beside.corner == ((view[0], 0) if across else (0, view[1]))
    assert view[0] % 2 == view[1] % 2 == 0


@pytest.mark.slow
@pytest.mark.parametrize("followers", [1, 15])
def test_live_plot_is_drawn_up_to_now(followers):
    recording = filmable(followers)
    line = line_of(recording, fps=10)
    live = chart.Chart(recording, line, (230, 360))
    first, middle, last = (live.draw(frame) for frame in (0, len(line) // 2, len(line) - 1))
    assert first.shape == (360, 230, 3)
    changed = np.flatnonzero((middle != first).any(axis=(0, 2)))
    later = np.flatnonzero((last != middle).any(axis=(0, 2)))
    assert changed.max() <= later.min()
    assert later.size == pytest.approx(changed.size, rel=0.2)


def test_legend_names_what_there_is():
    line = line_of(parted())
    assert [text for *_, text in legend.signs_of(line)] == ["leader", "ideal twin", "friction used, 0 to 100 %"]
    assert [text for *_, text in legend.signs_of(line_of(filmable()))] == ["leader"]
    assert legend.draw_legend(line, 1.0).height == 20
    ground = Ground(1.0, (Patch(0.05, disc=(0.0, 0.0, 1.0)), Patch(0.05, disc=(3.0, 0.0, 1.0))))
    assert [text for *_, text in legend.signs_of(line, ground)][3:] == ["friction 0.05"]
    narrow = legend.draw_legend(line, 1.0, 200.0, ground)
    assert narrow.height == 60
    assert narrow.width <= 200


def test_robots_that_touch_are_marked_while_and_after_they_do_and_named():
    recording = parted(followers=2)
    touch = np.full((81, 3, 3, 5), np.nan)
    touch[20:31, 1, 0] = 2, 0.1, 0.5, 0.3, 0.001
    recording.dataset["touch"] = ("time", "robot", "touch", "touch_component"), touch
    line = line_of(recording, fps=10)
    (mark,) = line.touches
    assert mark.robots == ("f1", "f2")
    assert mark.point == pytest.approx(recording["pose"].values[20, 1:, :2].mean(axis=0))
    lines = floor.FloorLines(shared_scene(recording.dataset.attrs["scene"]), line, 1.0, 480, False)
    visual, added = mujoco.MjvScene(shared_scene(recording.dataset.attrs["scene"]).model, 4000), []
    for time in (mark.start - 1.5, mark.start + 1.0, mark.end + 1.5):
        visual.ngeom, frame = 0, int(np.searchsorted(line.time, time))
        lines.add(visual, frame, 1.0)
        marked = np.array(rgb(TOUCH), np.float32)
        added.append(sum(np.allclose(visual.geoms[k].rgba[:3], marked) for k in range(visual.ngeom)))
        panel = overlay.Overlay(recording, line, (640, 480))
        assert panel.touch_lines(frame) == (["touch: f1 and f2"] if mark.start <= line.time[frame] <= mark.end else [])
    assert added[0] == 0 < added[2] < added[1]


def test_names_stand_at_robots_and_not_on_each_other():
    recording = filmable(2)
    line = line_of(recording)
    places = np.array([[300.0, 300.0], [304.0, 302.0], [100.0, 200.0]])
    plain = np.full((480, 640, 3), 90, np.uint8)
    bare = overlay.Overlay(recording, line, (640, 480)).write(plain, 0)
    named = overlay.Overlay(recording, line, (640, 480), lambda frame: places).write(plain, 0)
    changed = (named != bare).any(axis=-1)
    assert changed[180:200, 90:110].any()
    rows = np.flatnonzero(changed[:, 290:314].any(axis=1))
    assert rows.size > 1.9 * np.flatnonzero(changed[:, 90:110].any(axis=1)).size  # two names, one above the other


@pytest.mark.parametrize(
    ("longest", "bar"), [(0.9, 0.5), (1.0, 1.0), (2.3, 2.0), (0.07, 0.05), (49.0, 20.0), (50.0, 50.0)]
)
def test_scale_bars_are_round(longest, bar):
    assert map.round_length(longest) == pytest.approx(bar)
