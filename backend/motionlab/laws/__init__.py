"""Laws of friction compensation, a file each; `laws.law` says what such a file declares."""

from __future__ import annotations

from motionlab.declarations import declared_in, parameters_of
from motionlab.laws.law import ROWS, Law, Parameter

_TAKEN = frozenset({"law", "enabled", "values"})
"""Names in the config of every law."""


def _laws() -> dict[str, Law]:
    """Return the laws of this room by name; the one that adds nothing first."""
    laws: list[Law] = declared_in(__name__, __path__, "LAW")
    for law in laws:
        for record in (law.Parameters, law.State):
            if len(record._fields) > ROWS:
                raise TypeError(f"{law.name}: {record.__name__} has more than {ROWS} fields")
    return {law.name: law for law in sorted(laws, key=lambda law: (law.adds, law.name))}


LAWS = _laws()
"""Every law by its name."""

PARAMETERS = parameters_of(LAWS.values(), _TAKEN)
"""Every parameter of a law by its name."""

__all__ = ["LAWS", "PARAMETERS", "Law", "Parameter"]
