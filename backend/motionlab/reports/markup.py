"""Elements of HTML and SVG; what is not an element is escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable

FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML does not know."""
_VOID = frozenset({"meta", "br", "path", "line", "rect", "circle"})
_SUBSCRIPT = re.compile(r"_(\w+)")
_POWER = re.compile(r"\^(-?\d+)")


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()

    def __html__(self) -> str:
        """Return it as templates take it: as it is."""
        return self


def escaped(text: object) -> Markup:
    """Return text as HTML, also inside of an attribute; what XML does not know is replaced."""
    if isinstance(text, Markup):
        return text
    return Markup(html.escape(FORBIDDEN.sub("\ufffd", str(text))))


def element(name: str, /, *children: object, **attributes: object) -> Markup:
    """Return an element.

    Parameters
    ----------
    name : str
        Its tag.
    *children : object
        Elements, or anything else as text; None is left out.
    **attributes : object
        By name, underscores at the end left out and others as hyphens; None is left out.
    """
    attribute_text = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escaped(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    if name in _VOID:
        return Markup(f"<{name}{attribute_text}/>")
    inside = "".join(escaped(child) for child in children if child is not None)
    return Markup(f"<{name}{attribute_text}>{inside}</{name}>")


def joined(parts: Iterable[object], between: str = "") -> Markup:
    """Return parts one after another; None is left out."""
    return Markup(escaped(between).join(escaped(part) for part in parts if part is not None))


def symbol(text: str) -> Markup:
    """Return a name with its subscripts and powers: ``k_p x``, ``m/s^2``."""
    lowered = _SUBSCRIPT.sub(r"<sub>\1</sub>", escaped(text))
    return Markup(_POWER.sub(r"<sup>\1</sup>", lowered))
