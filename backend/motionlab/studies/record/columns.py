"""Columns of a kept run that a study reads: chosen by name, or the first of a variant's channels.

A unit comes with the column, so each is read in SI.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.column_guess import si_of
from motionlab.library.run import RunDetail

POSITION_CHANNELS = ("position_measured", "position")
FORCE_CHANNELS = ("force_realised", "force_command", "thrust")
PHASES = "abc"

_LISTED = 20


def units_of(run: RunDetail) -> dict[str, str]:
    """Return the unit of each column."""
    return {column["name"]: column["unit"] for column in run.columns}


def variant_of(requested: str | None, run: RunDetail, loc: str = "variant") -> str:
    """Return the variant whose channels are read; the run's first where none is named.

    Raises
    ------
    ConfigError
        If the run has no such variant.
    """
    if requested is None:
        return run.variants[0] if run.variants else "M"
    if requested not in run.variants:
        allowed = "one of " + ", ".join(run.variants)
        raise ConfigError(FieldError(loc, "is no variant of the run", requested, allowed))
    return requested


def first_of(units: Mapping[str, str], prefix: str, names: Sequence[str]) -> str | None:
    """Return the first of a variant's channels that the run has; None if it has none."""
    return next((prefix + name for name in names if prefix + name in units), None)


def column_of(  # noqa: PLR0913 - where it is named, and what stands in for it
    named: str | None,
    units: Mapping[str, str],
    *,
    loc: str,
    prefix: str,
    names: Sequence[str],
    fitting: Sequence[str] = (),
) -> str:
    """Return the column that is named, else the first of a variant's channels.

    Parameters
    ----------
    named : str or None
        By the request.
    units : mapping
        Unit of each column of the run.
    loc : str
        Field that names a column.
    prefix : str
        Of the variant's axis, such as ``M.x.``.
    names : sequence of str
        Channels, the preferred one first.
    fitting : sequence of str
        Columns that could be named; all where left out.

    Raises
    ------
    ConfigError
        If none is named and the run has none of the channels.
    """
    chosen = named or first_of(units, prefix, names)
    if chosen is not None:
        return chosen
    missing = ", ".join(prefix + name for name in names)
    message = f"the run has none of {missing}; name a column"
    raise ConfigError(FieldError(loc, message, None, listed(fitting or list(units))))


def listed(names: Sequence[str]) -> str:
    """Return columns as an error allows them."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"one of {', '.join(names[:_LISTED])}{more}" if names else "none: no column fits"


def in_unit(units: Mapping[str, str], si_unit: str) -> list[str]:
    """Return the columns of a unit."""
    factors = {name: si_of(unit) for name, unit in units.items() if unit}
    return [name for name, factor in factors.items() if factor and factor[0] == si_unit]


def factor_to(si_unit: str, name: str, units: Mapping[str, str], loc: str) -> float:
    """Return the factor of a column to an SI unit.

    Raises
    ------
    ConfigError
        If there is no such column, or it has another unit.
    """
    if name not in units:
        allowed = listed(in_unit(units, si_unit))
        raise ConfigError(FieldError(loc, "is no column of the run", name, allowed))
    factor = si_of(units[name]) if units[name] else None
    if factor is None or factor[0] != si_unit:
        message = f"column {name!r} has a unit other than {si_unit}"
        raise ConfigError(FieldError(loc, message, units[name] or "none", f"a unit of {si_unit}"))
    return factor[1]
