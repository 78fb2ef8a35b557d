"""Names in text tables that a spreadsheet would take for formulas."""

from __future__ import annotations

_BEGINS = ("=", "+", "-", "@", "\t", "\r")


def inert(name: str) -> str:
    """Return a name that no spreadsheet computes: with an apostrophe before a formula's sign."""
    return f"'{name}" if name.startswith(_BEGINS) else name


def original(name: str) -> str:
    """Return the name that `inert` was given."""
    return name[1:] if name.startswith("'") and name[1:].startswith(_BEGINS) else name
