"""What the actuators of a robot's file do to its wheels: torque sources within limits, whatever they are called."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from nhtrack.arrays import Array
from nhtrack.robots.contract import Refusal
from nhtrack.robots.motor import Motor
from nhtrack.robots.reading.source import Source

__all__ = ["Pull", "pulls_of", "read_motor"]

_GAIN, _BIAS, _DYN, _TRN = mujoco.mjtGain, mujoco.mjtBias, mujoco.mjtDyn, mujoco.mjtTrn
_STALL, _NO_LOAD = "motor_stall_torque", "motor_no_load_speed"


class Pull(NamedTuple):
    """What an actuator does to a joint: so much torque for its force, and so much of its speed for the joint's."""

    actuator: int
    joint: int
    ratio: float


class _Drive(NamedTuple):
    """An actuator's limits: largest force, force at standstill, speed at which it gives none; infinite for none."""

    limit: float
    stall: float
    no_load: float


def pulls_of(source: Source) -> list[Pull]:
    """Returns what the actuators of a file do to hinges and slides, directly or by tendons."""
    model, found = source.model, list[Pull]()
    for a in range(model.nu):
        target, gear = int(model.actuator_trnid[a, 0]), float(model.actuator_gear[a, 0])
        if _TRN(int(model.actuator_trntype[a])) in (_TRN.mjTRN_JOINT, _TRN.mjTRN_JOINTINPARENT):
            found.append(Pull(a, target, gear))
        elif model.actuator_trntype[a] == _TRN.mjTRN_TENDON:
            first, count = int(model.tendon_adr[target]), int(model.tendon_num[target])
            for w in range(first, first + count):
                if model.wrap_type[w] == mujoco.mjtWrap.mjWRAP_JOINT:
                    found.append(Pull(a, int(model.wrap_objid[w]), gear * float(model.wrap_prm[w])))
    return found


def read_motor(
    source: Source, wheels: Sequence[int], pulls: Sequence[Pull]
) -> tuple[Motor, list[Refusal], list[str], str]:
    """Returns the limits of each wheel motor, why they cannot be told, what is assumed, and what they were read from.

    An actuator gives the force g c + b_1 q + b_2 q' for its control c. A motor has b_1 = b_2 = 0: a torque source up to
    its limits. A velocity servo has b_2 < 0: within the range |c| <= c_max it gives any force up to
    g c_max (1 - q'/w_0), w_0 = g c_max/|b_2|: a torque source below a motor's line. A tendon's force is shared out by
    its coefficients; the limit is then what both wheels can be given whatever the other gets.
    """
    model, mine = source.model, [pull for pull in pulls if pull.joint in wheels]
    used = sorted({pull.actuator for pull in mine})
    if not used:
        limit = min((_least(model.jnt_actfrcrange[j]) for j in wheels if model.jnt_actfrclimited[j]), default=np.inf)
        known = "without limits" if np.isinf(limit) else f"of {limit:g} N m, what its joints bear, at any speed"
        note = f"no actuators: motors {known}; give theirs under `physics: motors:`"
        return Motor(limit, limit, np.inf), [], [note], "nothing"
    refusals = [Refusal(source.element("actuator", a), why) for a in used for why in _unknown(source, a)]
    if len(used) != 2:
        listed = ", ".join(source.element("actuator", a) for a in used)
        refusals.append(Refusal("", f"expected one actuator for each wheel, or two that share both, got {listed}"))
    shares = np.zeros((2, len(used)))
    for pull in mine:
        shares[list(wheels).index(pull.joint), used.index(pull.actuator)] += pull.ratio
    if not refusals and abs(np.linalg.det(shares)) < 1e-9 * max(np.abs(shares).max() ** 2, 1e-300):
        refusals.append(Refusal("", "the actuators cannot give the two wheels torques of their own: they are coupled"))
    if refusals:
        return Motor(1, 1, 1), refusals, [], ""
    drives = [_limits(source, a) for a in used]
    motor, notes = _at_wheels(source, wheels, shares, drives)
    return motor, [], notes, ", ".join(source.element("actuator", a) for a in used)


def _unknown(source: Source, a: int) -> Iterator[str]:
    """Yields what of an actuator is no torque within limits."""
    model = source.model
    name = _DYN(int(model.actuator_dyntype[a])).name.removeprefix("mjDYN_").lower()
    if model.actuator_dyntype[a] != _DYN.mjDYN_NONE:
        yield f"its dynamics ({name}) delay the torque, which the reduced model does not know: remove dyntype"
    if model.actuator_delay[a] > 0:
        yield f"it acts {model.actuator_delay[a]:g} s late, which the reduced model does not know: remove delay"
    if model.actuator_plugin[a] >= 0:
        yield "a plug-in decides its force: use a motor or a velocity servo"
    linear = _BIAS(int(model.actuator_biastype[a])) in (_BIAS.mjBIAS_NONE, _BIAS.mjBIAS_AFFINE)
    if model.actuator_gaintype[a] != _GAIN.mjGAIN_FIXED or not linear:
        yield "its force is no linear function of its control: use a motor or a velocity servo"
        return
    gain, bias = float(model.actuator_gainprm[a, 0]), model.actuator_biasprm[a, :3]
    if model.actuator_biastype[a] == _BIAS.mjBIAS_NONE:
        bias = np.zeros(3)
    if bias[1]:
        yield "a position servo turns its wheel to an angle: use a motor or a velocity servo"
    if bias[0]:
        yield f"it pulls by {bias[0]:g} N m without being asked: use a motor or a velocity servo"
    if bias[2] > 0:
        yield "its force grows with its speed: use a motor or a velocity servo"
    if gain == 0:
        yield "it gives no torque: its gain is 0"
    for name in ("ctrl", "force"):
        low, high = getattr(model, f"actuator_{name}range")[a]
        if getattr(model, f"actuator_{name}limited")[a] and not low < 0 < high:
            yield f"its {name}range {low:g} {high:g} does not reach to both sides of 0, so it drives one way only"


def _limits(source: Source, a: int) -> _Drive:
    """Returns the limits of an actuator's own force; the least of all that the file states."""
    model = source.model
    gain = abs(float(model.actuator_gainprm[a, 0]))
    slope = float(model.actuator_biasprm[a, 2]) if model.actuator_biastype[a] == _BIAS.mjBIAS_AFFINE else 0.0
    most = gain * _least(model.actuator_ctrlrange[a]) if model.actuator_ctrllimited[a] else np.inf
    limit = min(most, _least(model.actuator_forcerange[a]) if model.actuator_forcelimited[a] else np.inf)
    return _Drive(limit, most, most / -slope) if slope < 0 else _Drive(limit, limit, np.inf)


def _least(limits: Array) -> float:
    return float(np.abs(limits).min())


def _at_wheels(
    source: Source, wheels: Sequence[int], shares: Array, drives: Sequence[_Drive]
) -> tuple[Motor, list[str]]:
    """Returns the limits that both wheels have, and what is assumed.

    A wheel's torque is the sum of its shares of the forces, tau = S F. All |tau_i| <= T can be given where
    T sum_j |S^-1|_ij <= F_i for each actuator i; likewise for the forces at standstill. A wheel turns at w_i = q', and
    an actuator at S^T w.
    """
    model, notes = source.model, list[str]()
    per_torque = np.abs(np.linalg.inv(shares)).sum(axis=1)
    per_speed = np.abs(shares).sum(axis=0)
    torque = [drive.limit / per_torque[k] for k, drive in enumerate(drives)]
    stall = min(drive.stall / per_torque[k] for k, drive in enumerate(drives))
    speed = min(drive.no_load / per_speed[k] for k, drive in enumerate(drives))
    torque += [_least(model.jnt_actfrcrange[j]) for j in wheels if model.jnt_actfrclimited[j]]
    limit = min(torque)
    if not np.allclose(torque, limit, rtol=1e-6):
        given = ", ".join(f"{value:.6g}" for value in torque)
        notes.append(f"both wheels get the least of the torque limits that the file states ({given} N m)")
    numbers = {name: _numeric(model, name) for name in (_STALL, _NO_LOAD)}
    stall = numbers[_STALL] or stall
    speed = numbers[_NO_LOAD] or speed
    if not np.isfinite(limit):
        notes.append("no limit of torque is stated: motors give any; give theirs under `physics: motors:`")
    if not np.isfinite(speed):
        stall = limit
        notes.append("no speed without load is stated: motors keep their torque at any; see `physics: motors:`")
    return Motor(float(limit), float(max(stall, limit) if not np.isfinite(speed) else stall), float(speed)), notes


def _numeric(model: mujoco.MjModel, name: str) -> float | None:
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    return None if index < 0 else float(model.numeric_data[model.numeric_adr[index]])
