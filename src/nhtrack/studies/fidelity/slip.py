"""The ways in which a wheel slides in MuJoCo though friction would hold it, and what it does where nothing holds it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from nhtrack import se2
from nhtrack.effects.slope import Slope
from nhtrack.ground import GRAVITY
from nhtrack.simulation.contact import FrictionRow
from nhtrack.studies.fidelity.bench import Bench, Finding
from nhtrack.studies.fidelity.motion import AT_REST, drive_open_loop, middles, state_of, weave_within

_SOLREFS = ((0.004, 1.0), (0.01, 1.0), (0.02, 1.0))
_IMPRATIOS = (1.0, 10.0, 100.0)
_LEAST_FRICTION = 1e-5  # MuJoCo's


def turning_slip(bench: Bench) -> Iterator[Finding]:
    """Yields how far the sideways slip of a turning robot is from v omega / b, without rate correction.

    b = 2/(d timeconst) of the contact's solref. Poses move by velocities half a step old, so half a step of v omega is
    part of the motion and not slip.
    """
    top = bench.drive.top_speed
    v, omega = 0.25 * top, 0.25 * top / bench.drive.half_separation
    worst = 0.0
    for solref in _SOLREFS:
        scene = bench.scene(rate_correction=False)
        tyres = scene.addresses.tyres.ravel()
        scene.model.geom_solref[tyres] = solref
        simulation = bench.simulation(dt=0.01, scene=scene)
        run = drive_open_loop(simulation, np.zeros((30, 1, 2)), state_of(((0, 0, 0), (v, omega))), ("lateral_slip",))
        rate = run.xi[-1, 0, 0] * run.xi[-1, 0, 2]
        expected = -rate * (1 / FrictionRow.of(scene.model, int(tyres[0])).damping - scene.spec.timestep / 2)
        worst = max(worst, abs(run.telemetry["lateral_slip"][-1, 0] / expected - 1))
    cause = "MuJoCo's contact rows leave out Jdot qvel; the law is its equation of the steady state"
    yield bench.find("turning slip against v omega / b, three solrefs", worst, "1", 0.02, cause)


def creep(bench: Bench) -> Iterator[Finding]:
    """Yields the creep of a robot that stands across a slope of a quarter of its friction angle.

    A friction row of damping b and regularisation R creeps at R f / b under a force f; R is inverse to impratio.
    Casters that swivel turn downhill and their robot with them, which is not asked.
    """
    if bench.swivels:
        return
    drive, slope = bench.drive, 0.25 * math.atan(0.5)
    across: dict[str, Any] = {"friction": 0.5, "effects": (Slope(slope, math.pi / 2),), "compensation": "actual"}
    worst = 0.0
    for impratio in _IMPRATIOS:
        scene = bench.scene(**across, rate_correction=False)
        scene.model.opt.impratio = impratio
        row = FrictionRow.of(scene.model, int(scene.addresses.tyres[0, 0]))
        side_force = drive.mass * GRAVITY * math.sin(slope) / 2
        run = drive_open_loop(bench.simulation(dt=0.01, scene=scene), np.zeros((100, 1, 2)))
        speed = (run.g[-1, 0, 1] - run.g[50, 0, 1]) / (run.time[-1] - run.time[50])
        worst = max(worst, abs(-speed * row.damping / (row.regularisation * side_force) - 1))
    cause = "regularised friction; the inverse inertia that MuJoCo takes for R is that of the reference configuration"
    yield bench.find("creep across a slope against R f / b, impratio 1 to 100", worst, "1", 0.05, cause)
    simulation = bench.simulation(dt=0.01, **across)
    run = drive_open_loop(simulation, np.zeros((100, 1, 2)))
    left = np.abs(run.g[-1, 0, :2] - run.g[50, 0, :2]).max() / (run.time[-1] - run.time[50])
    cause = "the rate correction anticipates creep from the side force of the reduced model"
    yield bench.find("creep across a slope, corrected", left, "m/s", 1e-8, cause)


def ice(bench: Bench) -> Iterator[Finding]:
    """Yields what is left without friction: the rate correction moves nothing, wheels spin, the robot stays.

    MuJoCo's least friction coefficient is 1e-5; it moves a robot by less than g 1e-5 t^2 / 2.
    """
    weave, duration = weave_within(bench.drive, 0.5), 3.0
    inputs = 2 * weave(middles(duration, 0.01))[:, None]
    with_it, without = (
        drive_open_loop(bench.simulation(dt=0.01, friction=0.0, rate_correction=on), inputs, AT_REST, ("wheel_speed",))
        for on in (True, False)
    )
    least = _LEAST_FRICTION * GRAVITY * duration**2 / 2
    moved = np.abs(with_it.g[..., :2] - without.g[..., :2]).max()
    cause = "MuJoCo's least friction of 1e-5, along directions that the correction turns a little"
    yield bench.find("no friction: what the rate correction moves", moved, "m", 0.02 * least, cause)
    com = se2.act(with_it.g[:, 0], np.array(bench.drive.com[:2]))
    cause = "MuJoCo's least friction of 1e-5"
    yield bench.find("no friction: drift of the centre of mass", np.abs(com - com[0]).max(), "m", least, cause)
    speed = np.abs(with_it.telemetry["wheel_speed"]).max() * bench.drive.wheel_radius / bench.drive.top_speed
    cause = "nothing but their own inertia and losses hold the wheels"
    yield bench.find("no friction: wheel speed over no-load speed", speed, "1", 0.9, cause, sense="at least")
