"""What counts as an event, when it begins and ends, and how it is told; on runs made by hand and on real ones."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from nhtrack.analysis.event import Event, Touch, sentences
from nhtrack.analysis.events import AT_LIMIT, CLEAR, CREEP, HIGH, LEANING, LIFTED, SPINNING, STILL, find_events
from nhtrack.analysis.metrics import summary
from nhtrack.analysis.spells import GAP, joined_spells, lasting
from nhtrack.effects.patches import Patches
from nhtrack.experiment.load import load, load_text
from nhtrack.ground import Patch
from nhtrack.recording import Recording, make_recording
from nhtrack.report.summary_text import run_verdicts
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.spec import SceneSpec
from nhtrack.studies.run.result import Outcome
from nhtrack.studies.run.run import simulate
from nhtrack.studies.run.tables import print_outcome
from recordings import synthetic_recording

# Times in these tests are sums of periods of 10 ms; far below a period, far above rounding.
SAME_TIME = 1e-9  # [s]

DT = 0.01
ROWS = 301
TIME = np.arange(ROWS) * DT
WHEEL_RADIUS, HALF_SEPARATION, NO_LOAD_SPEED = 0.03, 0.05, 50.0
TOP_SPEED = WHEEL_RADIUS * NO_LOAD_SPEED
DRIVE = {"wheel_radius": WHEEL_RADIUS, "half_separation": HALF_SEPARATION, "no_load_speed": NO_LOAD_SPEED}
LEADER, FOLLOWER = 0, 1
LEFT, RIGHT = 0, 1


class Story:
    """Two robots that stand still on their wheels, until told otherwise; as in a run, row 0 knows no forces."""

    def __init__(self) -> None:
        wheels = {"wheel_load": 2.7, "friction_utilisation": 0.1, "longitudinal_slip": 0.0, "torque_saturation": 0.0}
        self.arrays = {name: np.full((ROWS, 2, 2), value) for name, value in wheels.items()}
        for name in ("wheel_load", "friction_utilisation", "torque_saturation"):
            self.arrays[name][0] = np.nan
        self.arrays |= {name: np.zeros((ROWS, 2)) for name in ("lateral_slip", "tilt")}
        self.arrays |= {"wheel_clearance": np.zeros((ROWS, 2, 2))}
        self.arrays |= {"wheel_speed": np.zeros((ROWS, 2, 2)), "pose": np.zeros((ROWS, 2, 3))}
        self.arrays |= {"ideal_pose": np.zeros((ROWS, 2, 3)), "error": np.zeros((ROWS, 2, 3))}
        self.arrays["friction_utilisation_predicted"] = self.arrays["friction_utilisation"].copy()

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    def slide(self, rows: slice | int, robot: int, wheel: int, speed: float, used: float = 1.0) -> None:
        self["friction_utilisation"][rows, robot, wheel] = used
        self["longitudinal_slip"][rows, robot, wheel] = speed

    def lift(self, rows: slice | int, wheel: int, height: float = 0.002, load: float = 0.0) -> None:
        """Makes a wheel of the follower rise above the floor [m] and bear a load [N]."""
        self["wheel_load"][rows, FOLLOWER, wheel] = load
        self["wheel_clearance"][rows, FOLLOWER, wheel] = height

    def touch(self, row: int, *noted: float, slot: int = 0) -> None:
        """Makes the follower touch the leader in a row: time in contact, impulse, closing speed, overlap."""
        self.arrays.setdefault("touch", np.full((ROWS, 2, 3, 5), np.nan))[row, FOLLOWER, slot] = LEADER, *noted

    def drive(self, speed: float, turning: float = 0.0) -> None:
        """Makes the follower go ahead [m/s] and turn [rad/s]."""
        self["pose"][:, FOLLOWER, 0], self["pose"][:, FOLLOWER, 2] = speed * TIME, turning * TIME

    def recording(self, **changes: Any) -> Recording:
        attributes = {
            "name": "by hand", "backend": "mujoco", "outcome": "completed", "length_scale": 1.0, "time_scale": 1.0,
            "parents": {"leader": [], "follower": ["leader"]},
        } | DRIVE | changes  # fmt: skip
        kept = {key: value for key, value in attributes.items() if value is not None}
        return make_recording(TIME, ("leader", "follower"), self.arrays, kept)

    def events(self, **changes: Any) -> tuple[Event, ...]:
        return find_events(self.recording(**changes))


@pytest.fixture
def story() -> Story:
    return Story()


def spans(events: tuple[Event, ...]) -> list[tuple[str, str | None, float, float]]:
    return [(event.kind, event.wheel, round(event.start, 6), round(event.end, 6)) for event in events]


# -- nothing ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("followers", [1, 9])
def test_a_run_that_went_well_has_no_events(followers: int) -> None:
    assert find_events(synthetic_recording(followers, samples=201)) == ()
    assert sentences(()) == ()


def test_the_ideal_integrator_has_no_wheels_to_slip(story: Story) -> None:
    """Its utilisation is a prediction: it may say 5 and nothing slides."""
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    assert story.events() != ()
    assert story.events(backend="ideal") == ()


def test_what_a_recording_does_not_know_is_not_looked_for() -> None:
    """Each kind needs what it compares, and nothing else."""
    story = Story()
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story["tilt"][50:60, LEADER] = 0.2
    del story.arrays["longitudinal_slip"], story.arrays["wheel_load"], story.arrays["wheel_speed"]
    assert [event.kind for event in story.events()] == ["leaning"]


# -- hopping ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("trusted", "wheels"),
    [(1.2, ["left"]), (0.0, ["both"]), (2.0, []), (None, [])],
    ids=["firm", "default", "all", "old"],
)
def test_slides_whose_loads_are_not_known_are_told(story: Story, trusted: float, wheels: list[str]) -> None:
    """The left wheel stands on rubber, both slide."""
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story.slide(slice(10, 20), FOLLOWER, RIGHT, 0.3)
    story["wheel_load"][15, FOLLOWER, LEFT] = 9.0
    rubber = Patch(1.5, disc=(0.0, HALF_SEPARATION, 0.02))
    scene = SceneSpec(robots=("leader", "follower"), friction=0.8, effects=(Patches((rubber,)),)).to_json()
    found = [event for event in story.events(scene=scene, trusted_friction=trusted) if event.kind == "hopping"]
    assert [event.wheel for event in found] == wheels
    assert all("9 N at the most" in said for said in sentences(found))


# -- slipping ---------------------------------------------------------------------------------------


def test_a_slide_lasts_from_the_start_of_its_first_period_to_the_end_of_its_last(story: Story) -> None:
    """Rows 10 to 19 tell of the periods that end at 0.10 s to 0.19 s."""
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.2)
    story.slide(14, FOLLOWER, LEFT, -0.3)
    assert story.events() == (
        Event("slipping", "follower", "left", TIME[9], TIME[19], "slip speed", 0.3, "m/s"),
    )


@pytest.mark.parametrize(
    ("used", "speed", "slips"),
    [
        (1.0, 2 * CREEP, True),
        (1.0, CREEP, False),  # at the limit, but held: the other wheel bears the rest
        (AT_LIMIT, 1.0, True),
        (AT_LIMIT - 1e-6, 1.0, False),  # such speeds are those of soft contacts, or of a wheel in the air
        (math.inf, 1.0, True),  # no friction at all
        (math.nan, 1.0, False),
        (1.0, math.nan, False),
    ],
)
def test_a_wheel_slips_at_its_limit_and_above_creep(story: Story, used: float, speed: float, slips: bool) -> None:
    story.slide(slice(10, 20), FOLLOWER, LEFT, speed, used)
    assert (spans(story.events()) == [("slipping", "left", 0.09, 0.19)]) == slips
    assert len(story.events()) == slips


def test_slip_is_that_of_the_wheel_that_slides_in_both_directions(story: Story) -> None:
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story["lateral_slip"][10:20, FOLLOWER] = -0.4
    story["longitudinal_slip"][10:20, FOLLOWER, RIGHT] = 7.0  # this one holds
    (event,) = story.events()
    assert (event.wheel, event.worst) == ("left", pytest.approx(0.5))


def test_both_wheels_make_one_event(story: Story) -> None:
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story.slide(slice(15, 40), FOLLOWER, RIGHT, 0.1)
    story.slide(slice(70, 80), FOLLOWER, RIGHT, 0.2)
    assert spans(story.events()) == [("slipping", "both", 0.09, 0.39), ("slipping", "right", 0.69, 0.79)]


# -- a wheel off the floor --------------------------------------------------------------------------


def test_a_wheel_is_off_the_floor_when_it_bears_no_load_for_long_enough(story: Story) -> None:
    rows = round(LIFTED / DT)
    story.lift(slice(10, 10 + rows), LEFT, 0.002)
    story.lift(slice(100, 100 + rows - 1), LEFT, 0.002)  # a hop
    story.lift(slice(200, 220), LEFT, load=0.01)  # touches in some physics steps of each period
    (event,) = story.events()
    assert event == Event("wheel off the floor", "follower", "left", TIME[9], TIME[9 + rows], "height", 0.002, "m")


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
@pytest.mark.parametrize(("height", "lifted"), [(0.9, False), (1.1, True)])
def test_a_wheel_off_the_floor_is_clear_of_it(story: Story, size: float, height: float, lifted: bool) -> None:
    """Load alone does not tell: contacts that chatter bear nothing for as long as one likes."""
    story.lift(slice(10, 40), LEFT, height * CLEAR * WHEEL_RADIUS * size)
    assert bool(story.events(wheel_radius=WHEEL_RADIUS * size)) == lifted


def test_a_wheel_that_rises_higher_than_any_hop_is_off_the_floor_at_once(story: Story) -> None:
    story.lift(slice(10, 14), LEFT, 0.9 * HIGH * WHEEL_RADIUS)
    assert story.events() == ()
    story.lift(12, LEFT, 1.1 * HIGH * WHEEL_RADIUS)
    assert spans(story.events()) == [("wheel off the floor", "left", 0.09, 0.13)]


def test_wheels_that_rise_after_each_other_make_one_event(story: Story) -> None:
    story.lift(slice(10, 25), LEFT, 0.01)
    story.lift(slice(30, 45), RIGHT, 0.03)
    (event,) = story.events()
    assert (event.wheel, event.worst) == ("both", 0.03)


def test_a_wheel_that_hops_is_never_off_the_floor_and_bears_its_load_on_the_mean(story: Story) -> None:
    """A flight of 0.03 s is 1.1 mm high; landing, the wheel bears in 0.01 s what it did not in four times that."""
    for row in range(1, ROWS - 4, 4):
        story.lift(slice(row, row + 3), LEFT, 9.81 * 0.03**2 / 8)
        story["wheel_load"][row + 3, FOLLOWER, LEFT] = 4 * 2.7
    found = story.recording()
    assert find_events(found) == ()
    assert summary(found)["robots"]["follower"]["smallest_wheel_load"] >= 2 / 10 * 4 * 2.7 * (1 - 1e-12)


# -- robots that touch ------------------------------------------------------------------------------


def test_robots_that_touch_are_an_event_of_both(story: Story) -> None:
    """Rows 10 and 15 are less than a tenth of a second apart; row 60 is another event."""
    story.touch(10, 0.004, 0.2, 0.5, 0.003)
    story.touch(15, 0.010, 0.1, 0.1, 0.004)
    story.touch(60, 0.002, 0.3, 0.2, 0.001, slot=2)
    first, second = story.events()
    assert first == Event(
        "touched", "leader", None, TIME[9], TIME[15], "closing speed", 0.5, "m/s",
        Touch("follower", pytest.approx(0.014), pytest.approx(0.3), 0.004),
    )  # fmt: skip
    assert (second.robots, second.worst) == (("leader", "follower"), 0.2)
    assert sentences((first, second)) == (
        "leader and follower touched twice: in contact for 0.016 s, first at 0.09 s, closing in at up to 0.5 m/s, with "
        "an impulse of 0.6 N s, hulls overlapping by up to 4 mm",
        "robots touched first at 0.09 s: ideal twins pass through, gaps to them are until then",
    )


def test_gaps_to_ideal_twins_end_where_robots_touch_and_it_is_said(story: Story) -> None:
    story["ideal_pose"][:, FOLLOWER, 0] = np.linspace(0.0, 3.0, ROWS)
    story["ideal_pose"][:, FOLLOWER, 2] = np.linspace(0.0, 6.0, ROWS)
    figures = summary(story.recording())
    assert figures["robots"]["follower"]["gap_position_max"] == 3.0
    assert figures["twin_compared_until"] is None
    story.touch(101, 0.01, 0.1, 0.1, 0.001)
    figures = summary(story.recording())
    follower = figures["robots"]["follower"]
    assert figures["twin_compared_until"] == TIME[100]
    assert follower["gap_position_max"] == pytest.approx(1.0) == follower["gap_heading_max"] / 2
    assert follower["gap_position_rms"] == pytest.approx(np.sqrt((np.linspace(0, 1, 101) ** 2).mean()))
    assert any("Until robots first touched, at 1 s," in told for told in run_verdicts(figures))
    assert any("leader and follower touched hardest of all, at 1 s" in told for told in run_verdicts(figures))
    assert any("gaps are until 1 s, when robots first touched" in line for line in printed(story.recording()))


# -- stuck ------------------------------------------------------------------------------------------


def spinning(story: Story, rows: slice = slice(None), share: float = 1.0) -> Story:
    story["wheel_speed"][rows, FOLLOWER, LEFT] = -share * NO_LOAD_SPEED
    return story


def test_a_robot_is_stuck_when_its_wheels_spin_and_it_stays(story: Story) -> None:
    (event,) = spinning(story, slice(50, 101)).events()
    assert event == Event("stuck", "follower", None, TIME[49], TIME[100], "rim speed", TOP_SPEED, "m/s")


def test_a_robot_is_stuck_when_its_motors_are_at_their_limits_and_it_stays(story: Story) -> None:
    story["torque_saturation"][50:101, FOLLOWER, RIGHT] = 0.8
    assert spans(story.events()) == [("stuck", None, 0.49, 1.0)]
    assert story.events()[0].worst == 0.0  # held so that its wheels cannot even turn


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
@pytest.mark.parametrize(("speed", "stuck"), [(0.9, True), (1.1, False)])
def test_robots_of_any_size_are_measured_by_their_own_speed(
    story: Story, size: float, speed: float, stuck: bool
) -> None:
    """A robot size times as large, with wheels as fast: lengths and speeds go with size."""
    spinning(story).drive(speed * STILL * TOP_SPEED * size)
    changes = {"wheel_radius": size * WHEEL_RADIUS, "half_separation": size * HALF_SEPARATION}
    assert bool(story.events(**changes)) == stuck


def test_turning_on_the_spot_is_motion(story: Story) -> None:
    spinning(story).drive(0.0, turning=1.1 * STILL * TOP_SPEED / HALF_SEPARATION)
    assert story.events() == ()


def test_wheels_that_roll_slowly_do_not_spin(story: Story) -> None:
    """A robot that parks: slow, and its wheels as slow."""
    assert spinning(story, share=0.9 * SPINNING).events() == ()
    assert len(spinning(story, share=1.1 * SPINNING).events()) == 1


# -- leaning and tipping ----------------------------------------------------------------------------


def test_a_robot_leans_beyond_five_degrees(story: Story) -> None:
    story["tilt"][10:20, FOLLOWER] = np.radians(6.0)
    story["tilt"][100:120, FOLLOWER] = np.radians(4.9)
    (event,) = story.events()
    assert event == Event("leaning", "follower", None, TIME[9], TIME[19], "tilt", np.radians(6.0), "rad")


def test_a_robot_tips_over_where_the_run_ends_for_it(story: Story) -> None:
    """The row in which it would lie on its side is not recorded any more."""
    story["tilt"][280:, FOLLOWER] = np.linspace(0.1, 0.5, ROWS - 280)
    end = {"diverged_robot": "follower", "diverged_time": 3.01, "diverged_reason": "tipped over"}
    leaning, tipped = story.events(**end)
    assert (leaning.kind, leaning.end) == ("leaning", pytest.approx(3.0, abs=SAME_TIME))
    assert tipped == Event("tipped", "follower", None, 3.01, 3.01, "tilt", 0.5, "rad")


def test_only_tipping_is_tipping(story: Story) -> None:
    """Neither another divergence nor words in the outcome."""
    end = {"diverged_robot": "follower", "diverged_time": 3.01, "diverged_reason": "state is not finite"}
    assert story.events(**end) == ()
    assert story.events(outcome="diverged: tipped over: robot 'follower' at t = 3.010 s (simulation 0)") == ()


# -- spells and gaps --------------------------------------------------------------------------------


def periods_that_hold(holds: list[bool]) -> list[list[int]]:
    """Rows of every spell, one by one."""
    rows = enumerate(holds)
    return [[row for row, _ in spell] for held, spell in itertools.groupby(rows, key=lambda row: row[1]) if held]


@pytest.mark.parametrize(("rows", "events"), [(9, 1), (10, 2), (11, 2)])
def test_a_tenth_of_a_second_parts_two_events(story: Story, rows: int, events: int) -> None:
    """Between rows that tell of slipping lie as many periods as there are rows that do not."""
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story.slide(slice(20 + rows, 60), FOLLOWER, LEFT, 0.3)
    assert rows * DT == pytest.approx(GAP, rel=0.2)
    assert len(story.events()) == events


# Periods in milliseconds, so that no gap of whole milliseconds is on a knife's edge of rounding.
clocks = st.integers(1, 60).flatmap(
    lambda size: st.tuples(
        st.lists(st.integers(1, 80), min_size=size, max_size=size),
        st.lists(st.booleans(), min_size=size + 1, max_size=size + 1),
    )
)


@pytest.mark.slow
@given(clocks)
def test_spells_less_than_a_gap_apart_are_one_event_and_others_are_not(drawn: tuple[list[int], list[bool]]) -> None:
    ticks = np.cumsum([0, *drawn[0]])
    holds = drawn[1]
    expected: list[list[int]] = []
    for spell in periods_that_hold(holds):
        # A spell begins where its first period does: the time between is that of the periods that do not hold.
        if expected and ticks[spell[0] - 1] - ticks[expected[-1][-1]] < round(1e3 * GAP):
            expected[-1] += spell
        else:
            expected.append(list(spell))
    found = joined_spells(np.array(holds), ticks * 1e-3)
    assert [(rows.start, rows.stop - 1) for rows in found] == [(rows[0], rows[-1]) for rows in expected]


@pytest.mark.slow
@given(clocks, st.integers(0, 200))
def test_spells_that_are_too_short_are_left_out_whole(drawn: tuple[list[int], list[bool]], shortest: int) -> None:
    ticks = np.cumsum([0, *drawn[0]])
    holds = np.array(drawn[1])
    expected = np.zeros(len(holds), dtype=bool)
    for spell in periods_that_hold(drawn[1]):
        expected[spell] = ticks[spell[-1]] - ticks[max(spell[0] - 1, 0)] >= shortest
    before = holds.copy()
    np.testing.assert_array_equal(lasting(holds, ticks * 1e-3, shortest * 1e-3), expected)
    np.testing.assert_array_equal(holds, before)


@pytest.mark.parametrize("values", [(0.0, 1.0, math.nan), (0.0, math.nan)])
def test_an_unknown_row_is_one_in_which_nothing_happens(story: Story, values: tuple[float, ...]) -> None:
    random = np.random.default_rng(3)
    used = np.repeat(random.choice(values, 60), random.integers(1, 20, 60))[: ROWS - 1]
    story.slide(slice(1, None), FOLLOWER, LEFT, 0.3)
    story["friction_utilisation"][1:, FOLLOWER, LEFT] = used
    found = story.events()
    assert (len(found) > 3) == (1.0 in values)
    story["friction_utilisation"][:] = np.nan_to_num(story["friction_utilisation"])
    assert found == story.events()


# -- in words ---------------------------------------------------------------------------------------


def test_events_are_told_in_the_order_of_time(story: Story) -> None:
    story["tilt"][10:20, FOLLOWER] = 0.2
    story.slide(slice(5, 8), FOLLOWER, LEFT, 0.3)
    story.slide(slice(10, 20), LEADER, LEFT, 0.3)
    told = [(event.robot, event.kind) for event in story.events()]
    assert told == [("follower", "slipping"), ("leader", "slipping"), ("follower", "leaning")]


def test_a_sentence_for_each_robot_and_kind(story: Story) -> None:
    story.slide(slice(10, 20), FOLLOWER, LEFT, 0.3)
    story.slide(slice(100, 130), FOLLOWER, RIGHT, 0.25)
    story.slide(slice(50, 60), LEADER, LEFT, 2.0)
    spinning(story, slice(200, 260))
    assert sentences(story.events()) == (
        "follower slid: a wheel was at its friction limit for 0.4 s, first at 0.09 s, sliding at up to 0.3 m/s",
        "leader slid: a wheel was at its friction limit for 0.1 s, first at 0.49 s, sliding at up to 2 m/s",
        "follower was stuck: hardly moved for 0.6 s, first at 1.99 s, while its wheels turned at up to 1.5 m/s at "
        "their rims",
    )


@pytest.mark.parametrize(("wheels", "told"), [([LEFT], "its left wheel"), ([LEFT, RIGHT], "its wheels")])
def test_a_sentence_names_the_wheel_that_was_off_the_floor(story: Story, wheels: list[int], told: str) -> None:
    for k, wheel in enumerate(wheels):
        story.lift(slice(10 + 50 * k, 20 + 50 * k), wheel)
    seconds = f"{0.1 * len(wheels):.2g} s"
    assert sentences(story.events()) == (
        f"follower lifted {told}: off the floor for {seconds}, first at 0.09 s",
    )


def printed(recording: Recording) -> list[str]:
    console = Console(width=100)
    with console.capture() as screen:
        print_outcome(Outcome(recording, summary(recording), None), console)
    return [line.rstrip() for line in screen.get().splitlines()]


def test_the_terminal_shows_the_first_events_and_counts_the_others(story: Story) -> None:
    for k in range(15):
        story.slide(slice(1 + 20 * k, 6 + 20 * k), FOLLOWER, LEFT, 0.1 * (k + 1))
    lines = printed(story.recording())
    table = lines[lines.index("What went wrong on wheels") :]
    assert len([line for line in table if line.split()[:1] == ["slipping"]]) == 12
    assert table[2].split() == "slipping follower left 0 s 0.05 s slip speed 100 mm/s".split()
    assert table[-1].strip() == "and 3 more in summary.json"


def test_the_terminal_shows_angles_in_degrees_and_both_robots_of_a_contact(story: Story) -> None:
    story.lift(slice(10, 20), RIGHT)
    story.touch(10, 0.004, 0.2, 0.5, 0.003)
    story["tilt"][11:20, FOLLOWER] = np.radians(7.5)
    lines = [line.split() for line in printed(story.recording())]
    assert "wheel off the floor follower right 0.09 s 0.19 s height 2 mm".split() in lines
    assert "touched leader, follower - 0.09 s 0.1 s closing speed 500 mm/s".split() in lines
    assert "leaning follower - 0.1 s 0.19 s tilt 7.5°".split() in lines


# -- real wheels ------------------------------------------------------------------------------------

CART_ON_ICE = """
name: ice
robot: warehouse
duration: 4
physics: {friction: 0.8, slope: {angle: 0.07}, patches: [{friction: 0.05, disc: [2, 0, 1.5]}]}
law: {name: universal}
leader: {start: {pose: [0, 0, 0]}, input: {u_x: "0.8", u_theta: "0"}}
followers: [{name: F, parents: [leader], start: {pose: [-1.2, 0.1, 0]}}]
"""
# Nothing is commanded, and motors do not keep wheels from turning as fast.
DRIVES_ON = ("leader.input.u_x=0", "leader.input.u_theta=0", "physics.motors={torque_limit: 0.09, no_load_speed: 400}")
FAST_TURN = ("physics.friction=3", "leader.start.twist=[2.4, 15]")  # v omega twice g b/h: see tests/fidelity


def outcome(*overrides: str, duration: float) -> Outcome:
    return simulate(load("tour/hello", [*overrides, f"duration={duration}"]))


def kinds(found: Outcome, robot: str) -> set[str]:
    return {event["kind"] for event in found.summary["events"] if event["robot"] == robot}


@pytest.mark.slow
class TestRealWheels:
    def test_on_a_slippery_floor_the_follower_slides_and_no_wheel_is_said_to_lift(self) -> None:
        """While wheels slide, loads of single physics steps are zero as often as not; their means are not."""
        found = outcome("physics.friction=0.03", duration=3.0)
        assert kinds(found, "leader") == set()
        assert kinds(found, "follower") == {"slipping"}
        (event,) = found.summary["events"]
        assert (event["wheel"], event["start"], event["end"]) == ("both", 0.0, pytest.approx(3.0, abs=SAME_TIME))
        slip = found.recording["longitudinal_slip"].sel(robot="follower").values
        assert np.abs(slip).max() <= event["worst"] < TOP_SPEED + 0.5
        assert sum("follower slid" in told for told in found.summary["warnings"]) == 1

    def test_without_friction_robots_are_stuck_with_spinning_wheels(self) -> None:
        found = outcome("physics.friction=0", duration=1.5)
        for robot in ("leader", "follower"):
            assert kinds(found, robot) == {"slipping", "stuck"}
        stuck = [event for event in found.summary["events"] if event["kind"] == "stuck"]
        assert all(event["end"] == pytest.approx(1.5, abs=SAME_TIME) for event in stuck)
        attributes = found.recording.dataset.attrs
        top = attributes["wheel_radius"] * attributes["no_load_speed"]
        assert max(event["worst"] for event in stuck) == pytest.approx(top, rel=0.01)

    def test_a_robot_that_tips_lifts_a_wheel_and_leans_first(self) -> None:
        found = outcome(*FAST_TURN, duration=1.0)
        assert found.failure is not None
        first = found.recording.dataset.isel(time=0)
        np.testing.assert_array_equal(first["ideal_pose"], first["pose"])  # the twin went on: its first rows are kept
        assert kinds(found, "follower") == set()
        events = {event["kind"]: event for event in found.summary["events"]}
        assert {"wheel off the floor", "leaning", "tipped"} <= set(events)
        lifted, leaning, tipped = (events[kind] for kind in ("wheel off the floor", "leaning", "tipped"))
        assert lifted["start"] < leaning["start"] < leaning["end"] < tipped["start"]
        assert tipped["start"] == tipped["end"] == found.failure.time == found.recording.dataset.attrs["diverged_time"]
        assert LEANING < tipped["worst"] == leaning["worst"] < np.radians(30.0)
        assert any(told.startswith("leader tipped over: at ") for told in found.summary["warnings"])

    @pytest.mark.parametrize(("share", "falls"), [(0.8, False), (1.1, True)])
    def test_a_wheel_lifts_where_the_turn_leaves_it_no_load(self, share: float, falls: bool) -> None:
        """On a circle a robot tips about the line from its outer wheel to its caster, which is l behind the axle.

        With the CoM c_x ahead of the axle and h high, m g is at b (c_x + l)/L from this line, of length L, and m v
        omega is across it by l/L: it tips where v omega = g (b/h) (1 + c_x/l). A wheel that bears little slips first.
        """
        drive = read_robot(SceneSpec(("robot",))).plant
        c_x, _, h = drive.com
        most = 9.81 * drive.half_separation / h * (1 - c_x / drive.casters[0][0])
        turn = f"leader.start.twist=[2.4, {share * most / 2.4}]"
        found = outcome(*DRIVES_ON, "physics.friction=3", turn, duration=1.0)
        told = {"wheel off the floor", "leaning", "tipped"} & kinds(found, "leader")
        assert told == ({"wheel off the floor", "leaning", "tipped"} if falls else set())
        its = [event for event in found.events if event.robot == "leader"]
        lifted = {event.wheel for event in its if event.kind == "wheel off the floor"}
        assert lifted == ({"left"} if falls else set())

    @pytest.mark.parametrize(("used", "slips"), [(0.95, False), (1.05, True)])
    def test_wheels_slip_where_they_are_asked_for_more_than_the_floor_holds(self, used: float, slips: bool) -> None:
        """Straight on each wheel gives half of m a; accelerating loads the wheels, the caster lies behind them."""
        drive, a, zero = read_robot(SceneSpec(("robot",))).plant, np.array(0.5), np.zeros(())
        holds = drive.mass * float(a) / 2 / float(drive.wheel_loads(zero, zero, a, zero)[0])
        changes = (f"physics.friction={holds / used}", "leader.input.u_x=0.5", "leader.input.u_theta=0")
        found = outcome(*changes, "leader.start.twist=[0, 0]", duration=0.5)
        assert kinds(found, "leader") == ({"slipping"} if slips else set())
        untold = outcome(*changes, "leader.start.twist=[0, 0]", "physics.contact.model=default", duration=0.5)
        assert not slips or kinds(untold, "leader") == {"slipping", "hopping"}

    def test_a_cart_whose_wheels_spin_on_ice_stays_on_the_floor(self) -> None:
        """It bears all the while what it did before, but for what it then gains in speed."""
        found = simulate(load_text(CART_ON_ICE))
        load, slip = (found.recording[name].values[:, 0] for name in ("wheel_load", "longitudinal_slip"))
        assert np.abs(slip).max() > 2
        np.testing.assert_allclose(load[1:], np.full_like(load[1:], load[1, 0]), rtol=0.03)
        assert kinds(found, "leader") == {"slipping"}
