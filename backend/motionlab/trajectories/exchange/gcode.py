"""G-code of plotters, engravers and mills: moves in the plane.

References
----------
Kramer, Proctor, Messina, "The NIST RS274NGC Interpreter - Version 3", NISTIR 6556, 2000.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass, field

from motionlab.errors import ConfigError, FieldError
from motionlab.trajectories.exchange.segments import (
    SEGMENTS_MAX,
    SHORTEST,
    Arc,
    Drawing,
    Segment,
    circle_arc,
    line,
)
from motionlab.trajectories.path import Vector

_WORD = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_COMMENT = re.compile(r"\([^()]*\)")
_DIGITS_MAX = 30
_LINES_MAX = 200_000
_FARTHEST = 1e3
"""Largest coordinate, m."""

_MILLIMETRE, _INCH = 1e-3, 25.4e-3
_DWELL_MAX = 3600.0

_GROUPS = {
    **dict.fromkeys(("0", "1", "2", "3", "80"), "motion"),
    "4": "dwell",
    "17": "plane",
    **dict.fromkeys(("20", "21"), "units"),
    **dict.fromkeys(("90", "91"), "distance"),
    **dict.fromkeys(("90.1", "91.1"), "arc centre"),
    "40": "cutter",
    "49": "tool length",
    "54": "coordinates",
    **dict.fromkeys(("61", "64"), "path control"),
    "94": "feed mode",
}
"""Modal groups of the G words that are understood; those from `cutter` on change nothing here."""

_ENDS = frozenset({"2", "30"})
_IGNORED_M = frozenset({"0", "1", "3", "4", "5", "6", "7", "8", "9"})
_RADIUS_SLACK = 1e-3
"""Share of the radius by which the two ends of an arc may differ from it."""
_RADIUS_ROUNDING = 5e-6
"""What they may differ by in any case, m: files are rounded."""


def read_gcode(text: str) -> Drawing:
    """Return the moves of a program.

    G0 to G3, G4 (P in seconds), G17, G20, G21, G90, G91, G90.1, G91.1, F. It starts at the origin;
    rapid moves before the first feed are left out, all others are moves of the path. Z, spindle and
    tool words are left out and counted.

    Raises
    ------
    ConfigError
        With the line of the first word that is not understood.
    """
    machine = _Machine()
    lines = text.splitlines()
    if len(lines) > _LINES_MAX:
        raise _refused(len(lines), "is more lines than can be read", range=f"{_LINES_MAX} lines")
    for number, content in enumerate(lines, start=1):
        if not machine.carry_out(_words(content, number), number):
            break
    if not machine.fed:
        raise _refused(
            max(len(lines), 1), "is the end, and nothing was drawn; G1, G2 or G3 is expected"
        )
    return machine.drawing()


def _refused(
    number: int, message: str, value: object = None, *, range: str = "", unit: str = ""
) -> ConfigError:
    return ConfigError(FieldError(f"line {number}", message, value, range, unit))


def _words(content: str, number: int) -> list[tuple[str, str]]:
    """Return letter and number of each word of a line; numbers of G and M without idle zeros."""
    text = _COMMENT.sub(" ", content.partition(";")[0] if "(" not in content else content)
    text = text.partition(";")[0].strip()
    if text.strip("%") == "":
        return []
    words, at = [], 0
    while at < len(text):
        found = _WORD.match(text, at)
        if found is None or len(found[2]) > _DIGITS_MAX:
            what = "cannot be read; a letter and a number are expected"
            raise _refused(number, what, text[at : at + 20])
        letter, value = found[1].upper(), found[2]
        if letter in "GM":
            whole = float(value)
            value = f"{whole:.1f}".removesuffix(".0")
            if float(value) != whole:
                raise _refused(number, "is no word that is understood", f"{letter}{found[2]}")
        words.append((letter, value))
        at = found.end()
    return words


@dataclass
class _Machine:
    at: Vector = (0.0, 0.0)
    unit: float = _MILLIMETRE
    motion: str | None = None
    absolute: bool = True
    absolute_centre: bool = False
    feed: float | None = None
    segments: list[Segment] = field(default_factory=list)
    fed: int = 0
    rapids: int = 0
    feeds: Counter[float] = field(default_factory=Counter)
    dwells: dict[int, float] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)

    def carry_out(self, words: list[tuple[str, str]], number: int) -> bool:
        """Do what a line says; return whether the program goes on."""
        groups, values, goes_on = self._sorted(words, number)
        for letter in "ZST":
            if values.pop(letter, None) is not None:
                self.left_out[letter] += 1
        values.pop("N", None)
        self._modes(groups)
        self._set_feed(values, number)
        if "dwell" in groups:
            self._dwell(groups, values, number)
        elif groups.get("path control") == "64":
            values.pop("P", None)
        self.motion = groups.get("motion", self.motion)
        if self.motion == "80":
            self.motion = None
        if values:
            self._move(values, number)
        elif groups.get("motion") in {"2", "3"}:
            raise _refused(number, "has no end and no centre; X, Y and I, J or R are expected")
        return goes_on

    def _sorted(
        self, words: list[tuple[str, str]], number: int
    ) -> tuple[dict[str, str], dict[str, float], bool]:
        """Return G words by modal group, the other words, and whether the program goes on."""
        groups: dict[str, str] = {}
        values: dict[str, float] = {}
        goes_on = True
        for letter, value in words:
            known = letter in "NXYZIJRFPST"
            if letter == "G" and value in _GROUPS:
                group = _GROUPS[value]
                if group in groups:
                    what = f"contradicts G{groups[group]} in the same line"
                    raise _refused(number, what, f"G{value}")
                groups[group] = value
            elif letter == "M" and value in _ENDS:
                goes_on = False
            elif letter == "M" and value in _IGNORED_M:
                self.left_out[f"M{value}"] += 1
            elif not known:
                raise _refused(number, "is no word that is understood", f"{letter}{value}")
            elif letter in values:
                raise _refused(number, "comes twice in the line", letter)
            else:
                values[letter] = float(value)
        return groups, values, goes_on

    def _modes(self, groups: dict[str, str]) -> None:
        if "units" in groups:
            self.unit = _INCH if groups["units"] == "20" else _MILLIMETRE
        if "distance" in groups:
            self.absolute = groups["distance"] == "90"
        if "arc centre" in groups:
            self.absolute_centre = groups["arc centre"] == "90.1"

    def _set_feed(self, values: dict[str, float], number: int) -> None:
        feed = values.pop("F", None)
        if feed is None:
            return
        if feed <= 0:
            raise _refused(number, "is no feed", feed, range="> 0")
        self.feed = feed * self.unit / 60.0

    def _dwell(self, groups: dict[str, str], values: dict[str, float], number: int) -> None:
        seconds = values.pop("P", None)
        if seconds is None or not 0 <= seconds <= _DWELL_MAX:
            what = "has no P with the seconds to rest" if seconds is None else "rests too long"
            raise _refused(number, f"G4 {what}", seconds, range=f"0 to {_DWELL_MAX:g}", unit="s")
        if values or "motion" in groups:
            raise _refused(number, "G4 stands in a line with a move")
        if seconds:
            index = len(self.segments)
            self.dwells[index] = self.dwells.get(index, 0.0) + seconds

    def _move(self, values: dict[str, float], number: int) -> None:
        if self.motion is None:
            letter = next(iter(values))
            raise _refused(number, "comes before any of G0, G1, G2 and G3", letter)
        allowed = "XYIJR" if self.motion in {"2", "3"} else "XY"
        for letter in values:
            if letter not in allowed:
                raise _refused(number, f"does not belong to G{self.motion}", letter)
        base = (0.0, 0.0) if self.absolute else self.at
        x, y = (
            base[i] + values[letter] * self.unit if letter in values else self.at[i]
            for i, letter in enumerate("XY")
        )
        end = x, y
        for letter, value in zip("XY", end, strict=True):
            self._bounded(letter, value, number)
        start = self.at
        self.at = end
        if self.motion == "0" and not self.fed:
            return
        if self.motion in {"0", "1"}:
            segment = line(start, end) if math.dist(start, end) >= SHORTEST else None
        else:
            segment = self._arc(start, end, values, number)
        if segment is None:
            self.at = start if math.dist(start, end) < SHORTEST else end
            return
        if len(self.segments) >= SEGMENTS_MAX:
            raise _refused(number, "is one move too many", range=f"{SEGMENTS_MAX} moves")
        self.segments.append(segment)
        if self.motion == "0":
            self.rapids += 1
        else:
            self.fed += 1
            if self.feed is not None:
                self.feeds[self.feed] += 1

    def _arc(self, start: Vector, end: Vector, values: dict[str, float], number: int) -> Arc:
        ccw = self.motion == "3"
        if "R" in values:
            if "I" in values or "J" in values:
                raise _refused(number, "has both R and I or J")
            radius = values["R"] * self.unit
            return circle_arc(start, end, _centre(start, end, radius, ccw, number), ccw=ccw)
        if "I" not in values and "J" not in values:
            raise _refused(number, "is an arc without centre; I and J, or R, are expected")
        if self.absolute_centre:
            if "I" not in values or "J" not in values:
                raise _refused(number, "needs both I and J, since G90.1 is in force")
            base = (0.0, 0.0)
        else:
            base = start
        i, j = (values.get(letter, 0.0) * self.unit for letter in "IJ")
        center = base[0] + i, base[1] + j
        self._bounded("I", center[0], number)
        self._bounded("J", center[1], number)
        before, after = math.dist(start, center), math.dist(end, center)
        if before < SHORTEST or after < SHORTEST:
            raise _refused(number, "is an arc of radius zero")
        if abs(before - after) > max(_RADIUS_ROUNDING, _RADIUS_SLACK * before):
            raise _refused(
                number,
                f"is no arc: its end is {after * 1e3:.6g} mm from the centre, its start",
                before * 1e3,
                unit="mm",
            )
        return circle_arc(start, end, center, ccw=ccw)

    @staticmethod
    def _bounded(letter: str, value: float, number: int) -> None:
        if not abs(value) <= _FARTHEST:
            raise _refused(number, f"{letter} is out of range", value, range="+-1000", unit="m")

    def drawing(self) -> Drawing:
        """Return what was drawn."""
        drawing = Drawing(
            segments=self.segments,
            read=f"{self.fed} moves at feed, {self.rapids} rapid",
            moves=self.rapids,
            dwells=self.dwells,
        )
        if self.feeds:
            (drawing.v_max, _), *others = self.feeds.most_common()
            if others:
                drawing.notes.append(
                    f"{len(self.feeds)} feeds: that of most moves, {drawing.v_max * 1e3:.6g} mm/s, "
                    "is the speed of all"
                )
        if self.rapids:
            drawing.notes.append("rapid moves run at the speed of the others")
        if self.left_out:
            found = ", ".join(f"{word} ({count})" for word, count in self.left_out.items())
            drawing.notes.append(f"left out: {found}")
        return drawing


def _centre(start: Vector, end: Vector, radius: float, ccw: bool, number: int) -> Vector:
    """Return the centre of an arc by its radius; a negative one takes the longer way round."""
    chord = math.dist(start, end)
    if chord < SHORTEST:
        raise _refused(number, "is a full circle by R; I and J are expected")
    half = chord / 2.0
    if abs(radius) < half - max(_RADIUS_ROUNDING, _RADIUS_SLACK * half):
        raise _refused(
            number,
            "R is too small for the distance to the end",
            abs(radius) * 1e3,
            range=f">= {half * 1e3:.6g}",
            unit="mm",
        )
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    side = 1.0 if ccw == (radius > 0) else -1.0
    x, y = end[0] - start[0], end[1] - start[1]
    middle = (start[0] + end[0]) / 2.0, (start[1] + end[1]) / 2.0
    return middle[0] - side * height * y / chord, middle[1] + side * height * x / chord
