"""What is written over the picture: title, clock, errors, and a map of the whole run."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from nhtrack import se2
from nhtrack.recording import Recording
from nhtrack.simulation.scene import SceneSpec
from nhtrack.video.timeline import Timeline

__all__ = ["Overlay"]

_Colour: TypeAlias = str | tuple[int, int, int]
_Line: TypeAlias = tuple[str, ImageFont.FreeTypeFont, _Colour]

_PAPER, _INK, _GREY = (250, 250, 252, 205), (26, 26, 26), (105, 108, 115)
_NAMED = 4  # more followers than this are summed up in two lines, more groups are written smaller
_CROWDED = 0.85  # size of their letters over that of the others
_LINES = 7  # that fit above the robots; more stand beside them
_MAP_SHARE = 0.27  # of the picture's width
_MAP_TALLEST = 0.28  # of the picture's height: the camera keeps the robots below it
_FINE = 3  # the map is drawn this much larger and reduced: Pillow's lines are not smooth
_DART = np.array([[0.62, 0.0], [-0.38, 0.36], [-0.20, 0.0], [-0.38, -0.36]])


class Overlay:
    """Writes over the frames of one film; everything that stays the same is drawn once.

    Args:
        recording: the run.
        timeline: the film's frames.
        size: width and height of the picture [pixels].
    """

    def __init__(self, recording: Recording, timeline: Timeline, size: tuple[int, int]) -> None:
        self._recording, self._timeline, self._size = recording, timeline, size
        self._colour = SceneSpec.from_json(recording.dataset.attrs["scene"]).colour
        self._groups = _groups(recording)
        unit = size[1] / 480
        self._pad = round(8 * unit)
        self._title, self._text = _font(15 * unit, bold=True), _font(13 * unit)
        self._small = _font(13 * unit * (1.0 if len(self._groups) <= _NAMED else _CROWDED))
        self._map = _Map(timeline, self._colour, round(_MAP_SHARE * size[0]), round(_MAP_TALLEST * size[1]), unit)
        self._ended = "" if recording.outcome == "completed" else recording.outcome

    def write(self, picture: np.ndarray, frame: int, footprint: np.ndarray | None) -> np.ndarray:
        """Returns the picture of a frame with text and map, bytes of shape (height, width, 3).

        Args:
            picture: what the camera sees, same shape.
            frame: which frame it is.
            footprint: corners (4, 2) of the floor in view [m], or None to leave it out.
        """
        image = Image.fromarray(picture)
        self._write_panel(image, frame)
        inset = self._map.draw(self._timeline.pose[frame], frame, footprint)
        image.paste(inset, (self._size[0] - inset.width - self._pad, self._pad), inset)
        return np.asarray(image)

    def _write_panel(self, image: Image.Image, frame: int) -> None:
        lines: list[_Line] = [(self._recording.name, self._title, _INK)]
        lines.append((self._clock(frame), self._text, _INK))
        lines += [(text, self._small, colour) for text, colour in self._errors(frame)]
        if self._ended and frame == len(self._timeline) - 1:
            lines.append((self._ended, self._text, _INK))
        after = self._paste(image, lines[:_LINES], self._pad)
        if len(lines) > _LINES:
            self._paste(image, lines[_LINES:], after)

    def _paste(self, image: Image.Image, lines: list[_Line], left: int) -> int:
        """Writes lines into a panel that begins so far to the right; returns where it ends."""
        heights = [round(1.45 * (self._small if font is self._small else self._text).size) for _, font, _ in lines]
        width = round(max(font.getlength(text) for text, font, _ in lines))
        width = -(-width // 24) * 24  # in steps, so that the panel does not breathe with the digits
        panel = Image.new("RGBA", (width + 2 * self._pad, sum(heights) + 2 * self._pad), _PAPER)
        draw = ImageDraw.Draw(panel)
        for row, (text, font, colour) in enumerate(lines):
            draw.text((self._pad, self._pad + sum(heights[:row])), text, font=font, fill=colour)
        image.paste(panel, (left, self._pad), panel)
        return left + panel.width

    def _clock(self, frame: int) -> str:
        speed = self._timeline.speed
        pace = "" if speed == 1.0 else f"    {speed:g}x"
        return f"t = {self._timeline.time[frame]:5.1f} s{pace}"

    def _errors(self, frame: int) -> list[tuple[str, _Colour]]:
        """Returns lines of text and their colours: position errors of followers, of groups, or the spread of many."""
        distance = self._timeline.distance[frame, 1:]
        if self._groups:
            return self._group_errors(frame)
        if distance.size <= _NAMED:
            names = self._recording.robots[1:]
            return [
                (f"{name}  {_length(value)}", self._colour(place))
                for place, (name, value) in enumerate(zip(names, distance, strict=True), start=1)
            ]
        middle, worst = float(np.median(distance)), float(np.max(distance))
        return [
            (f"{distance.size} followers", _GREY),
            (f"median {_length(middle)}", _INK),
            (f"worst  {_length(worst)}", _INK),
        ]

    def _group_errors(self, frame: int) -> list[tuple[str, _Colour]]:
        """Returns lines of text and their colours: the worst position error of each group, until its run ended."""
        most = max(map(len, self._groups.values()))
        lines: list[tuple[str, _Colour]] = [(f"worst of {most} followers", _GREY)] if most > 1 else []
        for name, places in self._groups.items():
            worst = float(self._timeline.distance[frame, places].max())  # NaN where one of them is
            lines.append((f"{name}  {'ended' if np.isnan(worst) else _length(worst)}", self._colour(places[0])))
        return lines


class _Map:
    """The whole run from above: faint paths, brighter up to now, robots as darts, and what the camera sees."""

    def __init__(
        self, timeline: Timeline, colour: Callable[[int], str], width: int, tallest: int, unit: float
    ) -> None:
        positions = timeline.pose[..., :2]
        low, high = positions.min(axis=(0, 1)), positions.max(axis=(0, 1))
        room = np.maximum(high - low, 0.2)
        margin = 12 * unit
        self._scale = min((width - 2 * margin) / room[0], (tallest - 2 * margin) / room[1])  # [pixels/m]
        self._size = (
            max(round(room[0] * self._scale + 2 * margin), width // 2),
            round(room[1] * self._scale + 2 * margin),
        )
        self._middle = (low + high) / 2
        self._unit, self._crowd = unit, positions.shape[1] > 8
        self._trails, self._time, self._colour = timeline.trails, timeline.time, colour
        self._faint = self._sheet()
        draw = ImageDraw.Draw(self._faint)
        for place in reversed(range(positions.shape[1])):
            self._line(draw, self._trails[place].points, colour(place) + "66", 1.2)

    def draw(self, pose: np.ndarray, frame: int, footprint: np.ndarray | None) -> Image.Image:
        """Returns the map at a frame."""
        sheet = self._faint.copy()
        draw = ImageDraw.Draw(sheet)
        if footprint is not None:
            self._line(draw, np.vstack([footprint, footprint[:1]]), "#50545C", 0.9)
        order = list(reversed(range(len(pose))))
        for place in order:
            so_far = int(np.searchsorted(self._trails[place].time, self._time[frame], side="right"))
            way = np.vstack([self._trails[place].points[:so_far], pose[place, :2]])
            self._line(draw, way, self._colour(place), 0.8 if self._crowd and place else 1.6)
        length = (7 if self._crowd else 11) * self._unit / self._scale
        for place in sorted(order):  # followers upon the root, smaller
            size = length * (1.25 if place == 0 else 0.9)
            corners = self._pixels(se2.act(pose[place][None, :], size * _DART))
            draw.polygon(corners, fill=self._colour(place), outline="white")
        return sheet.reduce(_FINE)

    def _sheet(self) -> Image.Image:
        width, height = (_FINE * side for side in self._size)
        sheet = Image.new("RGBA", (width, height), _PAPER)
        ImageDraw.Draw(sheet).rectangle((0, 0, width - 1, height - 1), outline="#B9BDC4", width=_FINE)
        return sheet

    def _pixels(self, points: np.ndarray) -> list[tuple[float, float]]:
        centred = (points - self._middle) * self._scale * _FINE
        middle = np.array(self._size) * _FINE / 2
        return [(float(x), float(y)) for x, y in centred * [1, -1] + middle]

    def _line(self, draw: ImageDraw.ImageDraw, points: np.ndarray, colour: str, width: float) -> None:
        draw.line(self._pixels(points), fill=colour, width=max(1, round(width * self._unit * _FINE)))


def _groups(recording: Recording) -> dict[str, list[int]]:
    """Returns the places of the robots of each group, for a recording that says it has some; see `together`."""
    groups: dict[str, list[str]] = json.loads(recording.dataset.attrs.get("groups", "{}"))
    return {name: [recording.robots.index(robot) for robot in robots] for name, robots in groups.items()}


def _length(metres: float) -> str:
    """Returns a distance with a unit that suits it; figures of constant width, so that they can be read running."""
    if metres >= 1e4:
        return f"{metres:.0e} m"
    if metres >= 1.0:
        return f"{metres:5.2f} m"
    return f"{100 * metres:5.1f} cm" if metres >= 0.01 else f"{1000 * metres:5.2f} mm"


def _font(pixels: float, *, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Returns the figures' typeface, which matplotlib brings along."""
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), max(round(pixels), 8))
