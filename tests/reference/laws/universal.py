"""The universal law (docs/theory.md), as arrays: kept as second implementation."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi
from typing import Any, NamedTuple

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader, Robots
from reference.laws.limits import Limits

SIDE_SWITCH = 0.6 * pi  # [rad] polar angle beyond which the other side's field is taken; it starts at 0.4 pi
GEAR_SWITCH_MOVING = 0.6 * pi  # [rad] heading off the leader's beyond which the gear is changed; then 0.4 pi are left
GEAR_SWITCH_RESTING = 0.9 * pi  # [rad] the same where the field outweighs the leader's own velocity
UNDOCK = 2.0  # docking ends at so many times the radius or the speed at which it begins
BRAKING = 0.5  # share of the yaw acceleration limit that braking towards a heading counts on


class UniversalMemory(NamedTuple):
    """Memory of `Universal`; arrays of shape (...)."""

    side: Array
    gear: Array
    docked: Array
    turns: Array


class _Vector(NamedTuple):
    """A planar vector in the leader's frame, components of any shape."""

    x: Array
    y: Array


class _View(NamedTuple):
    """The follower seen from its leader, in the leader's frame."""

    place: _Vector
    distance: Array
    heading: Array
    along: _Vector
    motion: _Vector
    velocity: _Vector
    acceleration: _Vector


class _Field(NamedTuple):
    """The field and what saturates it, at a place."""

    value: _Vector
    rate: _Vector
    share: Array
    share_rate: Array


@dataclass(frozen=True)
class Universal:
    """Hybrid law: head along the leader's velocity plus a field that leads in tangentially, and drive at their sum.

        F     = -b c rho cos(phi/2) (cos m phi, sin m phi),   sigma = 1/sqrt(1 + (c rho / field_speed)^2)
        w     = (v_0, v_y0) + sigma (omega_0 J r + F),        a = angle(s w)
        u_theta = -k1 (theta_01 - a) - k2 (omega_01 - a') + u_theta0
        u_x     = -k3 (v_1 - v_d) + v_d',                     v_d = <w, (cos theta_01, sin theta_01)>
    """

    k1: float
    k2: float
    k3: float
    c: float
    m: float
    field_speed: float
    turn_rate: float
    dock_radius: float
    dock_speed: float
    limits: Limits | None = None

    def init(self, follower: Robots, leader: Leader) -> UniversalMemory:
        """Returns the memory to begin with: the side the follower is on, and the gear that side asks for at rest."""
        xp = namespace(follower.g, leader.g)
        view = _seen(xp, follower, leader)
        one = xp.ones_like(view.distance)
        side = xp.where(view.place.x < 0, -one, one)
        begin = UniversalMemory(side, -side, one < 0, 0 * one)
        memory, _, heading, _ = self._aim(xp, view, leader, begin)
        return memory._replace(turns=se2.winding_number(view.heading - heading))

    def __call__(
        self, follower: Robots, leader: Leader, memory: UniversalMemory
    ) -> tuple[Array, UniversalMemory]:
        """Returns the accelerations (u_x, u_theta), shape (..., 2), and the memory for the next period."""
        xp = namespace(follower.g, leader.g)
        view = _seen(xp, follower, leader)
        v, omega = follower.xi[..., 0], follower.xi[..., 2]
        omega_01 = omega - leader.xi[..., 2]
        memory, (w, w_rate), heading, turn = self._aim(xp, view, leader, memory)
        turns = se2.winding_number(view.heading - heading, memory.turns)
        error = view.heading - heading - 2 * pi * turns
        u_theta = leader.u[..., 2] - self.k2 * (omega_01 - turn + self._return_rate(xp, error))
        speed = _dot(w, view.along)
        speed_rate = _dot(w_rate, view.along) + omega_01 * _cross(view.along, w)
        u_x = speed_rate - self.k3 * (v - speed)
        if self.limits is not None:
            u_x = _within(xp, u_x, v, self.k3, self.limits.speed, self.limits.acceleration)
            u_theta = _within(xp, u_theta, omega, self.k2, self.limits.yaw_rate, self.limits.yaw_acceleration)
        return xp.stack(xp.broadcast_arrays(u_x, u_theta), axis=-1), memory._replace(turns=turns)

    def _aim(
        self, xp: Any, view: _View, leader: Leader, memory: UniversalMemory
    ) -> tuple[UniversalMemory, tuple[_Vector, _Vector], Array, Array]:
        """Returns the modes, w and w', and the heading a with its rate a', under those modes."""
        memory = self._side_and_dock(xp, view, memory)
        field = self._field(xp, view, memory.side)
        w, w_rate = self._sum(view, leader, field)
        memory = memory._replace(gear=_gear(xp, view, field, w, memory))
        docked = memory.docked
        heading = xp.atan2(memory.gear * w.y, memory.gear * w.x)
        square = _dot(w, w)
        turn = _cross(w, w_rate) / xp.where(square > 0, square, xp.ones_like(square))
        turn = xp.clip(turn, -self.turn_rate, self.turn_rate)
        zero = xp.zeros_like(heading)
        heading, turn = xp.where(docked, zero, heading), xp.where(docked, zero, turn)
        w = _where(xp, docked, _add(view.velocity, _scale(-self.c, view.place)), w)
        w_rate = _where(xp, docked, _add(view.acceleration, _scale(-self.c, view.motion)), w_rate)
        return memory, (w, w_rate), heading, turn

    def _side_and_dock(self, xp: Any, view: _View, memory: UniversalMemory) -> UniversalMemory:
        """Returns the memory with side and docking of this period; within the docking radius the side is noise."""
        widened = xp.where(memory.docked, UNDOCK * xp.ones_like(view.distance), xp.ones_like(view.distance))
        leader_speed = xp.hypot(view.velocity.x, view.velocity.y)
        docked = (view.distance < widened * self.dock_radius) & (leader_speed < widened * self.dock_speed)
        beyond = memory.side * view.place.x < cos(SIDE_SWITCH) * view.distance
        switch = beyond & (view.distance > self.dock_radius) & xp.logical_not(memory.docked)
        return memory._replace(side=xp.where(switch, -memory.side, memory.side), docked=docked)

    def _field(self, xp: Any, view: _View, side: Array) -> _Field:
        """Returns the field of a side at the follower's place."""
        distance, motion = view.distance, view.motion
        phi = xp.atan2(side * view.place.y, side * view.place.x)
        safe = xp.where(distance > 0, distance, xp.ones_like(distance))
        radial = _scale(1 / safe, view.place)  # 0 on the leader, where the field has a corner: its rate counts as 0
        distance_rate, across = _dot(radial, motion), _cross(radial, motion)  # rho', rho phi'
        half_cos, half_sin = xp.cos(phi / 2), xp.sin(phi / 2)
        turned = _Vector(-self.c * side * xp.cos(self.m * phi), -self.c * side * xp.sin(self.m * phi))
        lengthening = distance_rate * half_cos - across * half_sin / 2
        turning = self.m * across * half_cos
        share = 1 / xp.sqrt(1 + (self.c * distance / self.field_speed) ** 2)
        share_rate = -(share**3) * (self.c / self.field_speed) ** 2 * distance * distance_rate
        rate = _Vector(lengthening * turned.x - turning * turned.y, lengthening * turned.y + turning * turned.x)
        return _Field(_scale(distance * half_cos, turned), rate, share, share_rate)

    def _sum(self, view: _View, leader: Leader, field: _Field) -> tuple[_Vector, _Vector]:
        """Returns w = (v_0, v_y0) + sigma (omega_0 J r + F) and w'."""
        omega, u_theta = leader.xi[..., 2], leader.u[..., 2]
        round_leader = _Vector(field.value.x - omega * view.place.y, field.value.y + omega * view.place.x)
        rate = _Vector(
            field.rate.x - u_theta * view.place.y - omega * view.motion.y,
            field.rate.y + u_theta * view.place.x + omega * view.motion.x,
        )
        shared = _add(_scale(field.share, rate), _scale(field.share_rate, round_leader))
        return _add(view.velocity, _scale(field.share, round_leader)), _add(view.acceleration, shared)

    def _return_rate(self, xp: Any, error: Array) -> Array:
        """Returns the rate at which a heading error is taken back [rad/s], one that the limits can brake from."""
        gain = self.k1 / self.k2
        if self.limits is None:
            return gain * error
        brake = BRAKING * self.limits.yaw_acceleration
        size, linear = xp.abs(error), brake / gain**2
        curved = xp.sqrt(2 * brake * xp.maximum(size - linear / 2, xp.zeros_like(size)))
        return xp.sign(error) * xp.where(size <= linear, gain * size, curved)


def _gear(xp: Any, view: _View, field: _Field, w: _Vector, memory: UniversalMemory) -> Array:
    """Returns the gear of this period: the other one where the heading it asks for is too far off the leader's."""
    leads = _dot(view.velocity, view.velocity) > field.share**2 * _dot(field.value, field.value)
    one = xp.ones_like(view.distance)
    least = xp.where(leads, cos(GEAR_SWITCH_MOVING) * one, cos(GEAR_SWITCH_RESTING) * one)
    switch = (memory.gear * w.x < least * xp.hypot(w.x, w.y)) & xp.logical_not(memory.docked)
    return xp.where(switch, -memory.gear, memory.gear)


def _seen(xp: Any, follower: Robots, leader: Leader) -> _View:
    """Returns the follower seen from its leader."""
    g = se2.between(leader.g, follower.g)
    place, v, omega_0 = _Vector(g[..., 0], g[..., 1]), follower.xi[..., 0], leader.xi[..., 2]
    along = _Vector(xp.cos(g[..., 2]), xp.sin(g[..., 2]))
    velocity = _Vector(leader.xi[..., 0], leader.xi[..., 1])
    carried = _Vector(velocity.x - omega_0 * place.y, velocity.y + omega_0 * place.x)
    return _View(
        place=place,
        distance=xp.hypot(place.x, place.y),
        heading=g[..., 2],
        along=along,
        motion=_Vector(v * along.x - carried.x, v * along.y - carried.y),
        velocity=velocity,
        acceleration=_Vector(leader.u[..., 0], leader.u[..., 1]),
    )


def _within(xp: Any, u: Array, rate: Array, gain: float, largest: float, acceleration: float) -> Array:
    """Returns an acceleration that keeps |rate| <= largest and is itself at most `acceleration`."""
    u = xp.minimum(xp.maximum(u, -gain * (rate + largest)), gain * (largest - rate))
    return xp.clip(u, -acceleration, acceleration)


def _dot(a: _Vector, b: _Vector) -> Array:
    return a.x * b.x + a.y * b.y


def _cross(a: _Vector, b: _Vector) -> Array:
    return a.x * b.y - a.y * b.x


def _add(a: _Vector, b: _Vector) -> _Vector:
    return _Vector(a.x + b.x, a.y + b.y)


def _scale(factor: Array | float, a: _Vector) -> _Vector:
    return _Vector(factor * a.x, factor * a.y)


def _where(xp: Any, condition: Array, a: _Vector, b: _Vector) -> _Vector:
    return _Vector(xp.where(condition, a.x, b.x), xp.where(condition, a.y, b.y))
