"""Entities and style sheets of an SVG document, read before its elements."""

from __future__ import annotations

import contextlib
import re
from xml.parsers import expat

from motionlab.errors import ConfigError, FieldError

_EXPANDED_MAX = 100_000
"""Most characters that all uses of entities may expand to."""

_DEPTH_MAX = 20
_REFERENCE = re.compile(r"&([A-Za-z_:][\w.:-]{0,99});")


def read_prologue(content: bytes) -> str:
    """Return the style sheets of a document, one after another.

    Parameters
    ----------
    content : bytes
        The document in UTF-8.

    Raises
    ------
    ConfigError
        If it uses an entity that lies in another file, or that expands too far. An entity that is
        declared and not used is harmless: drawing programs write some into every file.
    """
    reader = _Prologue(content)
    with contextlib.suppress(expat.ExpatError):  # whoever reads the elements says where
        reader.parser.Parse(content, True)
    return "\n".join(reader.sheets)


class _Prologue:
    def __init__(self, content: bytes) -> None:
        self.parser = expat.ParserCreate("utf-8", namespace_separator=" ")
        self.parser.EntityDeclHandler = self._entity
        self.parser.EndDoctypeDeclHandler = self._check_references
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.sheets: list[str] = []
        self._content = content
        self._values: dict[str, str | None] = {}
        self._lengths: dict[str, int | None] = {}
        self._within = False

    def _entity(self, name: str, parameter: int, value: str | None, *_: object) -> None:
        """Keep the text of an entity; None for one of another file."""
        if not parameter:
            self._values.setdefault(name, value)  # the first declaration counts

    def _length(self, name: str, depth: int = 0) -> int | None:
        """Return how many characters an entity expands to; None if it needs another file."""
        if name not in self._values:
            return 0
        if name not in self._lengths:
            value = self._values[name]
            inner = _REFERENCE.findall(value or "")
            deep = depth > _DEPTH_MAX and bool(inner)  # or it uses itself
            parts = [_EXPANDED_MAX + 1] if deep else [self._length(n, depth + 1) for n in inner]
            total = len(value or "") + sum(part or 0 for part in parts)
            outside = value is None or None in parts
            self._lengths[name] = None if outside else min(total, _EXPANDED_MAX + 1)
        return self._lengths[name]

    def _check_references(self) -> None:
        begin, total = self.parser.CurrentByteIndex, 0
        for reference in _REFERENCE.finditer(self._content[begin:].decode()):
            length = self._length(reference[1])
            total += length or 0
            if length is None or total > _EXPANDED_MAX:
                place = len(reference.string[: reference.start()].encode())
                line = self._content.count(b"\n", 0, begin + place) + 1
                what = "lies in another file" if length is None else "expands too far"
                message = f"uses an entity that {what}"
                raise ConfigError(FieldError(f"line {line}", message, reference[1]))

    def _start(self, full: str, _: dict[str, str]) -> None:
        self._within = full.rpartition(" ")[2] == "style"
        if self._within:
            self.sheets.append("")

    def _end(self, _: str) -> None:
        self._within = False

    def _text(self, text: str) -> None:
        if self._within:
            self.sheets.append(text)
