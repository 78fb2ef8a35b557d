"""An SVG document reduced to what draws, checked before anything interprets it.

Entities, style sheets and references to other files are never followed; every number has a bound
and a line. What is left takes time in proportion to its size.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import NoReturn
from xml.etree.ElementTree import Element, SubElement
from xml.parsers import expat

from motionlab.errors import ConfigError, FieldError
from motionlab.trajectories.exchange.segments import SEGMENTS_MAX

DEPTH_MAX = 64
"""Most elements inside one another."""

ELEMENTS_MAX = 20_000
"""Most elements, those that `use` repeats counted each time."""

_NAMESPACES = ("http://www.w3.org/2000/svg", "")
_XLINK = "http://www.w3.org/1999/xlink"
_GROUPS = frozenset({"svg", "g", "a", "switch", "defs", "symbol"})
_SHAPES = frozenset({"path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "use"})
_SAID = frozenset({"text", "image", "foreignObject", "style"})
"""Elements whose absence is worth a note."""

_LENGTHS = frozenset("x y width height rx ry r cx cy x1 y1 x2 y2".split())
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NUMBERS = re.compile(_NUMBER)
_LENGTH = re.compile(rf"\s*({_NUMBER})\s*(px|mm|cm|in|pt|pc|%)?\s*\Z")
_BETWEEN = re.compile(r"[\s,]*")
_FUNCTION = re.compile(r"[\s,]*(matrix|translate|scale|rotate|skewX|skewY)\s*\(([^()]*)\)[\s,]*")
_ARGUMENTS = {
    "matrix": (6,),
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewX": (1,),
    "skewY": (1,),
}
_HIDDEN = re.compile(r"(?:\A|;)\s*display\s*:\s*none\s*(?:;|\Z)")
_COMMANDS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_LARGEST = 1e9
_MILLIMETRES = {
    "": 25.4 / 96,
    "px": 25.4 / 96,
    "mm": 1.0,
    "cm": 10.0,
    "in": 25.4,
    "pt": 25.4 / 72,
    "pc": 25.4 / 6,
}


@dataclass
class Document:
    """What of an SVG document draws.

    Attributes
    ----------
    root : Element
        `svg` with groups and shapes alone, without namespaces, sizes and view box.
    metres : float
        One user unit of the root, m.
    notes : list of str
        What was left out.
    """

    root: Element
    metres: float
    notes: list[str] = field(default_factory=list)


def read_document(text: str) -> Document:
    """Return the drawing elements of an SVG document.

    Raises
    ------
    ConfigError
        With the line of what cannot be read or is out of bounds.
    """
    return _Reader().read(text)


class _Reader:
    def __init__(self) -> None:
        self._parser = expat.ParserCreate("utf-8", namespace_separator=" ")
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.EntityDeclHandler = self._entity
        self._stack: list[Element | None] = []
        self._root: Element | None = None
        self._depth = self._elements = 0
        self._metres = 0.0
        self._left_out: dict[str, int] = {}
        self._lines: dict[Element, int] = {}
        self._segments: dict[Element, int] = {}

    def read(self, text: str) -> Document:
        try:
            self._parser.Parse(text.encode(), True)
        except expat.ExpatError as error:
            message = f"is no XML: {expat.ErrorString(error.code)}"
            raise ConfigError(FieldError(f"line {error.lineno}", message)) from None
        assert self._root is not None  # expat refuses a document without an element
        self._check_uses(self._root)
        notes = [f"{name} elements left out: {count}" for name, count in self._left_out.items()]
        return Document(self._root, self._metres, notes)

    def _refuse(
        self, message: str, value: object = None, *, line: int = 0, range: str = ""
    ) -> NoReturn:
        number = line or self._parser.CurrentLineNumber
        raise ConfigError(FieldError(f"line {number}", message, value, range))

    def _entity(self, name: str, *_: object) -> None:
        self._refuse("declares an entity, which is not read", name)

    def _start(self, full: str, attributes: dict[str, str]) -> None:
        namespace, _, name = full.rpartition(" ")
        self._depth += 1
        self._elements += 1
        if self._depth > DEPTH_MAX:
            self._refuse("is nested too deeply", range=f"{DEPTH_MAX} elements")
        if self._elements > ELEMENTS_MAX:
            self._refuse("is one element too many", range=f"{ELEMENTS_MAX} elements")
        if self._root is None:
            if name != "svg" or namespace not in _NAMESPACES:
                self._refuse("begins no SVG; svg is expected", name)
            self._metres = 1e-3 * self._unit(attributes)
            self._root = Element("svg")
            self._stack.append(self._root)
            return
        parent = self._stack[-1]
        draws = namespace in _NAMESPACES and (name in _GROUPS or name in _SHAPES)
        if parent is None or not draws or self._hidden(attributes):
            if parent is not None and namespace in _NAMESPACES and name in _SAID:
                self._left_out[name] = self._left_out.get(name, 0) + 1
            self._stack.append(None)
            return
        if name == "svg" or (name == "symbol" and "viewBox" in attributes):
            self._refuse("has a viewport inside the document, which is not read", name)
        clean, segments = self._clean(name, attributes)
        if name == "symbol":
            parent, name = SubElement(parent, "defs"), "g"
        element = SubElement(parent, "g" if name in {"a", "switch"} else name, clean)
        self._lines[element] = self._parser.CurrentLineNumber
        self._segments[element] = segments
        self._stack.append(element)

    def _end(self, _: str) -> None:
        self._depth -= 1
        self._stack.pop()

    @staticmethod
    def _hidden(attributes: dict[str, str]) -> bool:
        style = attributes.get("style", "")
        return attributes.get("display") == "none" or _HIDDEN.search(style) is not None

    def _unit(self, attributes: dict[str, str]) -> float:
        """Return one user unit of the root, mm: its width by its view box, or 1/96 inch."""
        box = attributes.get("viewBox")
        if box is None:
            return _MILLIMETRES[""]
        values = self._list(box, "viewBox")
        if len(values) != 4 or values[2] <= 0 or values[3] <= 0:
            self._refuse("viewBox is not four numbers, the last two above zero", box)
        units = []
        for name, extent in (("width", values[2]), ("height", values[3])):
            length = self._length(attributes.get(name, "100%"), name)
            if length[1] != "%":
                if length[0] <= 0:
                    self._refuse(f"{name} is not above zero", length[0])
                units.append(length[0] * _MILLIMETRES[length[1]] / extent)
        return min(units) if units else _MILLIMETRES[""]

    def _clean(self, name: str, attributes: dict[str, str]) -> tuple[dict[str, str], int]:
        """Return the attributes that place and shape an element, checked, and its segments."""
        clean = {"d": ""} if name == "path" else {}
        segments = 1
        for full, value in attributes.items():
            namespace, _, key = full.rpartition(" ")
            if key == "href" and namespace in {"", _XLINK} and name == "use":
                if not value.startswith("#"):
                    self._refuse("refers to another file, which is not read", value)
                clean["href"] = value
            elif namespace:
                continue
            elif key == "transform":
                clean[key] = self._transform(value)
            elif key == "d" and name == "path":
                clean[key], segments = self._path(value)
            elif key == "points" and name in {"polyline", "polygon"}:
                coordinates = len(self._list(value, key))
                if coordinates % 2:
                    self._refuse("points has an odd number of coordinates", value[-40:])
                clean[key], segments = value, coordinates // 2
            elif key in _LENGTHS and name in _SHAPES and value.strip() != "auto":
                clean[key] = self._pixels(value, key)
            elif key == "id":
                clean[key] = value
        return clean, segments

    def _finite(self, text: str, key: str) -> float:
        value = float(text)
        if not abs(value) <= _LARGEST:
            self._refuse(f"{key} has a number out of range", text, range=f"+-{_LARGEST:g}")
        return value

    def _list(self, text: str, key: str) -> list[float]:
        values, at = [], _skipped(text, 0)
        while at < len(text):
            found = _NUMBERS.match(text, at)
            if found is None:
                self._refuse(f"{key} has no number where one is expected", text[at : at + 20])
            values.append(self._finite(found[0], key))
            at = _skipped(text, found.end())
        return values

    def _length(self, text: str, key: str) -> tuple[float, str]:
        found = _LENGTH.match(text) if len(text) < 100 else None
        if found is None:
            self._refuse(f"{key} is no length", text)
        return self._finite(found[1], key), found[2] or ""

    def _pixels(self, text: str, key: str) -> str:
        number, unit = self._length(text, key)
        if number < 0 and key in {"width", "height", "rx", "ry", "r"}:
            self._refuse(f"{key} is negative", text)
        if unit == "%":
            self._refuse(f"{key} is a percentage, which is not read", text)
        return repr(number * _MILLIMETRES[unit] / _MILLIMETRES[""])

    def _transform(self, text: str) -> str:
        at = 0
        while at < len(text):
            found = _FUNCTION.match(text, at)
            if found is None:
                self._refuse("transform cannot be read", text[at : at + 40])
            if len(self._list(found[2], "transform")) not in _ARGUMENTS[found[1]]:
                self._refuse("transform has another number of arguments", found[0].strip())
            at = found.end()
        return text

    def _path(self, text: str) -> tuple[str, int]:
        """Return path data that follow the grammar, and their segments.

        Other data are refused: by the standard they end there. After Z comes M: svgelements looks
        for the last one at every Z, from the end.
        """
        at, command, first = _skipped(text, 0), "", True
        parts, begin, segments = [], 0, 0
        while at < len(text):
            segments += 1
            letter = text[at]
            if letter.upper() in _COMMANDS:
                if command == "Z" and letter not in "Mm":
                    parts += text[begin:at], "m0 0 "
                    begin = at
                command, at = letter.upper(), _skipped(text, at + 1)
                if first and command != "M":
                    self._refuse("path does not begin with M", text[:20])
                if command == "Z":
                    continue
            elif first or command == "Z":
                self._refuse("path has no command where one is expected", text[at : at + 20])
            first = False
            at = self._arguments(text, at, command)
        return "".join((*parts, text[begin:])), segments

    def _arguments(self, text: str, at: int, command: str) -> int:
        for k in range(_COMMANDS[command]):
            if command == "A" and k in {3, 4}:
                if text[at : at + 1] not in {"0", "1"}:
                    self._refuse("path has no flag, 0 or 1, in an arc", text[at : at + 20])
                at = _skipped(text, at + 1)
                continue
            found = _NUMBERS.match(text, at)
            if found is None:
                what = f"path lacks a number: {command} takes {_COMMANDS[command]}"
                self._refuse(what, text[at : at + 20])
            self._finite(found[0], "path")
            at = _skipped(text, found.end())
        return at

    def _check_uses(self, root: Element) -> None:
        """Refuse `use` of what is not there, of itself, and of too much."""
        by_id = {each.get("id"): each for each in root.iter() if each.get("id")}
        counts: dict[Element, tuple[int, int]] = {}
        under_way: set[Element] = set()

        def count(element: Element) -> tuple[int, int]:
            """Return elements and segments."""
            if element in counts:
                return counts[element]
            line = self._lines.get(element, 1)
            if element in under_way or len(under_way) > 4 * DEPTH_MAX:
                self._refuse("uses itself, or is nested too deeply", line=line)
            under_way.add(element)
            inner = [count(each) for each in element]
            if element.tag == "use":
                target = by_id.get(element.get("href", "")[1:])
                if target is None:
                    self._refuse("uses what is not there", element.get("href", ""), line=line)
                inner.append(count(target))
            elements = 1 + sum(each[0] for each in inner)
            segments = self._segments.get(element, 0) + sum(each[1] for each in inner)
            for what, total, most in (
                ("elements", elements, ELEMENTS_MAX),
                ("segments", segments, SEGMENTS_MAX),
            ):
                if total > most:
                    allowed = f"{most} {what}"
                    self._refuse("has or repeats too much", total, line=line, range=allowed)
            under_way.discard(element)
            counts[element] = elements, segments
            return elements, segments

        count(root)


def _skipped(text: str, at: int) -> int:
    """Return where the next sign stands after blanks and commas."""
    found = _BETWEEN.match(text, at)
    return found.end() if found else at


def magnitude(*values: float) -> bool:
    """Return whether numbers are finite and no larger than any that is read."""
    return all(math.isfinite(v) and abs(v) <= _LARGEST for v in values)
