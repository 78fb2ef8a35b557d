"""Laws of friction compensation, a file each; `laws.law` says what such a file declares."""

from __future__ import annotations

import pkgutil
from importlib import import_module

from motionlab.laws.law import ROWS, Law, Parameter

_TAKEN = frozenset({"law", "enabled", "values"})
"""Names in the config of every law."""


def _laws() -> dict[str, Law]:
    """Return the laws of this room by name; the one that adds nothing first."""
    modules = [import_module(f"{__name__}.{each.name}") for each in pkgutil.iter_modules(__path__)]
    laws: list[Law] = [module.LAW for module in modules if hasattr(module, "LAW")]
    for law in laws:
        if sum(each.name == law.name for each in laws) > 1:
            raise TypeError(f"{law.name}: two files declare a law of this name")
        for record in (law.Parameters, law.State):
            if len(record._fields) > ROWS:
                raise TypeError(f"{law.name}: {record.__name__} has more than {ROWS} fields")
    return {law.name: law for law in sorted(laws, key=lambda law: (law.adds, law.name))}


def _parameters() -> dict[str, Parameter]:
    """Return the parameters of all laws by name; laws share those that are declared alike."""
    shared: dict[str, Parameter] = {}
    for law in LAWS.values():
        if _TAKEN & {each.name for each in law.parameters}:
            raise TypeError(
                f"{law.name}: a parameter may not be called {', '.join(sorted(_TAKEN))}"
            )
        for each in law.parameters:
            if shared.setdefault(each.name, each) != each:
                raise TypeError(f"{law.name}: {each.name} is declared otherwise by another law")
    return shared


LAWS = _laws()
"""Every law by its name."""

PARAMETERS = _parameters()
"""Every parameter of a law by its name."""

__all__ = ["LAWS", "PARAMETERS", "Law", "Parameter"]
