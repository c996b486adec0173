"""What a motion asks of wheels and motors, and the time scale at which it fits."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import tolerances as tol
from nhtrack.analysis.demand import demands, predictions, wheel_uses
from nhtrack.analysis.motion import IdealMotion, motion_of
from nhtrack.analysis.speedup import LIMITS, bindings, largest_factors
from nhtrack.config.scenario import Scenario
from nhtrack.errors import FeasibilityError, ScenarioError
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load_text
from nhtrack.ground import Ground
from nhtrack.robots.diff_drive import DiffDrive
from nhtrack.robots.diff_drive.losses import WheelLosses
from nhtrack.similarity import rounded_up
from nhtrack.simulation.ideal import IdealSimulation
from nhtrack.simulation.robot_models import load_robot
from nhtrack.studies.feasibility.result import Feasibility
from nhtrack.studies.feasibility.run import feasibility, fitting_time, ideal_motion, with_time
from nhtrack.studies.run.run import simulate

CASE = """
name: case
duration: 8
similarity: {length: 0.3, time: auto}
leader:
  start: {pose: [0, 0, 0]}
  input: {u_x: 0.5, u_theta: "0.3*cos(t)"}
followers:
  - {name: follower, parents: [leader], start: {pose: [-3, 2, 0.5], twist: [0.2, 0.1]}}
law: {name: published, kp: 4, kd: 6, ke: 1, k: 5, dead_zone: {length: 0, speed: 0}}
"""


@pytest.fixture(scope="module")
def drive() -> DiffDrive:
    return load_robot("nh_mini").model


def case(*overrides: str) -> Scenario:
    return load_text(CASE, overrides=overrides)


def sped_up(motion: IdealMotion, factor: float) -> IdealMotion:
    """Returns the motion with its time divided by a factor, THEORY 6 with L = 1."""
    squared = factor**2
    return motion._replace(
        time=motion.time / factor,
        v=motion.v * factor,
        omega=motion.omega * factor,
        u_x=motion.u_x * squared,
        u_theta=motion.u_theta * squared,
    )


def at_one_place(
    v: np.ndarray, omega: np.ndarray, u_x: np.ndarray, u_theta: np.ndarray, theta: float = 0.0
) -> IdealMotion:
    """Returns a motion of one instant, at the origin."""
    return IdealMotion(np.zeros(1), np.array([[0.0, 0.0, theta]]), v, omega, u_x, u_theta)


def shares(motion: IdealMotion, drive: DiffDrive, ground: Ground) -> dict[str, float]:
    """Returns the largest share of each limit, from the reduced model and the motor themselves."""
    gravity, friction = ground.gravity_at(motion.g[..., 2]), ground.friction_at(drive.wheel_places(motion.g))
    torque, speed = drive.wheel_torques(*motion.rates, gravity), drive.wheel_speeds(motion.v, motion.omega)
    direction = np.sign(torque)
    beyond = direction * drive.motor.saturate(1e3 * direction, speed)
    return {
        "friction": float(drive.friction_utilisation(*motion.rates, friction, gravity).max()),
        "wheel speed": float(np.abs(speed).max() / drive.motor.no_load_speed),
        "wheel torque": float((np.abs(torque) / np.maximum(beyond, 1e-300)).max()),
    }


# -- one motion -------------------------------------------------------------------------------------

rates = st.tuples(*(st.floats(-bound, bound) for bound in (1.0, 10.0, 3.0, 30.0))).filter(
    lambda motion: max(map(abs, motion)) > 1e-3
)


slopes = st.floats(0.0, 1.0)  # of the friction angle: on a steeper one nothing holds


lossy = st.sampled_from(
    [WheelLosses(), WheelLosses((1e-3, 5e-4), (0.0, 0.0)), WheelLosses((2e-4, 1e-3), (0.004, 0.01))]
)


@settings(max_examples=100)
@given(rates, st.floats(0.05, 1.5), slopes, st.floats(-4.0, 4.0), lossy)
def test_sped_up_by_its_largest_factor_a_motion_stands_at_its_limit(
    drive: DiffDrive,
    rate: tuple[float, float, float, float],
    friction: float,
    share: float,
    theta: float,
    losses: WheelLosses,
) -> None:
    drive = replace(drive, losses=losses)
    ground = Ground(friction, slope=0.6 * share * math.atan(friction), uphill=0.7)  # the caster holds nothing
    motion = at_one_place(*(np.array([value]) for value in rate), theta=theta)
    factors = largest_factors(motion, drive, ground).min(axis=(1, 2))
    assume(factors.min() > 0)  # a slope on which the motors or the floor cannot even hold the robot
    limit = LIMITS[int(factors.argmin())]
    at_limit = shares(sped_up(motion, factors.min()), drive, ground)
    assert at_limit[limit] == pytest.approx(1.0, rel=tol.AT_THE_LIMIT)
    assert max(at_limit.values()) <= 1 + tol.AT_THE_LIMIT
    assert max(shares(sped_up(motion, 1.01 * factors.min()), drive, ground).values()) > 1


def test_limits_by_hand(drive: DiffDrive) -> None:
    """Straight on: speed and torque alone; a robot that stands can be sped up for ever."""
    zero, one = np.zeros(1), np.ones(1)
    cruising = largest_factors(at_one_place(one, zero, zero, zero), drive, Ground(1.0))[:, 0, 0]
    top_speed = drive.motor.no_load_speed * drive.wheel_radius
    assert cruising[0] == np.inf
    assert cruising[1] == pytest.approx(top_speed, rel=tol.HAND)
    starting = largest_factors(at_one_place(zero, zero, one, zero), drive, Ground(100.0))[:, 0, 0]
    strongest = 2 * drive.motor.torque_limit / (drive.wheel_radius * drive.m_eff)
    assert starting[1:] == pytest.approx([np.inf, math.sqrt(strongest)], rel=tol.HAND)
    assert np.all(largest_factors(at_one_place(zero, zero, zero, zero), drive, Ground(0.0)) == np.inf)
    assert largest_factors(at_one_place(zero, zero, one, zero), drive, Ground(0.0))[0].max() == 0


@pytest.mark.parametrize(
    ("v", "told"), [(1.2, "wheel_speed"), (0.3, "wheel_torque"), (-1.2, None), (1.5, "wheel_speed")]
)
def test_what_is_used_of_a_motor_s_line_is_told_of_its_larger_part(
    drive: DiffDrive, v: float, told: str | None
) -> None:
    """One that brakes has its torque and its no-load speed; beyond that speed nothing is told of its torque."""
    weak = replace(drive, motor=replace(drive.motor, torque_limit=math.inf, stall_torque=0.02))
    motion = at_one_place(np.array([v]), np.zeros(1), np.array([1.0]), np.zeros(1))
    uses = {name: use for name, _, use in wheel_uses(motion, weak, Ground(1.0))}
    torque, speed = weak.wheel_torques(*motion.rates, Ground().gravity_at(np.zeros(1))), v / weak.wheel_radius
    parts = {"wheel_torque": abs(torque[0, 0]) / 0.02, "wheel_speed": abs(speed) / weak.motor.no_load_speed}
    for name, part in parts.items():
        expected = sum(parts.values()) if name == told else 0.0 if told and name == "wheel_torque" else part
        assert uses[name].share[0, 0] == pytest.approx(expected, rel=tol.HAND)


def test_rounding_goes_up_and_keeps_four_digits() -> None:
    assert rounded_up(3.1527001) == 3.153
    assert rounded_up(3.153) == 3.153
    assert rounded_up(0.99991) == 1.0
    assert rounded_up(123456.0) == 123500.0


@settings(max_examples=50)
@given(st.floats(1e-6, 1e9))
def test_a_rounded_time_is_never_smaller_and_hardly_larger(value: float) -> None:
    assert value <= rounded_up(value) <= value * (1 + 1.0001e-3)


# -- a run ------------------------------------------------------------------------------------------


def test_a_run_scaled_by_formula_is_the_run_at_that_scale(drive: DiffDrive) -> None:
    """The same periods in scenario time: the control rate scales along."""
    one = case("similarity.time=2", "control_rate=50")
    other = case("similarity.time=3", "control_rate=33.333333333333336", "physics.timestep=0.01")
    runs = [(build(scenario), ideal_motion(build(scenario))[0]) for scenario in (one, other)]
    assert [len(run.time) for _, run in runs] == [801, 801]
    (slow, quick) = (motion_of(run) for _, run in runs)
    for found, expected in zip(sped_up(slow, 2 / 3), quick, strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=tol.SAME_IN_OWN_UNITS * np.abs(expected).max())
    fitting = [
        [scenario.similarity.time_scale / found.factor for found in bindings(experiment, run, drive, Ground(0.7))]
        for scenario, (experiment, run) in zip((one, other), runs, strict=True)
    ]
    assert fitting[0] == pytest.approx(fitting[1], rel=tol.SAME_IN_OWN_UNITS)


def test_the_most_of_everything_is_what_the_run_itself_recorded(drive: DiffDrive) -> None:
    scenario = case("similarity.time=2")
    experiment = build(scenario)
    run, lost = ideal_motion(experiment)
    assert not lost
    recording = simulate(case("similarity.time=2", "backend=ideal", "physics.friction=0.5")).recording
    found = {(row.robot, row.quantity): row for row in demands(experiment, run, drive, Ground(0.5))}
    for name in ("leader", "follower"):
        recorded = recording.dataset.sel(robot=name).isel(time=slice(1, None))
        peak = float(np.abs(recorded["wheel_speed"]).max())
        assert found[name, "wheel_speed"].value == pytest.approx(peak, rel=tol.HAND)
        hardest = np.abs(recording["input"].sel(robot=name)[:-1, 0]).max()
        assert found[name, "forward_acceleration"].value == float(hardest)
        # A recording has the ends of periods only; demands look at their starts too.
        for quantity, variable in (
            ("friction_utilisation", "friction_utilisation_predicted"),
            ("wheel_torque", "wheel_torque"),
        ):
            row = found[name, quantity]
            assert row.value >= float(np.abs(recorded[variable]).max()) * (1 - tol.HAND)
            end = recorded.sel(wheel=row.wheel)
            at = end.isel(time=slice(0, 2)) if row.time == 0 else end.sel(time=[row.time], method="nearest")
            assert row.value == pytest.approx(float(np.abs(at[variable]).max()), rel=0.1)


def test_a_virtual_leader_asks_for_nothing(drive: DiffDrive) -> None:
    scenario = case("leader.virtual=true", "similarity.time=2")
    experiment = build(scenario)
    assert {row.robot for row in demands(experiment, ideal_motion(experiment)[0], drive, Ground())} == {"follower"}


# -- time: auto -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("overrides", "limit"),
    [
        (("physics.friction=0.2",), "friction"),
        (("physics.friction=2", "law.kp=40", "law.kd=20"), "wheel torque"),
        (("similarity.length=30", "control_rate=2"), "wheel speed"),
        (("physics.friction=0.4", "physics.slope={angle: 0.15, uphill: 0.5}"), "friction"),
        (("physics.friction=2", "physics.slope={angle: 0.3, uphill: 0.5}"), "wheel torque"),
        (("physics.patches=[{friction: 0.1, disc: [0, 0, 3]}]",), "friction"),
    ],
)
def test_auto_takes_what_there_is_and_no_more(drive: DiffDrive, overrides: tuple[str, ...], limit: str) -> None:
    scenario = with_time(case(*overrides))
    similarity, experiment = scenario.similarity, build(scenario)
    ground = experiment.scene.ground
    assert similarity.time == rounded_up(similarity.time_scale)
    run, _ = ideal_motion(experiment)
    motions = [motion_of(run, i) for i in range(2)]
    used = {name: max(shares(motion, drive, ground)[name] for motion in motions) for name in LIMITS}
    used["friction"] /= similarity.friction_margin
    assert max(used.values()) <= 1
    assert used[limit] >= 1 - tol.MARGIN_LEFT
    assert with_time(case(*overrides)) == scenario


def test_a_larger_margin_asks_for_less_time(drive: DiffDrive) -> None:
    times = [
        fitting_time(case("physics.friction=0.2", f"similarity.friction_margin={margin}")) for margin in (0.35, 0.7)
    ]
    assert times[0] / times[1] == pytest.approx(math.sqrt(2), rel=0.02)


def test_a_recording_carries_the_number() -> None:
    recording = simulate(case("backend=ideal")).recording
    time = recording.scenario.similarity.time_scale
    assert time == with_time(case()).similarity.time == recording.time_scale
    assert recording.time[-1] == pytest.approx(8 * time, abs=0.01)


def test_until_it_is_found_there_is_no_number() -> None:
    for use in (build, lambda scenario: scenario.periods):
        with pytest.raises(TypeError, match=r"auto becomes a number by nhtrack\.studies\.feasibility\.run\.with_time"):
            use(case())


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            ("physics.friction=0",),
            r"^leader's left wheel at 0 s asks for friction and there is none, however slow the motion$",
        ),
        (
            ("similarity.length=1e8",),
            r"\w+'s (left|right) wheel at .* s asks for it; that is .* control periods, and a run has at most 2e\+06",
        ),
    ],
)
def test_what_no_time_scale_helps_is_told(overrides: tuple[str, ...], message: str) -> None:
    with pytest.raises(FeasibilityError, match=message):
        with_time(case(*overrides))


def test_the_input_of_an_auto_scenario_is_judged_when_it_is_loaded() -> None:
    with pytest.raises(ScenarioError, match=r"leader\.input\.u_x: .* at t = "):
        case("leader.input.u_x=1/(t-t)")


# -- slopes and patches -----------------------------------------------------------------------------

STILL = ("leader.input.u_x=0", "leader.input.u_theta=0", "followers[0].start={pose: [0, 0, 0]}", "similarity.time=1")


def row_of(found: Feasibility, robot: str, quantity: str) -> dict[str, Any]:
    (row,) = (row for row in found.table if row["robot"] == robot and row["quantity"] == quantity)
    return row


def test_to_stand_on_a_slope_takes_torque_and_friction(drive: DiffDrive) -> None:
    """Nose to the top: each wheel holds half of m g sin(a), and the caster bears what leans on it."""
    found = feasibility(case(*STILL, "physics.slope.angle=0.2", "physics.friction=0.5"))
    along, normal = 9.81 * math.sin(0.2), 9.81 * math.cos(0.2)
    torque = drive.wheel_radius * drive.mass * along / 2
    assert row_of(found, "leader", "wheel_torque")["value"] == pytest.approx(torque, rel=tol.HAND)
    on_the_caster = (normal * drive.com[0] - along * drive.com[2]) / drive.casters[0][0]
    used = along / (0.5 * (normal - on_the_caster))
    assert row_of(found, "follower", "friction_utilisation")["value"] == pytest.approx(used, rel=tol.HAND)


def test_beyond_what_friction_or_motors_hold_no_time_scale_fits(drive: DiffDrive) -> None:
    slippery = feasibility(case(*STILL, "physics.slope.angle=0.2", "physics.friction=0.2"))
    assert not slippery.fits
    assert "wheel at 0 s asks for friction and there is none, however slow the motion" in slippery.verdict
    steepest = math.asin(2 * drive.motor.torque_limit / (drive.wheel_radius * drive.mass * 9.81))
    for share, fits in ((0.99, True), (1.01, False)):
        found = feasibility(case(*STILL, f"physics.slope.angle={share * steepest}", "physics.friction=3"))
        assert found.fits == fits
        assert ("asks for wheel torque and there is none" in found.verdict) != fits
    strong = feasibility(case(*STILL, f"physics.slope.angle={1.01 * steepest}", "physics.friction=3",
                              f"physics.motors.torque_limit={1.02 * drive.motor.torque_limit}"))  # fmt: skip
    assert strong.fits


def test_what_robots_carry_is_counted() -> None:
    bare, laden = (
        feasibility(case("similarity.time=2", *more)) for more in ((), ("physics.payload={mass: 0.35, height: 0.07}",))
    )
    torques = [row_of(found, "follower", "wheel_torque")["value"] for found in (bare, laden)]
    assert 1.3 < torques[1] / torques[0] < 1.6  # half as heavy again, and only in translation
    assert laden.fitting_time is not None
    assert bare.fitting_time is not None
    assert laden.fitting_time > bare.fitting_time


def test_a_patch_counts_where_and_when_robots_are_on_it() -> None:
    def found(*patches: str) -> Feasibility:
        return feasibility(case("similarity.time=2", f"physics.patches=[{', '.join(patches)}]"))

    nowhere, beside = found(), found("{friction: 0.01, rectangle: [-50, -20, -50, -20]}")
    assert beside.table == nowhere.table
    everywhere = found("{friction: 0.1, rectangle: [-50, 50, -50, 50]}")
    assert everywhere.table == feasibility(case("similarity.time=2", "physics.friction=0.1")).table
    # A disc of one scenario length about the leader's start, which it leaves after t = 2: 0.25 t^2 = 1.
    start = row_of(found("{friction: 0.1, disc: [0, 0, 1]}"), "leader", "friction_utilisation")
    assert 0 < start["time"] < 4.1
    bounds = [row_of(other, "leader", "friction_utilisation")["value"] for other in (nowhere, everywhere)]
    assert bounds[0] < start["value"] < bounds[1]


# -- what is said -----------------------------------------------------------------------------------


def predicted(*overrides: str) -> tuple[str, ...]:
    scenario = case(*overrides)
    experiment = build(scenario)
    drive = load_robot(scenario.robot.file).model
    return predictions(scenario, experiment, ideal_motion(experiment)[0], drive)


def test_predictions_name_robot_wheel_time_and_remedy() -> None:
    slippery = predicted("similarity.time=3", "physics.friction=0.05")
    assert len(slippery) == 1
    told = r"follower is predicted to slip: its left wheel needs 1\.\d+ times the friction there is at \d+ s; "
    assert re.match(told, slippery[0])
    remedy = float(slippery[0].split("similarity.time ")[1].split()[0])
    assert predicted(f"similarity.time={remedy}", "physics.friction=0.05") == ()
    weak = predicted("similarity.time=0.6", "physics.friction=9")
    assert any("follower is predicted to exceed its motors' limits: torque of its" in line for line in weak)
    assert any("is predicted to exceed its motors' limits: speed of its" in line for line in weak)
    assert any("is predicted to lift its" in line for line in predicted("similarity.time=0.3", "physics.friction=9"))


def test_on_ice_predictions_know_no_remedy() -> None:
    assert predicted("similarity.time=3", "physics.friction=0") == tuple(
        f"{name} is predicted to slip: its left wheel needs friction at 0 s and there is none; "
        "no similarity.time would fit"
        for name in ("leader", "follower")
    )


def test_a_run_on_wheels_is_warned_of_and_an_ideal_one_is_not() -> None:
    slippery = ("similarity.time=1.5", "physics.friction=0.05", "duration=1", "leader.virtual=true")
    warned = simulate(case(*slippery)).summary["warnings"]
    assert [line.split(":")[0] for line in warned] == ["leader", "follower is predicted to slip", "follower slid"]
    assert simulate(case(*slippery, "backend=ideal")).summary["warnings"] == warned[:1]  # of the law


def test_a_verdict_and_a_table_of_plain_values() -> None:
    found = feasibility(case("similarity.time=2"))
    assert found.fits
    assert found.verdict.startswith("Fits at similarity.time 2, with friction used to 0.7 at most; the smallest")
    assert f"that fits is {found.fitting_time:g}." in found.verdict
    rows: list[dict[str, Any]] = json.loads(json.dumps(found.table, allow_nan=False))
    assert [row["quantity"] for row in rows if row["robot"] == "follower"] == [
        "forward_acceleration", "yaw_acceleration", "friction_utilisation", "wheel_speed", "wheel_torque",
        "wheel_load", "time_scale",
    ]  # fmt: skip
    assert all({"robot", "quantity", "value", "unit", "limit", "share", "time"} <= set(row) for row in rows)
    smallest = max(row["limit"] for row in rows if row["quantity"] == "time_scale")
    assert found.fitting_time == pytest.approx(smallest, rel=0.02)
    assert not replace(found, bindings=tuple(replace(b, factor=0.9) for b in found.bindings)).fits


def test_what_does_not_fit_is_told_by_its_worst_limit() -> None:
    found = feasibility(case("similarity.time=0.5"))
    assert not found.fits
    assert found.verdict.startswith("Does not fit at similarity.time 0.5: ")
    ice = feasibility(case("similarity.time=2", "physics.friction=0"))
    assert ice.verdict.startswith("No time scale fits: leader's left wheel at 0 s asks for friction")
    assert [row["value"] for row in ice.table if row["quantity"] == "friction_utilisation"] == [None, None]


# -- the model without wheels -----------------------------------------------------------------------


def test_without_wheels_robots_move_the_same() -> None:
    experiment = build(case("similarity.time=2"))
    drive = load_robot("nh_mini").model
    twins = [IdealSimulation(("leader", "follower"), wheels, 0.01) for wheels in (None, drive)]
    states = [twin.reset(experiment.start) for twin in twins]
    for k in range(20):
        u = np.array([[0.1, math.sin(k)], [-0.2, 3.0]])
        states = [twin.step(u) for twin in twins]
    for one, other in zip(*states, strict=True):
        np.testing.assert_array_equal(one, other)
    assert twins[0].telemetry() == {}


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.1, 1.0])
def test_on_wheels_the_margin_holds(friction: float) -> None:
    outcome = simulate(case(f"physics.friction={friction}"))
    assert outcome.failure is None
    measured = outcome.recording["friction_utilisation"].max()
    assert measured <= 0.7 + tol.MARGIN_EXCEEDED
    assert outcome.recording["torque_saturation"].max() == 0
