"""Virtual leaders (paper eqs. 30 to 32 and 35, Theorem 3), as arrays: kept as second implementation."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from typing import Literal, NamedTuple, TypeAlias

from nhtrack import se2
from nhtrack.arrays import Array, namespace
from reference.laws.law import Leader
from reference.laws.relative import arctan_ratio

Combination: TypeAlias = Literal["convex", "exact"]
Transform: TypeAlias = Literal["printed", "exact"]

HYSTERESIS = 0.25  # [rad] how far past the antipode the branch of log between two parents is kept


def fold(a: Leader, b: Leader, weight: Array, combination: Combination, turns: Array | None) -> tuple[Leader, Array]:
    """Returns the virtual leader between two leaders, and the winding number of the heading between them."""
    xp = namespace(a.g, b.g)
    g_ab = se2.between(a.g, b.g)
    turns = se2.winding_number(g_ab[..., 2], turns, HYSTERESIS)
    g_ab = xp.stack([g_ab[..., 0], g_ab[..., 1], g_ab[..., 2] - 2 * pi * turns], axis=-1)
    X, share = se2.log(g_ab), weight[..., None]
    h = se2.exp(share * X)
    if combination == "convex":
        return Leader(se2.compose(a.g, h), (1 - share) * a.xi + share * b.xi, (1 - share) * a.u + share * b.u), turns
    carried = se2.Ad_inverse(g_ab, a.xi)
    xi_ab = b.xi - carried
    u_ab = b.u - se2.Ad_inverse(g_ab, a.u) + se2.ad(xi_ab, carried)
    inverse = se2.right_jacobian_inverse(X)
    rate = _apply(inverse, xi_ab)
    bend = _apply(se2.right_jacobian_derivative(X, rate), rate)
    second = _apply(inverse, u_ab - bend)
    jacobian = se2.right_jacobian(share * X)
    zeta = share * _apply(jacobian, rate)
    bend_c = _apply(se2.right_jacobian_derivative(share * X, share * rate), rate)
    zeta_rate = share * (_apply(jacobian, second) + bend_c)
    xi_a = se2.Ad_inverse(h, a.xi)
    u_c = se2.Ad_inverse(h, a.u) - se2.ad(zeta, xi_a) + zeta_rate
    return Leader(se2.compose(a.g, h), xi_a + zeta, u_c), turns


def displace(
    leader: Leader, offset: Array, transform: Transform, dead_zone_speed: float, rate_limit: float = inf
) -> tuple[Leader, Array]:
    """Returns the leader moved to a place in its own frame, `g_a = g_c gbar` (Theorem 3), and the rate of thetabar."""
    xp = namespace(leader.g, offset)
    x, y = offset[..., 0], offset[..., 1]
    zero = xp.zeros_like(x)
    lever = xp.stack([x, y, zero], axis=-1)
    point, force = se2.Ad_inverse(lever, leader.xi), se2.Ad_inverse(lever, leader.u)
    attitude = arctan_ratio(point[..., 1], point[..., 0], dead_zone_speed)
    square = point[..., 0] ** 2 + point[..., 1] ** 2
    moving = square > dead_zone_speed**2
    cross = point[..., 0] * force[..., 1] - point[..., 1] * force[..., 0]
    rate = xp.where(moving, cross / xp.where(moving, square, xp.ones_like(square)), xp.zeros_like(square))
    rate = xp.clip(rate, -rate_limit, rate_limit)
    gbar = xp.stack(xp.broadcast_arrays(x, y, attitude), axis=-1)
    turn = xp.stack(xp.broadcast_arrays(zero, zero, attitude), axis=-1)
    along = xp.asarray([1.0, 0.0, 1.0])  # no lateral part: of xi by the choice of thetabar, and so of its rate
    xi, u = along * se2.Ad_inverse(turn, point), along * se2.Ad_inverse(turn, force)
    if transform == "exact":
        xi = xi + xp.stack(xp.broadcast_arrays(zero, zero, rate), axis=-1)
    return Leader(se2.compose(leader.g, gbar), xi, u), rate


class VirtualMemory(NamedTuple):
    """Memory of a `VirtualLeader`."""

    turns: tuple[Array, ...]
    rate: Array | None


@dataclass(frozen=True)
class VirtualLeader:
    """What m followers of one level track, made from their parents: folds first, then the displacement."""

    weights: Array
    offsets: Array
    dt: float
    combination: Combination = "convex"
    transform: Transform = "printed"
    dead_zone_speed: float = 0.0
    rate_limit: float = inf

    def init(self, parents: Leader) -> VirtualMemory:
        """Returns the memory to begin with; `parents` as in a call."""
        return VirtualMemory(self._fold(parents, None)[1], None)

    def __call__(self, parents: Leader, memory: VirtualMemory) -> tuple[Leader, VirtualMemory]:
        """Returns what each follower tracks, shapes (..., m, 3), and the memory for the next period."""
        xp = namespace(parents.g)
        leader, turns = self._fold(parents, memory.turns)
        placed = xp.any(self.offsets != 0, axis=-1)
        if not xp.any(placed):
            return leader, VirtualMemory(turns, None)
        moved, rate = displace(leader, self.offsets, self.transform, self.dead_zone_speed, self.rate_limit)
        if self.transform == "exact":
            before = rate if memory.rate is None else memory.rate
            second = xp.clip((rate - before) / self.dt, -(self.rate_limit**2), self.rate_limit**2)
            moved = moved._replace(u=moved.u + xp.stack([0 * rate, 0 * rate, second], axis=-1))
        chosen = (xp.where(placed[..., None], there, here) for there, here in zip(moved, leader, strict=True))
        return Leader(*chosen), VirtualMemory(turns, rate)

    def _fold(self, parents: Leader, turns: tuple[Array, ...] | None) -> tuple[Leader, tuple[Array, ...]]:
        """Returns the folded leaders, shapes (..., m, 3), and the winding numbers of the folds."""
        folded, found = Leader(*(values[..., 0, :] for values in parents)), []
        for i in range(self.weights.shape[-1]):
            next_parent = Leader(*(values[..., i + 1, :] for values in parents))
            before = None if turns is None else turns[i]
            folded, turn = fold(folded, next_parent, self.weights[..., i], self.combination, before)
            found.append(turn)
        return folded, tuple(found)


def _apply(matrices: Array, vectors: Array) -> Array:
    """Returns the product of matrices (..., 3, 3) and vectors (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]
