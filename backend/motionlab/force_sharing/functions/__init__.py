"""Force-sharing functions, a file each; `functions.function` says what such a file declares."""

from __future__ import annotations

from typing import Any, NamedTuple

from motionlab.declarations import declared_in, parameters_of
from motionlab.force_sharing.functions.function import SharingFunction
from motionlab.lanes import Lanes

_TAKEN = frozenset({"law", "parameters"})
"""Names in the config of every function."""


def _functions() -> dict[str, SharingFunction]:
    """Return the functions of this folder by name; the one with a closed form first."""
    functions: list[SharingFunction] = declared_in(__name__, __path__, "FUNCTION")
    if sum(each.closed is not None for each in functions) != 1:
        raise TypeError("not one sharing function alone has a closed form")
    order = sorted(functions, key=lambda each: (each.closed is None, each.name))
    return {each.name: each for each in order}


FUNCTIONS = _functions()
"""Every force-sharing function by its name; its place is its number in the kernel."""

CLOSED_FORM = 0.0
"""Number of the one that has a closed form on an analytic map."""

PARAMETERS = parameters_of(FUNCTIONS.values(), _TAKEN)
"""Every parameter of a force-sharing function by its name."""

_NAMES: Any = [(name, Lanes) for name in PARAMETERS]
SharingParameters: Any = NamedTuple("SharingParameters", _NAMES)
SharingParameters.__doc__ = "Parameters of the force-sharing functions."
SharingParameters.comments = {
    name: f"{each.description[0].lower()}{each.description[1:]}, {each.unit}"
    for name, each in PARAMETERS.items()
}


def function_number(name: str) -> float:
    """Return the number of a force-sharing function in the kernel."""
    return float(list(FUNCTIONS).index(name))


def function_of(number: float) -> SharingFunction:
    """Return the force-sharing function of a number."""
    return list(FUNCTIONS.values())[int(number)]
