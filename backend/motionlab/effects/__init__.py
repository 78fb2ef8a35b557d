"""Effects of the plant, a file each; `effects.effect` says what such a file declares.

Besides those of this room there are those of one's own: files with an EFFECT where those with a LAW
lie, in folders that MOTIONLAB_LAWS names, and in installed packages.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

from motionlab.declarations import DeclarationError, declared_in, parameters_of
from motionlab.effects.effect import (
    PARAMETER_ROWS,
    SLOTS,
    STATE_ROWS,
    Effect,
    MidStep,
    Parameter,
    Resistance,
)
from motionlab.errors import FieldError
from motionlab.own_files import ENTRY_POINTS, VARIABLE, OwnFile, own_files

_TAKEN = frozenset({"effect", "values"})
"""Names in the config of every effect."""


def _fits(effect: Effect) -> None:
    for record, most in ((effect.Parameters, PARAMETER_ROWS), (effect.State, STATE_ROWS)):
        if (count := len(record._fields)) > most:
            name = f"{effect.name}.{record.__name__}"
            raise DeclarationError(
                FieldError(name, "has too many fields", count, f"at most {most}")
            )
    parameters_of([effect], _TAKEN)


def _shipped() -> dict[str, Effect]:
    effects: list[Effect] = declared_in(__name__, __path__, "EFFECT")
    for effect in effects:
        _fits(effect)
    return {effect.name: effect for effect in effects}


def _own(shipped: Mapping[str, Effect]) -> None:
    """Take the effects of one's own that can be taken, and note why others cannot."""
    for file in own_files(os.environ.get(VARIABLE, ""), ENTRY_POINTS):
        if not file.declares("EFFECT"):
            continue
        try:
            effect, source = file.declared("EFFECT")
            _fits(effect)
            if effect.name in shipped or effect.name in OWN:
                raise DeclarationError(
                    FieldError(
                        f"{effect.name}.name", "is the name of another effect; choose another"
                    )
                )
        except DeclarationError as error:
            PROBLEMS.append(error.error.at(str(file.path)))
        else:
            OWN[effect.name] = effect
            FILES[effect.name] = file
            SOURCES[effect.name] = source


SHIPPED = _shipped()
"""The effects of this room by name."""
OWN: dict[str, Effect] = {}
"""Effects of one's own by name."""
FILES: dict[str, OwnFile] = {}
"""The file of each."""
SOURCES: dict[str, str] = {}
"""The text of the file of each."""
PROBLEMS: list[FieldError] = []
"""Why files of one's own are not taken."""
_own(SHIPPED)

EFFECTS = SHIPPED | OWN
"""Every effect by its name."""

__all__ = [
    "EFFECTS",
    "FILES",
    "OWN",
    "PARAMETER_ROWS",
    "PROBLEMS",
    "SHIPPED",
    "SLOTS",
    "SOURCES",
    "STATE_ROWS",
    "Effect",
    "MidStep",
    "Parameter",
    "Resistance",
]
