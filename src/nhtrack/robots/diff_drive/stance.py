"""How a robot comes to rest on its driven wheels and whatever else reaches the floor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from nhtrack.arrays import Array
from nhtrack.robots.contract import Refusal
from nhtrack.robots.diff_drive.joints import is_hinge
from nhtrack.robots.diff_drive.roles import Roles
from nhtrack.robots.diff_drive.tyres import Axle, read_tyre
from nhtrack.robots.reading.shapes import ROUND
from nhtrack.robots.reading.source import Source

__all__ = ["Stance", "Support", "read_stance"]

_LEAN = np.radians(5.0)  # the most that a robot may lean forward or back on its casters
_TOUCH = 1e-6  # [m] how near the floor a geom is that decides how far the robot leans
_SUPPORT = 2e-5  # [m] how near the floor what bears weight is
_GIVES = 0.02  # of the wheels' radius: so much lower than the tyres casters may be on both sides, since they give way


@dataclass(frozen=True)
class Support:
    """What bears weight beside the driven wheels.

    Attributes:
        geom: its id.
        link: the moving joint that it turns with, or -1 where it is fixed to the base.
        place: where it touches the floor, from the axle's middle, level frame [m], shape (3,).
    """

    geom: int
    link: int
    place: Array


@dataclass(frozen=True)
class Stance:
    """A robot at rest.

    Attributes:
        frame: rows ahead, left, up, in the world frame of the file, shape (3, 3).
        supports: what bears weight beside the wheels.
        notes: what is assumed.
    """

    frame: Array
    supports: tuple[Support, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Under:
    """A robot on its axle, and what of it may reach the floor beside the wheels."""

    source: Source
    roles: Roles
    axle: Axle
    geoms: tuple[int, ...]

    def frame(self, lean: float) -> Array:
        """Returns the frame of the robot when it leans forward about its axle."""
        cosine, sine = np.cos(lean), np.sin(lean)
        return np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]]) @ self.axle.frame

    def heights(self, lean: float) -> Array:
        """Returns the heights of the geoms' lowest points above the tyres' [m]."""
        down = -self.frame(lean)[2]
        return np.array([self.axle.radius - float(self.source.reach(g, down, self.axle.centre)) for g in self.geoms])

    def clearance(self, lean: float) -> float:
        """Returns the height of the lowest of all [m]."""
        return float(self.heights(lean).min()) if self.geoms else np.inf

    def pulled(self, lean: float) -> float:
        """Returns how far ahead of the axle the centre of mass lies [m]."""
        mass = self.source.data.subtree_com[self.roles.root] - self.axle.centre
        return float((self.frame(lean) @ mass)[0])

    def contact(self, geom: int, lean: float) -> tuple[Array, float]:
        """Returns the middle of where a geom would touch, from the axle's middle, and how far that spreads [m]."""
        frame = self.frame(lean)
        points = self.source.lowest_points(geom, frame, _SUPPORT) - frame @ self.axle.centre
        low, high = points.min(axis=0), points.max(axis=0)
        return np.array([*(low[:2] + high[:2]) / 2, low[2]]), float((high[:2] - low[:2]).max() / 2)

    def touching(self, lean: float) -> Iterator[int]:
        """Yields the geoms that bear weight."""
        for geom, height in zip(self.geoms, self.heights(lean), strict=True):
            if height <= _SUPPORT:
                yield geom


def read_stance(source: Source, roles: Roles, axle: Axle) -> tuple[Stance, list[Refusal]]:
    """Returns how a robot rests: on its wheels and, where its weight leans it about the axle, on what it meets first.

    With z_i(a) the height above the floor of the lowest point of geom i when the robot leans forward by a, it can
    stand where min_i z_i(a) >= 0, and rests at the end of that interval towards which its weight pulls it.
    """
    wheels = {axle.left.joint, axle.right.joint}
    others = [
        g
        for g in source.geoms_of(source.subtree(roles.root))
        if roles.link_of(source, int(source.model.geom_bodyid[g])) not in wheels
    ]
    under = _Under(source, roles, axle, tuple(g for g in others if source.collides(g)))
    lean, supports, refusals = _rest(under)
    notes = list[str]()
    drawn = _drawn_casters(source, axle, others) if refusals else []
    if drawn:
        under = _Under(source, roles, axle, (*under.geoms, *drawn))
        lean, supports, refusals = _rest(under)
        notes.append("spheres that reach the floor are its casters, although they touch nothing in the file")
    depth = -under.clearance(lean)
    if depth > _SUPPORT and not refusals:
        notes.append(f"casters that lie up to {1000 * depth:.2g} mm lower than the tyres are raised to their floor")
    if abs(lean) > np.radians(0.01):
        way = "forward" if lean > 0 else "back"
        notes.append(f"at rest it leans {way} by {np.degrees(abs(lean)):.2g} degrees from the file's pose")
    return Stance(under.frame(lean), supports, tuple(notes)), refusals


def _rest(under: _Under) -> tuple[float, tuple[Support, ...], list[Refusal]]:
    """Returns how far a robot leans at rest [rad], on what, and why it cannot."""
    lean, refusals = _lean(under)
    supports = tuple(_supports(under, lean))
    return lean, supports, refusals or list(_too_broad(under, lean, supports))


def _drawn_casters(source: Source, axle: Axle, geoms: list[int]) -> list[int]:
    """Returns spheres and ellipsoids that touch nothing in the file but reach down to the tyres' floor."""
    floor, kinds = axle.centre[2] - axle.radius, [int(kind) for kind in ROUND]
    return [
        g
        for g in geoms
        if not source.collides(g)
        and int(source.model.geom_type[g]) in kinds
        and abs(source.bottom(g) - floor) < _GIVES * axle.radius
    ]


def _lean(under: _Under) -> tuple[float, list[Refusal]]:
    """Returns how far a robot leans [rad], and why it cannot rest."""
    if abs(under.clearance(0.0)) <= _TOUCH and _holds(under):
        return 0.0, []
    free = 0.0
    if under.clearance(0.0) < -_TOUCH:
        best = minimize_scalar(
            lambda lean: -under.clearance(lean), bounds=(-_LEAN, _LEAN), method="bounded", options={"xatol": 1e-9}
        )
        free = float(best.x)
    depth = -under.clearance(free)
    if depth > _TOUCH:
        return free, [] if depth <= _GIVES * under.axle.radius else [_lifted(under, free)]
    pulled = under.pulled(free)
    start, end = (free + float(np.copysign(angle, pulled)) for angle in (1e-7, _LEAN))
    if abs(pulled) < 1e-9 or under.clearance(end) > 0:
        return free, [_tips(pulled)]
    if under.clearance(start) <= 0:
        return free, []
    return float(brentq(under.clearance, start, end, xtol=1e-14)), []


def _holds(under: _Under) -> bool:
    """Whether something that touches the floor lies on the side of the axle to which the weight pulls."""
    pulled = under.pulled(0.0)
    return any(under.contact(g, 0.0)[0][0] * pulled > 0 for g in under.touching(0.0))


def _lifted(under: _Under, lean: float) -> Refusal:
    heights = under.heights(lean)
    low = int(np.argmin(heights))
    return Refusal(
        under.source.element("geom", under.geoms[low]),
        f"it stands on the floor, {1000 * -heights[low]:.3g} mm below the driven wheels, and lifts them; raise it",
    )


def _tips(pulled: float) -> Refusal:
    where = f"its centre of mass lies {abs(pulled):.3g} m {'ahead of' if pulled > 0 else 'behind'} the axle"
    return Refusal(
        "",
        f"it tips by itself: {where}, and nothing there meets the floor within {np.degrees(_LEAN):g} degrees (no "
        "caster); add one, or let its geom touch (contype)",
    )


def _supports(under: _Under, lean: float) -> Iterator[Support]:
    """Yields what bears weight, each place once."""
    source, places = under.source, list[Array]()
    for geom in under.touching(lean):
        link = under.roles.link_of(source, int(source.model.geom_bodyid[geom]))
        place, _ = under.contact(geom, lean)
        tyre = read_tyre(source, link)[0] if link >= 0 and is_hinge(source, link, upright=False) else None
        if tyre is not None:  # of a swivel's wheel the middle of the tread, whichever of its points is lowest
            place = under.frame(lean) @ (tyre.centre - under.axle.centre)
        place[2] = -under.axle.radius
        if all(np.hypot(*(place - other)[:2]) > 0.02 * under.axle.radius for other in places):
            places.append(place)
            yield Support(geom, link, place)


def _too_broad(under: _Under, lean: float, supports: tuple[Support, ...]) -> Iterator[Refusal]:
    """Yields what rests on the floor as no caster does."""
    for support in supports:
        _, spread = under.contact(support.geom, lean)
        if spread > under.axle.radius:
            yield Refusal(
                under.source.element("geom", support.geom),
                f"the hull stands on the floor, {2 * spread:.3g} m wide; raise it, or take it out of contact and add "
                "casters",
            )
