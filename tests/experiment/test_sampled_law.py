"""The closed loop on the ideal backend: the sampled law, its limit, its scaling, and opposite turns."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import independent
import tolerances as tol
from drives import DRIVE
from nhtrack.assets import find_scenario
from nhtrack.config.scenario import Scenario
from nhtrack.config.similarity_section import SimilaritySection
from nhtrack.experiment.build import Experiment, build
from nhtrack.experiment.load import load
from nhtrack.experiment.loop import Rollout, rollout
from nhtrack.laws import Law
from nhtrack.simulation.ideal import IdealSimulation

pytestmark = pytest.mark.property

PI = math.pi
PAPER = ["example1", "example2", "example3_pi", "example3_minus_pi"]


@cache
def scenario(name: str) -> Scenario:
    return load(find_scenario(f"paper/{name}"))


def roll(experiment: Experiment) -> Rollout:
    simulation = IdealSimulation(experiment.network.names, DRIVE, experiment.dt)
    done = rollout(simulation, experiment.law, experiment.network, experiment.inputs, experiment.start)
    assert done.failure is None
    return done


@cache
def run(name: str) -> Rollout:
    return roll(build(scenario(name)))


def path_length(positions: np.ndarray) -> np.ndarray:
    """Lengths of polygons (t, robots, 2), shape (robots,)."""
    return np.hypot(*np.moveaxis(np.diff(positions, axis=0), -1, 0)).sum(axis=0)


def paper_law(law: Law) -> independent.PaperLaw:
    assert law.kind.name == "published"
    kp, kd, ke, k, variant, _, *zones = law.gains
    return independent.PaperLaw(kp, kd, ke, k, variant == 1, False, *zones)


def robots_at_start(experiment: Experiment) -> np.ndarray:
    """Leader and follower, (2, 5): x, y, theta, v, omega."""
    return np.concatenate([experiment.start.g, experiment.start.xi[:, [0, 2]]], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["example1", "example3_pi"])
def test_ideal_backend_is_the_sampled_law_integrated_by_scipy(name: str) -> None:
    """Period by period: the paper's law in matrices, its command held, DOP853 at rtol 1e-12."""
    experiment = build(scenario(name))
    law, branch = paper_law(experiment.law), independent.Branch(0.25)
    robots = [robots_at_start(experiment)]
    for u_0 in experiment.inputs[:400]:
        leader, follower = robots[-1]
        u = np.array([u_0, law(follower, leader, u_0, branch)])
        robots.append(independent.integrate(robots[-1], u, experiment.dt))
    expected, done = np.array(robots), {key: values[:401] for key, values in run(name).variables.items()}
    path = path_length(expected[..., :2])
    error = np.abs(done["pose"] - expected[..., :3]).max(axis=0)
    assert (error[:, :2].max(axis=-1) <= tol.CLOSED_LOOP * path).all(), error
    assert (error[:, 2] <= tol.CLOSE_PASS).all(), error
    assert (np.abs(done["twist"][..., [0, 2]] - expected[..., 3:]).max(axis=0) <= tol.CLOSE_PASS).all()


# -- the continuous law -----------------------------------------------------------------------------


def continuous(
    experiment: Experiment, u_0: Callable[[float], tuple[float, float]], times: np.ndarray
) -> np.ndarray:
    """Leader and follower at some times, (t, 2, 5), under the law evaluated at every instant.

    Fails where beta switches, that is where q_x changes sign, within those times.
    """
    law, L, T = paper_law(experiment.law), experiment.similarity.length, experiment.similarity.time
    branch = independent.Branch(0.25)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        robots, (u_x, u_theta) = y.reshape(2, 5), u_0(t / T)
        root = np.array([u_x * L / T**2, u_theta / T**2])
        return independent.rate(robots, np.array([root, law(robots[1], robots[0], root, branch)])).ravel()

    def q_x(_: float, y: np.ndarray) -> float:
        relative = np.linalg.inv(independent.pose_matrix(y[:5])) @ independent.pose_matrix(y[5:])
        return float(independent.exponential_coordinates(y[7] - y[2], relative[:2, 2])[0])

    begin = robots_at_start(experiment).ravel()
    span = (0.0, times[-1])
    solution = solve_ivp(rate, span, begin, method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times, events=q_x)
    assert not [t for t in solution.t_events[0] if t > 0], "beta switches: choose a shorter time"
    return np.asarray(solution.y.T.reshape(-1, 2, 5))


@pytest.mark.slow
def test_sampled_law_tends_to_the_continuous_law_at_first_order() -> None:
    """Halving the period halves the distance to the law evaluated at every instant, until beta switches."""
    errors = []
    for rate, every in ((50.0, 1), (100.0, 2)):
        given = scenario("example1").model_copy(update={"control_rate": rate, "duration": 1.0})
        experiment = build(given)
        # Dead zones are steps in the law; which period sees one is a matter of chance.
        gains = experiment.law.gains._replace(dead_zone_length=0.0, dead_zone_speed=0.0)
        experiment = replace(experiment, law=replace(experiment.law, gains=gains))
        done = roll(experiment)
        if every == 1:
            expected = continuous(experiment, lambda t: (10.0, 0.15 * math.cos(0.4 * t)), done.time)[..., :3]
        errors.append(np.abs(done.variables["pose"][::every] - expected)[:, 1].max(axis=0))
    assert (errors[1] > 100 * tol.CLOSED_LOOP).all()
    np.testing.assert_allclose(errors[0] / errors[1], 2.0, atol=tol.ORDER)


# -- similarity -------------------------------------------------------------------------------------


def unscaled(given: Scenario) -> Scenario:
    """The same scenario without similarity: the same control instants, the dead zones in its own units."""
    L, T = given.similarity.length, given.similarity.time
    zone = given.law.dead_zone
    own = zone.model_copy(update={"length": zone.length / L, "speed": zone.speed * T / L})
    return given.model_copy(
        update={
            "similarity": SimilaritySection(),
            "control_rate": given.control_rate * T,
            "law": given.law.model_copy(update={"dead_zone": own}),
        }
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", PAPER)
def test_scaled_and_unscaled_runs_agree_to_rounding(name: str) -> None:
    similarity, scaled = build(scenario(name)).similarity, run(name)
    own = roll(build(unscaled(scenario(name))))
    path = path_length(own.variables["pose"][..., :2])
    np.testing.assert_allclose(similarity.times_to_scenario(scaled.time), own.time, rtol=tol.HAND)
    error = np.abs(similarity.poses_to_scenario(scaled.variables["pose"]) - own.variables["pose"]).max(axis=0)
    assert (error[:, :2].max(axis=-1) <= tol.CLOSED_LOOP * path).all()
    assert (error[:, 2] <= tol.CLOSE_PASS).all()
    speed = np.abs(own.variables["twist"]).max()
    twist = np.abs(similarity.twists_to_scenario(scaled.variables["twist"]) - own.variables["twist"])
    assert twist.max() <= tol.CLOSE_PASS * speed


# -- example 3 --------------------------------------------------------------------------------------


def test_pi_and_minus_pi_turn_opposite_ways() -> None:
    """One pose, two initial conditions: pi turns clockwise, -pi anticlockwise, mirror images to the last bit."""
    plus, minus = (run(f"example3_{sign}").variables["pose"][:, 1] for sign in ("pi", "minus_pi"))
    np.testing.assert_array_equal(plus[0, :2], minus[0, :2])
    assert plus[0, 2] - minus[0, 2] == 2 * PI
    np.testing.assert_array_equal(plus * [1, -1, -1], minus)
    for theta, way in ((plus[:, 2], -1), (minus[:, 2], 1)):
        assert way * (theta[1] - theta[0]) > 0
        assert way * (theta[-1] - theta[0]) == pytest.approx(
            PI, abs=1.0
        )  # half a turn, and the cycle that is left
        assert np.abs(theta).max() == PI  # never past the antipode
    assert np.abs(plus[:, 1]).max() > 0.1  # [m] they pass on different sides
