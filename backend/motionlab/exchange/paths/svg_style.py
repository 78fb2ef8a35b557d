"""Style of SVG elements: the properties that place, shape or hide what is drawn."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from motionlab.exchange.paths.svg_path import NUMBER

_GEOMETRY = frozenset("x y cx cy r rx ry width height transform".split())
_HIDING = frozenset({"display", "visibility"})
_CLIPPING = frozenset({"clip-path", "mask"})
_UNREAD = frozenset(
    "d translate rotate scale transform-origin transform-box zoom offset offset-path".split()
)
"""Properties that move or shape an element and are not read."""
_NOTHING = re.compile(r"none|initial|auto|[+-]?0+(?:\.0*)?(?:px|%)?", re.IGNORECASE)
_FUNCTION = re.compile(r"\s*([A-Za-z]+)\s*\(([^()]*)\)\s*")
_VALUE = re.compile(rf"\s*({NUMBER})\s*(px|deg|rad|grad|turn)?\s*\Z")
_DEGREES = {"deg": 1.0, "rad": 180.0 / math.pi, "grad": 0.9, "turn": 360.0}
_ATTRIBUTES = {
    "matrix": "matrix",
    "translate": "translate",
    "scale": "scale",
    "rotate": "rotate",
    "skewx": "skewX",
    "skewy": "skewY",
}
_ONE_AXIS = {
    "translatex": ("translate", "{0} 0"),
    "translatey": ("translate", "0 {0}"),
    "scalex": ("scale", "{0} 1"),
    "scaley": ("scale", "1 {0}"),
}
_SIMPLE = re.compile(r"[.#]?[A-Za-z_][\w-]*|\*")
_LONGEST = 100_000  # characters of a style sheet
_LONGEST_VALUE = 100


class StyleError(Exception):
    """A style that cannot be read: the property, and its value."""

    def __init__(self, message: str, value: str) -> None:
        super().__init__(message)
        self.message, self.value = message, value


def declarations(style: str) -> Iterator[tuple[str, str]]:
    """Yield names and values of a list of declarations."""
    for declaration in _without_comments(style).split(";"):
        name, colon, value = declaration.partition(":")
        before, mark, last = value.rpartition("!")
        if mark and last.strip().lower() == "important":
            value = before
        if colon:
            yield name.strip().lower(), value.strip()


def _without_comments(text: str) -> str:
    first, *others = text.split("/*")
    return " ".join([first, *(each.partition("*/")[2] for each in others)])


def _harmless(value: str) -> bool:
    return all(map(_NOTHING.fullmatch, value.split()))


def geometry(style: str) -> dict[str, str]:
    """Return the attributes that a style attribute stands for: they go before those beside it.

    Raises
    ------
    StyleError
        If it moves or shapes the element in a way that is not read.
    """
    attributes = {}
    for name, value in declarations(style):
        if name == "transform":
            attributes[name] = _transform(value)
        elif name in _GEOMETRY or name in _HIDING or name in _CLIPPING:
            attributes[name] = value
        elif name in _UNREAD and not _harmless(value):
            raise StyleError(f"style: {name} is not read; give it as an attribute", value)
    return attributes


def _transform(value: str) -> str:
    """Return the attribute that a property stands for: other units, the same functions."""
    if value.lower() == "none":
        return ""
    parts, at = [], 0
    while at < len(value):
        match = _FUNCTION.match(value, at)
        if match is None:
            raise StyleError("style: transform cannot be read", value)
        parts.append(_function(match[1].lower(), match[2].split(","), value))
        at = match.end()
    return " ".join(parts)


def _function(name: str, texts: list[str], whole: str) -> str:
    angle = name in {"rotate", "skewx", "skewy"}
    arguments = []
    for text in texts:
        match = _VALUE.match(text) if len(text) < _LONGEST_VALUE else None
        if match is None or ((match[2] or "") in _DEGREES) != (angle and match[2] is not None):
            raise StyleError("style: transform cannot be read; lengths are px, angles deg", whole)
        arguments.append(repr(float(match[1]) * _DEGREES.get(match[2] or "", 1.0)))
    if name in _ONE_AXIS and len(arguments) == 1:
        function, form = _ONE_AXIS[name]
        return f"{function}({form.format(*arguments)})"
    if name not in _ATTRIBUTES or (angle and len(arguments) != 1):
        raise StyleError("style: transform cannot be read", whole)
    return f"{_ATTRIBUTES[name]}({' '.join(arguments)})"


class Sheet:
    """What style sheets hide, by simple selectors: an element, a class, an identifier.

    Raises
    ------
    StyleError
        If a rule moves or shapes what it selects, or hides it by a selector of another form.
    """

    def __init__(self, text: str) -> None:
        self._hiding: dict[str, dict[str, str]] = {}
        if len(text) > _LONGEST:
            raise StyleError("has a style sheet that is too long", f"{len(text)} characters")
        for rule in _without_comments(text).split("}"):
            head, _, body = rule.rpartition("{")
            self._add([each.strip() for each in head.split(",")], body)

    def _add(self, selectors: list[str], body: str) -> None:
        hiding = {}
        for name, value in declarations(body):
            moves = name in _GEOMETRY | _UNREAD and not _harmless(value)
            if moves and not (selectors == ["svg"] and value.endswith("%")):
                message = f"style sheet: {name} is not read; give it as an attribute"
                raise StyleError(message, f"{', '.join(selectors)} {{{name}: {value}}}")
            if name in _HIDING:
                hiding[name] = value
        for selector in selectors if hiding else []:
            if not _SIMPLE.fullmatch(selector):
                message = "style sheet: the selector of what it hides is not read"
                raise StyleError(message, selector)
            self._hiding.setdefault(selector, {}).update(hiding)

    def hiding(self, name: str, attributes: dict[str, str]) -> dict[str, str]:
        """Return ``display`` and ``visibility`` that the sheets give to an element."""
        if not self._hiding:
            return {}
        classes = [f".{each}" for each in attributes.get("class", "").split()[:100]]
        properties: dict[str, str] = {}
        for selector in ("*", name, *classes, f"#{attributes.get('id', '')}"):
            properties |= self._hiding.get(selector, {})
        return properties
