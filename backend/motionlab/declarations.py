"""What laws and force-sharing functions declare, one file each: parameters; reading the files."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

PAPER = "Huang et al., IEEE Access 2019"
OURS = "this project's choice"


@dataclass(frozen=True)
class Parameter:
    """A parameter: a field of a controller's config.

    Attributes
    ----------
    name : str
        As in the lanes' record of parameters, where that is not derived from others.
    description : str
        What the number is.
    unit : str
        SI unit; ``1`` for a pure number.
    default : float, str or None
        None: its owner decides.
    ge, gt, le, lt : float, optional
        Bounds, in `unit`.
    usual : tuple of float, optional
        Range of a slider, in `unit`.
    shown : str
        Unit on the screen, as `motionlab.config.quantity.FACTORS` has it; empty for `unit` itself.
    choices : tuple of str
        The values of a parameter that is no number.
    label, source : str
        Name on the screen; where the number or its range comes from.
    """

    name: str
    description: str
    unit: str = "1"
    default: float | str | None = None
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    usual: tuple[float, float] | None = None
    shown: str = ""
    choices: tuple[str, ...] = ()
    label: str | None = None
    source: str = OURS


def declared_in(package: str, path: Iterable[str], variable: str) -> list[Any]:
    """Return what the modules of a package declare in a variable, in the order of their names.

    Raises
    ------
    TypeError
        If two have the same name.
    """
    modules = [import_module(f"{package}.{each.name}") for each in pkgutil.iter_modules(path)]
    owners = [getattr(module, variable) for module in modules if hasattr(module, variable)]
    names = [each.name for each in owners]
    for name in names:
        if names.count(name) > 1:
            raise TypeError(f"{name}: two files declare a {variable.lower()} of this name")
    return owners


def parameters_of(owners: Iterable[Any], taken: frozenset[str]) -> dict[str, Parameter]:
    """Return the parameters of all owners by name; owners share those that are declared alike.

    Raises
    ------
    TypeError
        If a name is `taken`, or is declared otherwise by another.
    """
    shared: dict[str, Parameter] = {}
    for owner in owners:
        for each in owner.parameters:
            if each.name in taken:
                raise TypeError(f"{owner.name}: a parameter may not be called {each.name}")
            if shared.setdefault(each.name, each) != each:
                raise TypeError(f"{owner.name}: {each.name} is declared otherwise by another")
    return shared
