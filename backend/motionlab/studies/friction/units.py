"""Units of any machine of one axis: positions along or about it, forces, torques or currents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from motionlab.errors import ConfigError, FieldError

_RADIUS = 0.1
"""Radius at whose rim an angle counts as a displacement, m: the rests, reversals and bristles of
`motionlab.studies.identify.record.motion` are lengths."""

Units = Mapping[str, tuple[str, float]]

LENGTHS: Units = {
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "nm": ("m", 1e-9),
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", math.pi / 180.0),
    "\N{DEGREE SIGN}": ("rad", math.pi / 180.0),
    "rev": ("rad", 2.0 * math.pi),
}
"""Units of a position: its SI unit, and the factor to it."""

NEWTONS: Units = {"n": ("N", 1.0), "mn": ("N", 1e-3), "kn": ("N", 1e3)}
FORCES: Units = NEWTONS | {
    "nm": ("N m", 1.0),
    "mnm": ("N m", 1e-3),
    "ncm": ("N m", 1e-2),
    "a": ("A", 1.0),
    "ma": ("A", 1e-3),
}
"""Units of a force, a torque, or a current in its place."""


class Machine(NamedTuple):
    """SI units of the position and the force of a machine."""

    length: str
    force: str

    @property
    def metres(self) -> float:
        """What one unit of the position counts, m."""
        return 1.0 if self.length == "m" else _RADIUS

    def displacement(self, metres: float) -> str:
        """Return a displacement as text."""
        value = metres / self.metres
        factor, prefix = (1e6, "u") if value < 1e-3 else (1e3, "m")
        return f"{factor * value:.3g} {prefix}{self.length}"

    def speed(self, metres: float) -> str:
        """Return a speed as text."""
        return f"{metres / self.metres:.3g} {self.length}/s"

    def unit_of(self, name: str) -> tuple[str, float]:
        """Return the unit of a parameter, and the factor from m and N as they were counted."""
        L, F, metres = self.length, self.force, self.metres
        units = {
            "v_s": (f"{L}/s", 1.0 / metres),
            "v_0": (f"{L}/s", 1.0 / metres),
            "sigma_0": (f"{F}/{L}", metres),
            "sigma_1": (f"{F} s/{L}", metres),
            "sigma_2": (f"{F} s/{L}", metres),
            "M": (_MASSES.get((L, F), f"{F} s^2/{L}"), metres),
            "C": (f"{F}/s", 1.0),
            "mu": ("1" if F == "N" else f"{F}/N", 1.0),
            "lag": ("s", 1.0),
        }
        return units.get(name, (F, 1.0))


_MASSES = {("m", "N"): "kg", ("rad", "N m"): "kg m^2"}


def factor_of(loc: str, name: str, columns: Mapping[str, str], units: Units) -> tuple[str, float]:
    """Return the SI unit of a column and the factor to it.

    Raises
    ------
    ConfigError
        If there is no such column, or it has none of these units.
    """
    kinds = ", ".join(dict.fromkeys(si for si, _ in units.values()))
    if name not in columns:
        fitting = [n for n, unit in columns.items() if _plain(unit) in units]
        listed = ", ".join(fitting[:20]) or f"none: no column is in {kinds}"
        raise ConfigError(FieldError(loc, "is no column of the run", name, f"one of {listed}"))
    known = units.get(_plain(columns[name]))
    if known is None:
        message = f"column {name!r} has another unit; import it with one of these in its header"
        raise ConfigError(FieldError(loc, message, columns[name] or "none", f"a unit of {kinds}"))
    return known


def _plain(unit: str) -> str:
    for sign in " *\N{MIDDLE DOT}\N{DOT OPERATOR}":
        unit = unit.replace(sign, "")
    return unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u").lower()
