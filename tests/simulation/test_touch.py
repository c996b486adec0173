"""Contacts between robots on wheels, against what is worked out by hand."""

import numpy as np
import pytest

from nhtrack.simulation.mujoco import MujocoSimulation
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.spec import SceneSpec
from nhtrack.simulation.state import State
from nhtrack.simulation.touch import FIELDS

HULL = 0.06  # [m] radius of nh_mini
SPEED = 0.25  # [m/s] of each
DT = 0.01


def driven(pose: np.ndarray, speed: np.ndarray, seconds: float, **spec: object) -> MujocoSimulation:
    """Returns a simulation of robots that drove on at their speeds, commanded nothing."""
    names = tuple("abcdefghij"[: len(pose)])
    simulation = MujocoSimulation(make_scene(SceneSpec(names, robot_contact=True, friction=3.0, **spec)), DT)  # type: ignore[arg-type]
    twist = np.stack([speed, 0 * speed, 0 * speed], axis=-1)
    simulation.reset(State(0.0, pose, twist))
    simulation.drive_by(np.zeros((round(seconds / DT), len(pose), 2)))
    return simulation


def noted(simulation: MujocoSimulation) -> list[dict[str, float]]:
    """Returns what was noted of each pair, with the robot's own place under `robot`."""
    (touch,) = simulation.motion.touch
    rows = [(robot, *touch[robot, slot]) for robot, slot in np.argwhere(np.isfinite(touch[..., 0]))]
    return [dict(zip(("robot", *FIELDS), row, strict=False)) for row in rows]


def head_on(aside: float) -> MujocoSimulation:
    """Two robots 0.3 m apart drive at each other; they would meet after 0.36 s where nothing is between their axes."""
    pose = np.array([[0.0, 0.0, 0.0], [0.3, aside, np.pi]])
    return driven(pose, np.array([SPEED, SPEED]), 0.6)


def test_robots_that_meet_head_on_close_in_at_twice_their_speed_and_give_up_their_momentum() -> None:
    """The impulse is that which turned each robot's momentum; wheels roll with it or not, so m or m_eff counts."""
    simulation = head_on(0.0)
    (found,) = noted(simulation)
    drive = simulation.drive
    assert (found["robot"], found["partner"]) == (0, 1)
    assert found["closing_speed"] == pytest.approx(2 * SPEED, rel=1e-3)
    after = simulation.motion.xi[0, :, 0]
    assert after[0] == pytest.approx(after[1], abs=1e-3)
    changed = SPEED - after[0]
    assert 0.99 * drive.mass * changed < found["impulse"] < 1.01 * drive.m_eff * changed
    assert 0.001 <= found["time"] <= 0.24 + 0.001  # from when they meet to the end, at the longest
    # In a step they come closer by at most what they drive in it, and no farther than they do in the whole contact.
    assert 2 * SPEED * 0.0005 < found["overlap"] < 2 * SPEED * found["time"]


def test_robots_that_pass_at_a_hair_s_breadth_do_not_touch() -> None:
    assert noted(head_on(2 * HULL + 2e-4)) == []
    assert len(noted(head_on(2 * HULL - 2e-4))) == 1


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_robots_that_meet_off_centre_close_in_along_the_line_of_their_centres(share: float) -> None:
    (found,) = noted(head_on(share * 2 * HULL))
    assert found["closing_speed"] == pytest.approx(2 * SPEED * np.sqrt(1 - share**2), rel=0.01)


def test_everyone_of_a_crowd_that_touches_is_noted() -> None:
    """A robot in the middle of six, and these in a ring: twelve pairs, 0.1 mm into each other."""
    angle = np.pi / 3 * np.arange(6)
    ring = (2 * HULL - 1e-4) * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    pose = np.concatenate([np.zeros((1, 3)), np.column_stack([ring, angle])])
    found = noted(driven(pose, np.zeros(7), 0.01))
    pairs = {frozenset((int(each["robot"]), int(each["partner"]))) for each in found}
    expected = {frozenset((0, k)) for k in range(1, 7)} | {frozenset((k, k % 6 + 1)) for k in range(1, 7)}
    assert pairs == expected
    assert len(found) == 12


def test_robots_behind_a_virtual_leader_are_noted_by_their_places_among_all() -> None:
    pose = np.array([[9.0, 9.0, 0.0], [0.0, 0.0, 0.0], [0.119, 0.0, 0.0]])
    (found,) = noted(driven(pose, np.zeros(3), 0.01, virtual_root=True))
    assert (found["robot"], found["partner"]) == (1, 2)


def test_robots_that_cannot_touch_note_nothing() -> None:
    scene = make_scene(SceneSpec(("a",)))
    assert MujocoSimulation(scene, DT).motion.touch.size == 0
