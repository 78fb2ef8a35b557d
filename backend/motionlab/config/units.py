"""Dimensions of quantities: read from units, computed with, written as the shortest unit."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple, TypeAlias

Exponents: TypeAlias = Mapping[str, Fraction]

_DERIVED: dict[str, dict[str, int]] = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {"s": -1},
}
_BASE = ("m", "kg", "s", "A", "K")
_PREFIXES = {"n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "k": 1e3}
_PREFIXED = ("m", "s", "A", "N", "J", "W", "V", "T", "Hz", "ohm", "Pa")
_WRITTEN = ("N", "J", "W", "V", "ohm", "T", "Wb", "H")
"""Derived units that results are written with, the likeliest first."""
_POWERS = (1, -1, 2, -2, Fraction(1, 2))
_MASS_COST = 2
"""No channel is in kg: a unit with N is preferred to it."""
_EXPONENT_MAX = 64
_UNIT_MAX = 40
_OTHER = {
    "cm": ("m", 1e-2),
    "in": ("m", 0.0254),
    "g": ("kg", 1e-3),
    "min": ("s", 60.0),
    "deg": ("rad", math.pi / 180.0),
    "°": ("rad", math.pi / 180.0),
    "rpm": ("Hz", 1.0 / 60.0),
}
"""Units that people write in fields, and that no channel has."""
_AMOUNT = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)\s*(\S.*)?")
_AMOUNT_MAX = 80
_FACTOR = re.compile(r"([*/·]|\s)?\s*([^\W\d]+|1|%)(?:\^(-?[0-9]{1,2}))?\s*")


@dataclass(frozen=True)
class Dimension:
    """Exponents of base units; empty for a pure number."""

    exponents: Exponents = field(default_factory=dict)

    def __mul__(self, other: Dimension) -> Dimension:
        """Return the dimension of a product."""
        names = {**self.exponents, **other.exponents}
        sums = {n: self.exponents.get(n, _ZERO) + other.exponents.get(n, _ZERO) for n in names}
        return Dimension({name: value for name, value in sums.items() if value})

    def __truediv__(self, other: Dimension) -> Dimension:
        """Return the dimension of a quotient."""
        return self * other**-1

    def __pow__(self, exponent: int | Fraction) -> Dimension:
        """Return the dimension of a power."""
        if exponent == 0:
            return Dimension()
        return Dimension({name: value * exponent for name, value in self.exponents.items()})

    @property
    def pure(self) -> bool:
        """Whether it is that of a number."""
        return not self.exponents

    @property
    def excessive(self) -> bool:
        """Whether an exponent is beyond any use."""
        return any(abs(value) > _EXPONENT_MAX for value in self.exponents.values())

    def __str__(self) -> str:
        """Return the unit with the fewest factors, such as ``N/m``; ``1`` for a number."""
        best, cost = self.exponents, _cost(self.exponents)
        for name in _WRITTEN:
            for power in _POWERS:
                rest = (self / derived(name) ** power).exponents
                exponents: Exponents = {name: Fraction(power), **rest}
                if (price := _cost(exponents)) < cost:
                    best, cost = exponents, price
        return _text(best)


class Unit(NamedTuple):
    """A unit as a dimension and the SI value of one."""

    dimension: Dimension
    factor: float = 1.0


_ZERO = Fraction(0)
PURE = Dimension()
SECOND = Dimension({"s": Fraction(1)})


def derived(name: str) -> Dimension:
    """Return the dimension of a unit without prefix; of an unknown name one of its own."""
    return Dimension({k: Fraction(v) for k, v in _DERIVED.get(name, {name: 1}).items()})


def parse_unit(text: str, *, strict: bool = False) -> Unit | None:
    """Return a unit such as ``m/s^2`` or ``N s/m``.

    Parameters
    ----------
    text : str
        Factors parted by ``*``, a space or ``/``; a ``/`` holds for the factor after it.
    strict : bool
        Whether an unknown name is no unit. Otherwise it is a base unit of its own: it can be added
        to itself only.

    Returns
    -------
    Unit or None
        None where it is no unit; never with ``strict=False``.
    """
    unit = _read(text, strict)
    if unit is not None or strict:
        return unit
    return Unit(Dimension({text: Fraction(1)}))


def _read(text: str, strict: bool) -> Unit | None:
    text = text.strip()
    if text in {"", "1"}:
        return Unit(PURE)
    dimension, factor, place = PURE, 1.0, 0
    while place < len(text):
        match = _FACTOR.match(text, place)
        if not match or len(text) > _UNIT_MAX:
            return None
        sign, name, exponent = match[1], match[2], int(match[3] or 1)
        one = _named(name, strict)
        if one is None:
            return None
        power = -exponent if sign == "/" else exponent
        dimension *= one.dimension**power
        factor *= one.factor**power
        place = match.end()
    return Unit(dimension, factor)


def _named(name: str, strict: bool) -> Unit | None:
    if name in {"1", "rad"}:
        return Unit(PURE)
    if name == "%":
        return Unit(PURE, 0.01)
    if name in _DERIVED or name in _BASE:
        return Unit(derived(name))
    prefix, rest = _PREFIXES.get(name[0]), name[1:]
    if prefix is not None and rest in _PREFIXED:
        return Unit(derived(rest), prefix)
    return None if strict else Unit(derived(name))


def _cost(exponents: Exponents) -> Fraction:
    total = sum((abs(value) for value in exponents.values()), _ZERO)
    return total + _MASS_COST * ("kg" in exponents)


def _text(exponents: Exponents) -> str:
    above = [_power(name, value) for name, value in exponents.items() if value > 0]
    below = [_power(name, -value) for name, value in exponents.items() if value < 0]
    return "/".join([" ".join(above) or "1", *below])


def _power(name: str, exponent: Fraction) -> str:
    if exponent == 1:
        return name
    whole = exponent.denominator == 1
    return f"{name}^{int(exponent) if whole else format(float(exponent), 'g')}"


def si_amount(text: str, unit: str) -> float | None:
    """Return the number in a field's unit that a text such as ``15 mm`` or ``0.015`` stands for.

    Parameters
    ----------
    text : str
        A number, with a unit or without.
    unit : str
        SI unit of the field; empty or ``1`` for a pure number.

    Returns
    -------
    float or None
        None where the text is no number, or its unit is of another dimension.
    """
    parts = _AMOUNT.fullmatch(text.strip()) if len(text) <= _AMOUNT_MAX else None
    if parts is None:
        return None
    name, other = parts[2] or unit, 1.0
    if name in _OTHER:
        name, other = _OTHER[name]
    name = name.replace("²", "^2").replace("Ω", "ohm")
    here, there = parse_unit(name, strict=True), parse_unit(unit, strict=True)
    if here is None or there is None or here.dimension != there.dimension:
        return None
    amount = float(f"{float(parts[1]) * other * here.factor / there.factor:.12g}")
    return amount if math.isfinite(amount) else None
