"""An SVG document reduced to what draws, checked before anything interprets it.

References to other files are never followed, entities only within bounds; every number has a bound
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
from motionlab.exchange.paths.segments import SEGMENTS_MAX
from motionlab.exchange.paths.svg_path import NUMBER, PathError, absolute, skipped
from motionlab.exchange.paths.svg_prologue import read_prologue
from motionlab.exchange.paths.svg_style import Sheet, StyleError, geometry

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
_NUMBERS = re.compile(NUMBER)
_LENGTH = re.compile(rf"\s*({NUMBER})\s*(px|mm|cm|in|pt|pc|%)?\s*\Z")
_FUNCTION = re.compile(r"[\s,]*(matrix|translate|scale|rotate|skewX|skewY)\s*\(([^()]*)\)[\s,]*")
_ARGUMENTS = {
    "matrix": (6,),
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewX": (1,),
    "skewY": (1,),
}
_LARGEST = 1e9
_RATIO_ROUNDING = 1e-3
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
        self._stack: list[Element | None] = []
        self._visible = [True]
        self._root: Element | None = None
        self._sheet = Sheet("")
        self._depth = self._elements = 0
        self._metres = 0.0
        self._left_out: dict[str, int] = {}
        self._notes: list[str] = []
        self._lines: dict[Element, int] = {}
        self._segments: dict[Element, int] = {}
        self._decided: dict[Element, bool] = {}  # switch elements: only one child is drawn

    def read(self, text: str) -> Document:
        content = text.encode()
        try:
            self._sheet = Sheet(read_prologue(content))
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            message = f"is no XML: {expat.ErrorString(error.code)}"
            raise ConfigError(FieldError(f"line {error.lineno}", message)) from None
        except StyleError as error:
            self._refuse(error.message, error.value)
        assert self._root is not None  # expat refuses a document without an element
        self._check_uses(self._root)
        notes = [f"{name} left out: {count}" for name, count in self._left_out.items()]
        return Document(self._root, self._metres, self._notes + notes)

    def _refuse(
        self, message: str, value: object = None, *, line: int = 0, range: str = ""
    ) -> NoReturn:
        number = line or self._parser.CurrentLineNumber
        raise ConfigError(FieldError(f"line {number}", message, value, range))

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
            self._begin(attributes)
            return
        parent = self._stack[-1]
        draws = namespace in _NAMESPACES and (name in _GROUPS or name in _SHAPES)
        if parent is None or not draws:
            if parent is not None and namespace in _NAMESPACES and name in _SAID:
                self._leave_out(f"{name} elements")
            self._skip()
            return
        if not self._is_chosen(parent, attributes):
            self._leave_out("alternatives in switch elements")
            self._skip()
            return
        attributes |= self._sheet.hiding(name, attributes) | geometry(attributes.get("style", ""))
        visibility = attributes.get("visibility", "inherit")
        visible = self._visible[-1] if visibility == "inherit" else visibility == "visible"
        if attributes.get("display") == "none" or (name in _SHAPES and not visible):
            self._leave_out("hidden elements")
            self._skip()
            return
        if name in _SHAPES and not _has_size(name, attributes):
            self._leave_out(f"{name} elements without a size")
            self._skip()
            return
        self._refuse_origin(attributes)
        self._visible.append(visible)
        if name == "svg" or (name == "symbol" and "viewBox" in attributes):
            self._refuse("has a viewport inside the document, which is not read", name)
        clean, segments = self._clean(name, attributes)
        if name == "symbol":
            parent, name = SubElement(parent, "defs"), "g"
        element = SubElement(parent, "g" if name in {"a", "switch"} else name, clean)
        self._lines[element] = self._parser.CurrentLineNumber
        self._segments[element] = segments
        if name == "switch":
            self._decided[element] = False
        self._stack.append(element)

    def _begin(self, attributes: dict[str, str]) -> None:
        """Take the root: its size, and a group for its transform."""
        attributes |= self._sheet.hiding("svg", attributes) | geometry(attributes.get("style", ""))
        self._refuse_origin(attributes)
        self._metres = 1e-3 * self._unit(attributes)
        self._root = Element("svg")
        transform = self._transform(attributes.get("transform", ""))
        top = SubElement(self._root, "g", {"transform": transform}) if transform else self._root
        self._stack.append(None if attributes.get("display") == "none" else top)
        self._visible.append(attributes.get("visibility", "visible") in {"visible", "inherit"})

    def _is_chosen(self, parent: Element, attributes: dict[str, str]) -> bool:
        """Return whether an element is drawn: of a switch, the first that may be."""
        if parent not in self._decided:
            return True
        chosen = not self._decided[parent] and _applies(attributes)
        self._decided[parent] |= chosen
        return chosen

    def _skip(self) -> None:
        self._stack.append(None)
        self._visible.append(False)

    def _leave_out(self, what: str) -> None:
        self._left_out[what] = self._left_out.get(what, 0) + 1

    def _refuse_origin(self, attributes: dict[str, str]) -> None:
        if attributes.get("transform", "") and attributes.get("transform-origin", "0").strip("0 "):
            self._refuse("transform-origin is not read", attributes["transform-origin"])
        if {attributes.get(key, "none") for key in ("clip-path", "mask")} != {"none"}:
            self._leave_out("clip paths and masks")

    def _end(self, _: str) -> None:
        self._depth -= 1
        self._stack.pop()
        self._visible.pop()

    def _unit(self, attributes: dict[str, str]) -> float:
        """Return one user unit of the root, mm: its width by its view box, or 1/96 inch."""
        box = attributes.get("viewBox")
        if box is None:
            self._note_pixels()
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
        if not units:
            self._note_pixels()
            return _MILLIMETRES[""]
        ratio = attributes.get("preserveAspectRatio", "").split()
        if "none" in ratio and max(units) > min(units) * (1.0 + _RATIO_ROUNDING):
            self._refuse("preserveAspectRatio none is not read", " ".join(ratio))
        return max(units) if "slice" in ratio else min(units)

    def _note_pixels(self) -> None:
        self._notes.append(
            "user units are taken for 1/96 inch: no size with a view box is in the file"
        )

    def _clean(self, name: str, attributes: dict[str, str]) -> tuple[dict[str, str], int]:
        """Return the attributes that place and shape an element, checked, and its segments."""
        clean = {"d": ""} if name == "path" else {}
        segments = 1
        sizes = {"rx": attributes.get("rx", "auto"), "ry": attributes.get("ry", "auto")}
        if name == "ellipse":  # where one is missing, it is as large as the other
            other = {"rx": sizes["ry"], "ry": sizes["rx"]}
            attributes |= {k: other[k] if _auto(v) else v for k, v in sizes.items()}
        for full, value in attributes.items():
            namespace, _, key = full.rpartition(" ")
            if key == "href" and namespace in {"", _XLINK} and name == "use":
                if namespace and "href" in attributes:
                    continue  # href goes before xlink:href
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
            elif key in _LENGTHS and name in _SHAPES and not _auto(value):
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
        values, at = [], skipped(text, 0)
        while at < len(text):
            match = _NUMBERS.match(text, at)
            if match is None:
                self._refuse(f"{key} has no number where one is expected", text[at : at + 20])
            values.append(self._finite(match[0], key))
            at = skipped(text, match.end())
        return values

    def _length(self, text: str, key: str) -> tuple[float, str]:
        match = _LENGTH.match(text) if len(text) < 100 else None
        if match is None:
            self._refuse(f"{key} is no length", text)
        return self._finite(match[1], key), match[2] or ""

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
            match = _FUNCTION.match(text, at)
            if match is None:
                self._refuse("transform cannot be read", text[at : at + 40])
            if len(self._list(match[2], "transform")) not in _ARGUMENTS[match[1]]:
                self._refuse("transform has another number of arguments", match[0].strip())
            at = match.end()
        return text

    def _path(self, text: str) -> tuple[str, int]:
        """Return path data written out, and their segments."""
        try:
            return absolute(text, _LARGEST)
        except PathError as error:
            self._refuse(error.message, error.text, range=error.allowed)

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


def _applies(attributes: dict[str, str]) -> bool:
    """Return whether a child of a switch may be drawn: no extension, in English or any language."""
    languages = attributes.get("systemLanguage", "en").lower().split(",")
    english = any(language.strip().split("-")[0] == "en" for language in languages)
    return english and "requiredExtensions" not in attributes


def _auto(value: str) -> bool:
    return value.strip() == "auto"


def _has_size(name: str, attributes: dict[str, str]) -> bool:
    """Return whether a shape has all sizes without which nothing is drawn."""
    match name:
        case "rect":
            return {"width", "height"} <= {k for k, v in attributes.items() if not _auto(v)}
        case "circle":
            return "r" in attributes
        case "ellipse":
            return any(not _auto(attributes.get(key, "auto")) for key in ("rx", "ry"))
    return True


def magnitude(*values: float) -> bool:
    """Return whether numbers are finite and no larger than any that is read."""
    return all(math.isfinite(v) and abs(v) <= _LARGEST for v in values)
