"""Robots on MuJoCo wheels against the ideal robot under the same inputs: budgets, order, sameness."""

from __future__ import annotations

import numpy as np
import pytest

from motions import AT_REST, Run, difference, drive, make_simulation, middles, state, weaving
from nhtrack.simulation.ideal import IdealSimulation, propagate
from nhtrack.simulation.scene import SceneSpec
from nhtrack.simulation.state import State
from nhtrack.studies.fidelity.motion import open_loop_errors
from tolerances import OPEN_LOOP_HEADING, OPEN_LOOP_POSITION, SCENE_COUPLING, SECOND_ORDER

pytestmark = [pytest.mark.slow, pytest.mark.fidelity]


def test_second_order_from_any_twist() -> None:
    """A robot placed in motion is placed half a step earlier; otherwise the order would be one."""
    start = state(((0, 0, 0), (0.2, 0.5)), ((1, 2, 2.5), (-0.1, -0.5)), ((-1, 0.4, -8), (0, 2)))
    simulations = [make_simulation(SceneSpec(("a", "b", "c"), timestep=h)) for h in (0.002, 0.001)]
    coarse, fine = open_loop_errors(simulations, weaving, 3.0, start)
    assert 2.1 > np.log2(coarse.position / fine.position) >= SECOND_ORDER
    assert 2.1 > np.log2(coarse.heading / fine.heading) >= SECOND_ORDER


def test_commands_held_at_100_hz() -> None:
    """Ten physics steps a period: positions and the twists a law would see, both at the control instants.

    Accelerations jump: the input a held command turns any law into, at its roughest.
    """
    simulation, t = make_simulation(SceneSpec(("r",)), dt=0.01), middles(10.0, 0.01)
    inputs = np.stack([0.3 * np.sign(np.sin(2 * np.pi * t)), 1.5 * np.sign(np.sin(4.5 * t + 0.3))], axis=-1)[:, None]
    run, twin = (drive(s, inputs) for s in (simulation, IdealSimulation(("r",), simulation.drive, 0.01)))
    for error in (difference(run.g, twin.g), difference(run.xi, twin.xi)):
        assert error.position <= OPEN_LOOP_POSITION
        assert error.heading <= OPEN_LOOP_HEADING


def test_robots_in_one_scene_do_not_feel_each_other() -> None:
    """Five robots, of which the solver makes one sparse problem, against each of them alone."""
    places = [((0.4 * i, -0.3 * i, 1.3 * i), (0.05 * i, 0.2 * i)) for i in range(5)]
    inputs = weaving(middles(1.0, 0.01))[:, None]
    together = drive(make_simulation(SceneSpec(tuple("abcde")), dt=0.01), inputs.repeat(5, axis=1), state(*places))
    single = make_simulation(SceneSpec(("a",)), dt=0.01)
    for i, place in enumerate(places):
        alone = drive(single, inputs, state(place))
        np.testing.assert_allclose(together.g[:, i], alone.g[:, 0], rtol=0, atol=SCENE_COUPLING)


def test_a_virtual_root_follows_the_ideal_flow_bit_for_bit() -> None:
    simulation = make_simulation(SceneSpec(("root", "follower"), virtual_root=True), dt=0.01)
    start = state(((0.3, -0.2, 2.0), (0.1, 0.4)), ((0, 0, 0), (0, 0)))
    inputs = np.broadcast_to(weaving(middles(1.0, 0.01))[:, None], (100, 2, 2))
    run = drive(simulation, inputs, start)
    g, xi = start.g[:1], start.xi[:1]
    for k, u in enumerate(inputs):
        g, xi = propagate(g, xi, u[:1], 0.01)
        np.testing.assert_array_equal(run.g[k + 1, :1], g)
        np.testing.assert_array_equal(run.xi[k + 1, :1], xi)


def assert_same(a: Run, b: Run) -> None:
    np.testing.assert_array_equal(a.g, b.g)
    np.testing.assert_array_equal(a.xi, b.xi)
    assert a.telemetry.keys() == b.telemetry.keys()
    for name, values in a.telemetry.items():
        np.testing.assert_array_equal(values, b.telemetry[name])


SEEN = ("wheel_torque", "wheel_speed", "wheel_load", "lateral_slip", "friction_utilisation")


def test_a_batch_is_its_members_bit_for_bit() -> None:
    spec, periods = SceneSpec(("a", "b")), 100
    pair = [state(((0, 0, s), (0.1 * s, s)), ((1, s, -s), (0, -0.5 * s))) for s in (0.0, 0.7, -1.1)]
    start = State(0.0, np.stack([s.g for s in pair]), np.stack([s.xi for s in pair]))
    signal = weaving(middles(periods * 0.01, 0.01))
    inputs = np.stack([np.stack([signal * s, signal[::-1] * s], axis=1) for s in (1.0, -0.6, 0.3)], axis=1)
    batch = drive(make_simulation(spec, 0.01, batch=(3,)), inputs, start, SEEN)
    single = make_simulation(spec, 0.01)
    for i, alone in enumerate(pair):
        member = Run(batch.time, batch.g[:, i], batch.xi[:, i], {k: v[:, i] for k, v in batch.telemetry.items()})
        assert_same(member, drive(single, inputs[:, i], alone, SEEN))


def test_a_reset_begins_anew_bit_for_bit() -> None:
    simulation = make_simulation(SceneSpec(("r",)), dt=0.01)
    inputs = weaving(middles(1.0, 0.01))[:, None]
    first = drive(simulation, inputs, AT_REST, SEEN)
    drive(simulation, 3 * inputs, state(((1, 1, 1), (0.2, 1))))
    assert_same(drive(simulation, inputs, AT_REST, SEEN), first)
