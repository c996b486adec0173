"""What is written over the picture: title, clock, errors, a map of the whole run, and what the signs mean."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from nhtrack.colours import TOUCH, letter_colour
from nhtrack.presentation.shown import ground_of
from nhtrack.recording import Recording
from nhtrack.video.legend import draw_legend
from nhtrack.video.map import Map
from nhtrack.video.timeline import Timeline
from nhtrack.video.typography import GREY, INK, PAPER, font, running_lengths

__all__ = ["Overlay"]

_Colour: TypeAlias = str | tuple[int, int, int]
Above: TypeAlias = Callable[[int], np.ndarray]
_Line: TypeAlias = tuple[str, ImageFont.FreeTypeFont, _Colour]

_NAMED = 4  # more followers than this are summed up in two lines, more groups are written smaller
_CROWDED = 0.85  # size of their letters over that of the others
_LINES = 7  # that fit above the robots; more stand beside them
_MAP_SHARE = 0.27  # of the picture's width
_MAP_TALLEST = 0.28  # of the picture's height: the camera keeps the robots below it


class Overlay:
    """Writes over the frames of one film; everything that stays the same is drawn once.

    Args:
        recording: the run.
        timeline: the film's frames.
        size: width and height of the picture [pixels].
        above: where in the picture of a frame the places just above the robots are [pixels], shape (n, 2); without it
            names do not stand at robots.
        unit: pixels per pixel of a picture of 480 lines, by default of this one.
    """

    def __init__(
        self,
        recording: Recording,
        timeline: Timeline,
        size: tuple[int, int],
        above: Above | None = None,
        unit: float | None = None,
    ) -> None:
        self._above = above if len(recording.robots) - 1 <= _NAMED else None
        self._recording, self._timeline, self._size = recording, timeline, size
        colour = recording.scene.colour
        self._ink = {place: letter_colour(colour(place)) for place in range(len(recording.robots))}
        self._groups = _groups(recording)
        unit = unit or size[1] / 480
        self._pad = round(8 * unit)
        self._title, self._text = font(15 * unit, bold=True), font(13 * unit)
        self._small = font(13 * unit * (1.0 if len(self._groups) <= _NAMED else _CROWDED))
        self._map = Map(timeline, colour, round(_MAP_SHARE * size[0]), round(_MAP_TALLEST * size[1]), unit)
        self._legend = draw_legend(timeline, unit, size[0] - 2 * self._pad, ground_of(recording))
        self._ended = "" if recording.outcome == "completed" else recording.outcome

    def write(self, picture: np.ndarray, frame: int) -> np.ndarray:
        """Returns the picture of a frame with text and map, bytes of shape (height, width, 3).

        Args:
            picture: what the camera sees, same shape.
            frame: which frame it is.
        """
        image = Image.fromarray(picture)
        self._write_names(image, frame)
        self._write_panel(image, frame)
        inset = self._map.draw(self._timeline.pose[frame], frame)
        image.paste(inset, (self._size[0] - inset.width - self._pad, self._pad), inset)
        image.paste(self._legend, (self._pad, self._size[1] - self._legend.height - self._pad), self._legend)
        return np.asarray(image)

    def _write_names(self, image: Image.Image, frame: int) -> None:
        """Writes names above the robots; where they would lie on each other, one above the other."""
        if self._above is None:
            return
        places, face = self._above(frame), self._small
        height, taken = 1.35 * face.size, list[tuple[float, float, float]]()
        for place in sorted(np.flatnonzero(np.isfinite(places).all(axis=1)), key=lambda k: -places[k, 1]):
            (x, y), name = places[place], self._recording.robots[place]
            half = face.getlength(name) / 2 + 0.3 * self._pad
            while any(abs(x - other) < half + wide and abs(y - level) < height for other, level, wide in taken):
                y -= 0.25 * height
            taken.append((x, y, half))
            panel = Image.new("RGBA", (round(2 * half), round(height)), PAPER)
            ImageDraw.Draw(panel).text((half, height / 2), name, font=face, fill=self._ink[int(place)], anchor="mm")
            image.paste(panel, (round(x - half), round(y - height)), panel)

    def _write_panel(self, image: Image.Image, frame: int) -> None:
        lines: list[_Line] = [(self._recording.name, self._title, INK)]
        lines.append((self.clock_text(frame), self._text, INK))
        lines += [(text, self._small, colour) for text, colour in self.error_lines(frame)]
        lines += [(text, self._small, GREY) for text in self.gap_lines(frame)]
        lines += [(text, self._small, TOUCH) for text in self.touch_lines(frame)]
        if self._ended and frame == len(self._timeline) - 1:
            lines.append((self._ended, self._text, INK))
        after = self._paste(image, lines[:_LINES], self._pad)
        if len(lines) > _LINES:
            self._paste(image, lines[_LINES:], after)

    def _paste(self, image: Image.Image, lines: list[_Line], left: int) -> int:
        """Writes lines into a panel that begins so far to the right; returns where it ends."""
        heights = [round(1.45 * (self._small if face is self._small else self._text).size) for _, face, _ in lines]
        width = round(max(face.getlength(text) for text, face, _ in lines))
        width = -(-width // 24) * 24  # in steps, so that the panel does not breathe with the digits
        panel = Image.new("RGBA", (width + 2 * self._pad, sum(heights) + 2 * self._pad), PAPER)
        draw = ImageDraw.Draw(panel)
        for row, (text, face, colour) in enumerate(lines):
            draw.text((self._pad, self._pad + sum(heights[:row])), text, font=face, fill=colour)
        image.paste(panel, (left, self._pad), panel)
        return left + panel.width

    def clock_text(self, frame: int) -> str:
        """Returns the robots' time in a frame, and the film's pace where it is not life's."""
        speed = self._timeline.speed
        pace = "" if speed == 1.0 else f"    {speed:.3g}x"
        return f"t = {self._timeline.time[frame]:5.1f} s{pace}"

    def gap_lines(self, frame: int) -> list[str]:
        """Returns a line of text: how far robots and ideal twins are apart, at most; none where that is unknown."""
        if self._timeline.twin is None:
            return []
        offset = self._timeline.twin[frame, :, :2] - self._timeline.pose[frame, :, :2]
        apart = np.hypot(offset[:, 0], offset[:, 1])
        known = apart[np.isfinite(apart)]
        return [f"from ideal  {running_lengths([float(known.max())])[0]}"] if known.size else []

    def touch_lines(self, frame: int) -> list[str]:
        """Returns a line of text: who touch each other in a frame; none where nobody does."""
        now = self._timeline.time[frame]
        pairs = [touch.robots for touch in self._timeline.touches if touch.start <= now <= touch.end]
        if not pairs:
            return []
        return [f"touch: {' and '.join(pairs[0])}{f', {len(pairs) - 1} more' if len(pairs) > 1 else ''}"]

    def error_lines(self, frame: int) -> list[tuple[str, _Colour]]:
        """Returns lines of text and their colours: position errors of followers, of groups, or the spread of many."""
        distance = self._timeline.distance[frame, 1:]
        if self._groups:
            return self._group_errors(frame)
        if distance.size <= _NAMED:
            told = zip(self._recording.robots[1:], running_lengths(distance.tolist()), strict=True)
            return [(f"{name}  {value}", self._ink[place]) for place, (name, value) in enumerate(told, start=1)]
        middle, worst = running_lengths([float(np.median(distance)), float(np.max(distance))])
        return [
            (f"{distance.size} followers", GREY),
            (f"median {middle}", INK),
            (f"worst  {worst}", INK),
        ]

    def _group_errors(self, frame: int) -> list[tuple[str, _Colour]]:
        """Returns lines of text and their colours: the worst position error of each group, until its run ended."""
        most = max(map(len, self._groups.values()))
        lines: list[tuple[str, _Colour]] = [(f"worst of {most} followers", GREY)] if most > 1 else []
        worst = [float(self._timeline.distance[frame, places].max()) for places in self._groups.values()]
        texts = ["ended" if text == "unknown" else text for text in running_lengths(worst)]  # NaN where one of them is
        groups = zip(self._groups.items(), texts, strict=True)
        return lines + [(f"{name}  {text}", self._ink[places[0]]) for (name, places), text in groups]


def _groups(recording: Recording) -> dict[str, list[int]]:
    """Returns the places of the robots of each group, for a recording that says it has some; see `together`."""
    return {name: [recording.robots.index(robot) for robot in robots] for name, robots in recording.groups.items()}
