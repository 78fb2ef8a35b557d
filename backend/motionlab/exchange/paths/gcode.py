"""G-code of plotters, engravers and mills: moves in the plane.

References
----------
Kramer, Proctor, Messina, "The NIST RS274NGC Interpreter - Version 3", NISTIR 6556, 2000.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.encodings import lines_of
from motionlab.exchange.paths.segments import (
    SEGMENTS_MAX,
    SHORTEST,
    Arc,
    Drawing,
    Segment,
    circle_arc,
    line,
)
from motionlab.trajectories.path import Vector

_WORD = re.compile(r"([A-Za-z])([+-]?(?:\d+\.?\d*|\.\d+))")
_BLANKS = re.compile(r"\s+")
_DELETED = re.compile(r"\s*(?:[Nn]\s*\d+\s*)?/")
_CHECKSUM = re.compile(r"\*\s*\d{1,3}\s*\Z")
_PROGRAM_NUMBER = re.compile(r"\s*[Oo]\s*\d{1,8}\s*\Z")
_COMMENT = re.compile(r"\([^()]*\)")
_DIGITS_MAX = 30
_LINES_MAX = 200_000
_FARTHEST = 1e3
"""Largest coordinate, m."""

_MILLIMETRE, _INCH = 1e-3, 25.4e-3
_DWELL_MAX = 3600.0

_GROUPS = {
    **dict.fromkeys(("0", "1", "2", "3", "80"), "motion"),
    **dict.fromkeys(("4", "28", "30", "53", "92", "92.1", "92.2"), "for one line"),
    "17": "plane",
    **dict.fromkeys(("20", "21"), "units"),
    **dict.fromkeys(("90", "91"), "distance"),
    **dict.fromkeys(("90.1", "91.1"), "arc centre"),
    **dict.fromkeys(("54", "55", "56", "57", "58", "59"), "coordinates"),
    **dict.fromkeys(("40", "40.1"), "cutter"),
    **dict.fromkeys(("43", "49"), "tool length"),
    **dict.fromkeys(("61", "61.1", "64"), "path control"),
    **dict.fromkeys(("98", "99"), "retract"),
    "15": "polar",
    "50": "scaling",
    "69": "rotation",
    "94": "feed mode",
}
"""Modal groups of the G words that are understood; those from `cutter` on change nothing here."""
_SHIFTS = frozenset({"92", "92.1", "92.2"})
_AWAY = frozenset({"28", "30", "53"})
"""Moves to places that the machine knows and the file does not."""

_ENDS = frozenset({"2", "30"})
_OUTPUTS = frozenset({"62", "63", "64", "65"})
"""M words whose P is the number of an output."""
_TURNS_MAX = 100
_IGNORED_M = frozenset("0 1 3 4 5 6 7 8 9 48 49 60 62 63 64 65".split())
_RADIUS_SLACK = 1e-3
"""Share of the radius by which the two ends of an arc may differ from it."""
_RADIUS_ROUNDING = 5e-6
"""What they may differ by in any case, m: files are rounded."""


def read_gcode(text: str) -> Drawing:
    """Return the moves of a program.

    G0 to G3, G4 (P in seconds), G17, G20, G21, G90, G91, G90.1, G91.1, G92, F. It starts at the
    origin; rapid moves before the first feed are left out, all others are moves of the path. Z,
    spindle and tool words, and lines of the optional block delete are left out and counted; so are
    moves to machine positions (G28, G30, G53).

    Raises
    ------
    ConfigError
        With the line of the first word that is not understood.
    """
    machine = _Machine()
    lines = lines_of(text)
    if len(lines) > _LINES_MAX:
        raise _refused(len(lines), "is more lines than can be read", range=f"{_LINES_MAX} lines")
    begun = False
    for number, content in enumerate(lines, start=1):
        if content.lstrip().startswith("%"):  # begins a tape, and ends its program
            if begun:
                machine.note_rest(lines[number:])
                break
            continue
        if _DELETED.match(content):
            machine.deleted.append(number)
            continue
        words = _words(content, number, numbered=not begun)
        begun |= bool(words)
        if not machine.carry_out(words, number):
            machine.note_rest(lines[number:])
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


def _words(content: str, number: int, *, numbered: bool) -> list[tuple[str, str]]:
    """Return letter and number of each word of a line; numbers of G and M without idle zeros.

    Blanks mean nothing outside of comments; before the first words the number of the program
    may stand.
    """
    text = _COMMENT.sub(" ", content.partition(";")[0] if "(" not in content else content)
    text = _CHECKSUM.sub("", text.partition(";")[0].strip())
    if numbered and _PROGRAM_NUMBER.match(text):
        return []
    text = _BLANKS.sub("", text)
    words, at = [], 0
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None or len(match[2]) > _DIGITS_MAX:
            what = "cannot be read; a letter and a number are expected"
            raise _refused(number, what, text[at : at + 20])
        letter, value = match[1].upper(), match[2]
        if letter in "GM":
            whole = float(value)
            value = f"{whole:.1f}".removesuffix(".0")
            if float(value) != whole:
                raise _refused(number, "is no word that is understood", f"{letter}{match[2]}")
        words.append((letter, value))
        at = match.end()
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
    shift: Vector = (0.0, 0.0)
    system: str = ""
    away: str = ""
    deleted: list[int] = field(default_factory=list)
    rest: int = 0
    left_z: bool = False

    def carry_out(self, words: list[tuple[str, str]], number: int) -> bool:
        """Do what a line says; return whether the program goes on."""
        groups, values, goes_on = self._sorted(words, number)
        self.left_z = "Z" in values
        for letter in "ZSTHD":
            if values.pop(letter, None) is not None:
                self.left_out[letter] += 1
        values.pop("N", None)
        self._modes(groups, number)
        self._set_feed(values, number)
        once = groups.get("for one line")
        self.motion = groups.get("motion", self.motion)
        if self.motion == "80":
            self.motion = None
        if once == "4":
            self._dwell(groups, values, number)
        elif once in _SHIFTS:
            self._set_shift(once, values, number)
        elif once in _AWAY:
            self._leave(once, values, number)
        elif groups.get("path control") == "64":
            values.pop("P", None)
            values.pop("Q", None)
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
        outputs = any(letter == "M" and value in _OUTPUTS for letter, value in words)
        for letter, value in words:
            known = letter in "NXYZIJRFPQSTHD"
            if letter == "G" and value in _GROUPS:
                group = _GROUPS[value]
                before = groups.get(group, value)
                if group == "motion" and value == "80":
                    # It ends a canned cycle that never began: a move beside it is the motion.
                    groups.setdefault(group, value)
                elif before in {value, "80"}:
                    groups[group] = value
                else:
                    what = f"contradicts G{before} in the same line"
                    raise _refused(number, what, f"G{value}")
            elif letter == "M" and value in _ENDS:
                goes_on = False
            elif letter == "M" and value in _IGNORED_M:
                self.left_out[f"M{value}"] += 1
            elif not known:
                raise _refused(number, "is no word that is understood", f"{letter}{value}")
            elif outputs and letter == "P":
                continue
            elif letter in values:
                raise _refused(number, "comes twice in the line", letter)
            else:
                values[letter] = float(value)
        return groups, values, goes_on

    def _modes(self, groups: dict[str, str], number: int) -> None:
        if "units" in groups:
            self.unit = _INCH if groups["units"] == "20" else _MILLIMETRE
        if "distance" in groups:
            self.absolute = groups["distance"] == "90"
        if "arc centre" in groups:
            self.absolute_centre = groups["arc centre"] == "90.1"
        if "coordinates" in groups:
            system = groups["coordinates"]
            if self.fed and self.system not in {"", system}:
                what = "changes to other coordinates, whose origin is not in the file"
                raise _refused(number, what, f"G{system}")
            self.system = system

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
        if values or groups.get("motion", "80") != "80":
            raise _refused(number, "G4 stands in a line with a move")
        if seconds:
            index = len(self.segments)
            self.dwells[index] = self.dwells.get(index, 0.0) + seconds

    def _set_shift(self, code: str, values: dict[str, float], number: int) -> None:
        """Give the present place other coordinates (G92), or its own again."""
        self._refuse_others(f"G{code}", values, number, "XY" if code == "92" else "")
        if code != "92":
            self.shift = 0.0, 0.0
            return
        x, y = (
            self.at[i] - values.pop(letter) * self.unit if letter in values else self.shift[i]
            for i, letter in enumerate("XY")
        )
        self.shift = x, y

    def _leave(self, code: str, values: dict[str, float], number: int) -> None:
        """Leave out a move to a place that only the machine knows."""
        self._refuse_others(f"G{code}", values, number, "XY")
        if code == "53" and self.motion not in {"0", "1"}:
            raise _refused(number, "G53 stands in a line without G0 and G1")
        if values or (code != "53" and not self.left_z):
            self.away = f"G{code}"
        self.left_out[f"G{code}"] += 1
        values.clear()

    def _return(self, values: dict[str, float], number: int) -> None:
        """Refuse a move that begins at a place that only the machine knows."""
        if self.motion != "0" or not self.absolute or not {"X", "Y"} <= set(values):
            what = f"begins where {self.away} has led, which is not in the file; G0 X Y first"
            raise _refused(number, what)
        self.away = ""

    @staticmethod
    def _refuse_others(word: str, values: dict[str, float], number: int, allowed: str) -> None:
        for letter in values:
            if letter not in allowed:
                raise _refused(number, f"does not belong to {word}", letter)

    def _move(self, values: dict[str, float], number: int) -> None:
        if self.motion is None:
            letter = next(iter(values))
            raise _refused(number, "comes before any of G0, G1, G2 and G3", letter)
        if self.away:
            self._return(values, number)
        allowed = "XYIJRP" if self.motion in {"2", "3"} else "XY"
        self._refuse_others(f"G{self.motion}", values, number, allowed)
        base = self.shift if self.absolute else self.at
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
        turns = values.get("P", 1.0)
        if not (turns.is_integer() and 1 <= turns <= _TURNS_MAX):
            raise _refused(number, "P is no number of turns", turns, range=f"1 to {_TURNS_MAX}")
        if "R" in values:
            if "I" in values or "J" in values:
                raise _refused(number, "has both R and I or J")
            radius = values["R"] * self.unit
            center = _centre(start, end, radius, ccw, number)
            return _turned(circle_arc(start, end, center, ccw=ccw), turns)
        if "I" not in values and "J" not in values:
            raise _refused(number, "is an arc without centre; I and J, or R, are expected")
        if self.absolute_centre:
            if "I" not in values or "J" not in values:
                raise _refused(number, "needs both I and J, since G90.1 is in force")
            base = self.shift
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
        return _turned(circle_arc(start, end, center, ccw=ccw), turns)

    @staticmethod
    def _bounded(letter: str, value: float, number: int) -> None:
        if not abs(value) <= _FARTHEST:
            raise _refused(number, f"{letter} is out of range", value, range="+-1000", unit="m")

    def note_rest(self, lines: Sequence[str]) -> None:
        """Count the lines after the end of the program."""
        self.rest = sum(bool(line.strip("% \t")) for line in lines)

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
            counts = ", ".join(f"{word} ({count})" for word, count in self.left_out.items())
            drawing.notes.append(f"left out: {counts}")
        if self.dwells:
            longest = max(self.dwells.values())
            drawing.notes.append(f"P of G4 is taken for seconds: the longest rest is {longest:g} s")
        if self.deleted:
            shown = ", ".join(map(str, self.deleted[:5])) + ", ..." * (len(self.deleted) > 5)
            drawing.notes.append(f"lines with block delete (/) left out: {shown}")
        if self.rest:
            drawing.notes.append(f"lines after the end of the program left out: {self.rest}")
        return drawing


def _turned(arc: Arc, turns: float) -> Arc:
    """Return an arc with full turns before its end: G2 and G3 with P."""
    return replace(arc, sweep=arc.sweep + math.copysign(2.0 * math.pi * (turns - 1.0), arc.sweep))


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
