"""What is drawn flat on the floor: trails, skid marks, discs and chevrons of robots, slots and rings of ideal twins."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from nhtrack import se2
from nhtrack.colours import TOUCH, rgb
from nhtrack.simulation.scene import Scene
from nhtrack.video.bodies import fading
from nhtrack.video.render_options import FLEET
from nhtrack.video.timeline import LONGEST, Timeline

__all__ = ["FAR_DISC", "FloorLines", "root_radius"]

# Heights of discs above the floor [m at nh_mini's size], lowest first
_RING, _ROOT_DISC, _DISC_ABOVE = 0.0005, 0.0006, 0.0008
# Heights of lines [m per metre from the camera, which is at least that far away]: a line is as deep as its middle, and
# lower ones lose the half of their width that lies before the floor
_SKID, _LINE = 0.0015, 0.002
_STACK = 0.0002  # between robots, so that what lies on each other does not flicker
_LAYERS = 6  # of trails: more would float above the floor
_WIDTH = 2.5  # of lines [pixels at 480 lines]
FAR_DISC = 0.021  # radius of discs, at least, over how far the camera is away
HULL = 0.06  # [m] radius of a robot's own disc
_ROOT = 1.42  # the root's disc over it: to be seen beside a follower that is where it ought to be
_CHEVRON = np.array([[1.05, 0.6], [1.7, 0.0], [1.05, -0.6]])  # ahead of a disc of unit radius, nose along +x
SLOT = np.array([[-1.0, -1.0], [-1.0, 1.0], [0.7, 1.0], [1.5, 0.0], [0.7, -1.0], [-1.0, -1.0]])  # nose along +x
SLOT_SIZE = 0.075  # [m] half its width
_RING_SIDES = 36
_CIRCLE = np.stack([f(np.linspace(0.0, 2 * np.pi, _RING_SIDES + 1)) for f in (np.cos, np.sin)], axis=-1)
_CROSS = np.array([[-1.0, -1.0], [1.0, 1.0]])
_RING_SIZE = 1.28  # radius of an ideal twin's ring over that of its robot's disc
# Lines catch all light at once, that of a light with shadows too: this gives them their colour back, without and with.
_LINE_SHADES = (1.0, 0.5)
# The floor's colour, which pale signs and old trails come near to. They are opaque: translucent signs would be drawn
# over ghosts and robots that fade, whatever their height.
_PAVED = np.array([0.68, 0.70, 0.73])
_FADE, _FAINTEST = LONGEST / 5, 0.4  # [s of film] in which trails fade, and the share of colour that stays
RUBBER = np.array([0.10, 0.10, 0.11, 1.0], np.float32)
_WHITE = np.ones(3)


class FloorLines:
    """Adds a film's floor marks to a visual scene, frame by frame.

    Args:
        scene: the compiled scene.
        timeline: the film.
        scale: size of the robots over that of nh_mini.
        lines: height of the picture [pixels].
        shadows: whether the picture has any.
    """

    def __init__(self, scene: Scene, timeline: Timeline, scale: float, lines: int, shadows: bool) -> None:
        self._scene, self._timeline, self._scale = scene, timeline, scale
        self._width = _WIDTH * lines / 480
        self._shade = np.array([*3 * [_LINE_SHADES[shadows]], 1.0], np.float32)
        count = len(scene.spec.robots)
        self._largest = disc_radius(timeline.pose[..., :2]) if count > FLEET else np.inf
        self._colours = np.array([rgb(scene.spec.colour(place)) for place in range(count)])

    @property
    def room(self) -> int:
        """How many geoms the marks may need."""
        robots = len(self._timeline.trails)
        marks = len(self._timeline.skids) + _RING_SIDES * 2 * len(self._timeline.touches)
        return sum(each.time.size for each in self._timeline.trails) + marks + 12 * robots

    def add(self, visual: mujoco.MjvScene, frame: int, distance: float) -> None:
        """Adds the marks of a frame, seen from so far away [m]."""
        self._visual, self._lift = visual, max(self._scale, distance)
        self._add_skids(frame)
        self._add_trails(frame)
        self._add_slots(frame)
        self._add_touches(frame, distance)
        self._add_pointers(frame, min(FAR_DISC * distance, self._largest))

    def _add_skids(self, frame: int) -> None:
        now = self._timeline.time[frame]
        for skid in itertools.takewhile(lambda skid: skid.time <= now, self._timeline.skids):
            self._add_line(self._at_height(skid.points, _SKID), RUBBER, 1.7 * self._width)

    def _add_trails(self, frame: int) -> None:
        """Adds where each robot has been, followers above their leader; what is older is fainter."""
        now, film_second = self._timeline.time[frame], self._timeline.speed
        for place, trail in enumerate(self._timeline.trails):
            so_far = int(np.searchsorted(trail.time, now, side="right"))
            way = np.vstack([trail.points[:so_far], self._timeline.pose[frame, place, :2]])
            age = (now - trail.time[:so_far]) / film_second
            fresh = _FAINTEST + (1 - _FAINTEST) * np.exp(-age / _FADE)
            points = self._at_height(way, _LINE + _STACK * (place % _LAYERS))
            self._add_line(points, self._pale(place, fresh[:, None]), (1.6 if place == 0 else 1.0) * self._width)

    def _add_slots(self, frame: int) -> None:
        """Adds the outline of the place that each robot of a formation ought to take."""
        if self._timeline.slot is None:
            return
        for place in map(int, np.flatnonzero(np.isfinite(self._timeline.slot[frame, :, 0]))):
            corners = se2.act(self._timeline.slot[frame, place][None], self._scale * SLOT_SIZE * SLOT)
            self._add_line(self._at_height(np.asarray(corners), _LINE), self._pale(place, 1.0), 0.8 * self._width)

    def _add_touches(self, frame: int, distance: float) -> None:
        """Adds a cross wherever robots began to touch so far, and a ring around them while they do."""
        now, rgba = self._timeline.time[frame], _solid(np.array(rgb(TOUCH)))
        for touch in self._timeline.touches:
            if touch.start > now:
                continue
            size = max(0.5 * self._scale * HULL, 0.012 * distance)
            for cross in (_CROSS, _CROSS * [1.0, -1.0]):
                self._add_line(self._at_height(touch.point + size * cross, _LINE), rgba, 1.3 * self._width)
            if now <= touch.end:
                one, other = self._timeline.pose[frame, list(touch.places), :2]
                radius = np.hypot(*(other - one)) / 2 + max(1.5 * self._scale * HULL, 1.5 * size)
                ring = (one + other) / 2 + radius * _CIRCLE
                self._add_line(self._at_height(ring, _LINE), rgba, 1.3 * self._width)

    def _add_pointers(self, frame: int, far: float) -> None:
        """Adds discs and chevrons: where small robots are and head, whose place the root holds, where twins are.

        Args:
            frame: which frame it is.
            far: radius at which a disc can be seen from the camera [m].
        """
        scale, poses = self._scale, self._timeline.pose[frame]
        share = float(np.clip((far / scale - 0.022) / 0.02, 0.0, 1.0))
        shares = share * fading(poses[:, :2] / scale)
        shares[0] = 1.0 if self._scene.marker is not None else shares[0]  # a marker's heading is its chevron's
        size = max(scale * HULL, far)
        self._add_rings(frame, _RING_SIZE * size)
        self._add_disc(poses[0], root_radius(scale, far), _ROOT_DISC, self._pale(0, 0.6))
        for place in map(int, np.flatnonzero(shares)):
            if place:
                self._add_disc(
                    poses[place], size, _DISC_ABOVE + _STACK * (place % FLEET), self._pale(place, 0.5 * shares[place])
                )
            points = np.asarray(se2.act(poses[place][None], size * _CHEVRON))
            self._add_line(self._at_height(points, _LINE), self._pale(place, shares[place]), 1.6 * self._width)

    def _add_rings(self, frame: int, radius: float) -> None:
        """Adds a white disc below each twin: its rim shows around the robot that is where it ought to be."""
        if self._timeline.twin is None:
            return
        for pose in self._timeline.twin[frame, self._scene.spec.first_body :]:
            if np.isfinite(pose).all():
                self._add_disc(pose, radius, _RING, _solid(0.8 * _WHITE + 0.2 * _PAVED))

    def _add_disc(self, pose: np.ndarray, radius: float, height: float, rgba: np.ndarray) -> None:
        size, centre = np.array([radius, 0.0002, 0.0]), np.array([pose[0], pose[1], self._scale * height])
        geom = self._next_geom()
        mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_CYLINDER, size, centre, np.eye(3).ravel(), rgba)
        geom.category, geom.emission, geom.specular = mujoco.mjtCatBit.mjCAT_DECOR, 0.0, 0.0

    def _add_line(self, points: np.ndarray, rgba: np.ndarray, width: float) -> None:
        """Adds a polyline through points (k, 3), of one colour (4,) or one for each of its stretches (k - 1, 4)."""
        line, identity, nothing = mujoco.mjtGeom.mjGEOM_LINE, np.eye(3).ravel(), np.zeros(3)
        colours = np.broadcast_to(rgba * self._shade, (len(points) - 1, 4))
        for (start, end), colour in zip(itertools.pairwise(points), colours, strict=True):
            geom = self._next_geom()
            mujoco.mjv_initGeom(geom, line, nothing, nothing, identity, colour)
            geom.category, geom.emission, geom.specular = mujoco.mjtCatBit.mjCAT_DECOR, 0.0, 0.0
            mujoco.mjv_connector(geom, line, width, start, end)

    def _at_height(self, points: np.ndarray, height: float) -> np.ndarray:
        return np.column_stack([points, np.full(len(points), self._lift * height)])

    def _pale(self, place: int, share: float | np.ndarray) -> np.ndarray:
        """Returns a robot's colour mixed with the floor's, (4,) or (k, 4) for shares (k, 1)."""
        return _solid(share * self._colours[place] + (1 - share) * _PAVED)

    def _next_geom(self) -> mujoco.MjvGeom:
        self._visual.ngeom += 1
        return self._visual.geoms[self._visual.ngeom - 1]


def root_radius(scale: float, far: float) -> float:
    """Returns the radius of the root's disc [m].

    Args:
        scale: size of the robots over that of nh_mini.
        far: radius at which a disc can be seen from the camera [m].
    """
    return _ROOT * max(scale * HULL, far)


def disc_radius(positions: np.ndarray) -> float:
    """Returns the radius of discs around robots (f, n, 2) that leaves half of them apart from all others [m]."""
    some = positions[:: max(1, len(positions) // 10)]
    return float(np.median([cKDTree(each).query(each, k=2)[0][:, 1] for each in some])) / 2


def _solid(rgb: np.ndarray) -> np.ndarray:
    """Returns opaque colours, (..., 3) -> (..., 4)."""
    return np.concatenate([rgb, np.ones((*rgb.shape[:-1], 1))], axis=-1).astype(np.float32)
