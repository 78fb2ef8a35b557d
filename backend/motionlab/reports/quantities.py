"""Numbers with units as people read them: SI prefixes, significant digits, names of fields."""

from __future__ import annotations

import functools
import math
import re
from typing import Any, NamedTuple

from motionlab.config.fields import FieldEntry, fields_of
from motionlab.config.scenario import Scenario
from motionlab.laws import REDECLARED
from motionlab.reports.markup import Markup, element, joined, symbol
from motionlab.reports.units import Scale, scale_for

_MINUS = "\u2212"
_VARIANT = re.compile(r"(?<=^variants\.)[A-Z](?=\.)")
_INDEX = re.compile(r"(?<=\.)\d+(?=\.|$)")
_VALUES = 6
"""Numbers of a list that are printed."""


def digits(value: float, significant: int = 3) -> str:
    """Return a number with so many significant digits, never as a power of ten below a million."""
    if not math.isfinite(value):
        return "\u2013"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if not -6 <= exponent < 6:
        return f"{value:.{significant - 1}e}".replace("-", _MINUS)
    return f"{value:.{max(0, significant - 1 - exponent)}f}".replace("-", _MINUS)


def number(value: float | None, scale: Scale, **attributes: object) -> Markup:
    """Return a cell with a number, and the exact one in SI as its ``value``."""
    if value is None:
        return element("td", "\u2013", class_="number", **attributes)
    exact = element("data", digits(value / scale.size), value=repr(float(value)))
    return element("td", exact, class_="number", **attributes)


def quantity(value: float, unit: str, significant: int = 4) -> str:
    """Return a number with its unit."""
    scale = scale_for([value], unit)
    return f"{digits(value / scale.size, significant)} {scale.unit}".rstrip()


class Field(NamedTuple):
    """A field of a scenario as people read it."""

    name: Markup
    unit: str
    factor: float
    usual: tuple[float, float] | None = None


def field_at(path: str) -> Field:
    """Return name, unit, factor and usual range of the field at a dotted path."""
    steps = path.split(".")
    entry = _fields().get(_INDEX.sub("*", _VARIANT.sub("*", path)))
    variant = f"{steps[1]}: " if steps[0] == "variants" and len(steps) > 2 else ""
    if entry is None:
        return Field(joined([variant, path if not variant else ".".join(steps[2:])]), "", 1.0)
    name = joined([variant, symbol(entry.label)])
    return Field(name, entry.unit, entry.factor, entry.usual)


def value_markup(path: str, value: Any) -> Markup:
    """Return the value of the field at a dotted path, with its unit."""
    field = field_at(path)
    text = _text(value, field.factor)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return joined([text, " ", symbol(field.unit)]) if number and field.unit else joined([text])


def change_of(path: str, before: Any, after: Any) -> Markup:
    """Return how a field changed."""
    return joined([value_markup(path, before), " \u2192 ", value_markup(path, after)])


def _text(value: Any, factor: float = 1.0) -> str:
    match value:
        case None:
            return "none"
        case bool():
            return "on" if value else "off"
        case int() | float():
            return f"{value * factor:.7g}".replace("-", _MINUS)
        case list():
            some = ", ".join(_text(each) for each in value[:_VALUES])
            return f"{some} \u2026 ({len(value)})" if len(value) > _VALUES else some
        case dict():
            return ", ".join(f"{key} {_text(each)}" for key, each in value.items())
        case _:
            return str(value)


@functools.cache
def _fields() -> dict[str, FieldEntry]:
    return fields_of(Scenario)


REDECLARED.append(_fields.cache_clear)
