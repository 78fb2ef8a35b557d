"""Laws of friction compensation, a file each; `laws.law` says what such a file declares.

Besides those of this room there are those of one's own: of folders that MOTIONLAB_LAWS names, and
of installed packages with an entry point of the group ``motionlab.laws``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

from motionlab.declarations import DeclarationError, declared_in, parameters_of
from motionlab.effects import PROBLEMS
from motionlab.errors import FieldError
from motionlab.laws.law import ROWS, Law, Parameter
from motionlab.own_files import ENTRY_POINTS, VARIABLE, OwnFile, own_files

_TAKEN = frozenset({"law", "enabled", "values"})
"""Names in the config of every law."""


def _fits(law: Law) -> None:
    for record in (law.Parameters, law.State):
        if (count := len(record._fields)) > ROWS:
            name = f"{law.name}.{record.__name__}"
            raise DeclarationError(
                FieldError(name, "has too many fields", count, f"at most {ROWS}")
            )


def renewed(name: str, text: str | None = None) -> Law:
    """Read the file of a law of one's own again, and take what it declares in place of it.

    Parameters
    ----------
    name : str
        Of the law.
    text : str, optional
        A version of the file; left out, what it holds now.

    Raises
    ------
    DeclarationError
        If it cannot be used, or not in this process: configs have the name and the parameters of
        its former version, and lanes the rows of its state.
    """
    file, before = FILES[name], OWN[name]
    law, source = file.declared("LAW", text)
    for what in ("name", "adds", "parameters", "limits"):
        if getattr(law, what) != getattr(before, what):
            raise DeclarationError(_other(name, what, file))
    for record in ("Parameters", "State"):
        if getattr(law, record)._fields != getattr(before, record)._fields:
            raise DeclarationError(_other(name, record, file))
    OWN[name] = LAWS[name] = law
    SOURCES[name] = source
    return law


def _other(name: str, what: str, file: OwnFile) -> FieldError:
    message = "differs from that of the version that runs: restart the server to take it"
    return FieldError(f"{name}.{what}", message, place=str(file.path))


def _shipped() -> dict[str, Law]:
    """Return the laws of this room by name; the one that adds nothing first."""
    laws: list[Law] = declared_in(__name__, __path__, "LAW")
    for law in laws:
        _fits(law)
    return {law.name: law for law in sorted(laws, key=lambda law: (law.adds, law.name))}


def _own(shipped: Mapping[str, Law]) -> None:
    """Take the laws of one's own that can be taken, and note why others cannot."""
    for file in own_files(os.environ.get(VARIABLE, ""), ENTRY_POINTS):
        if file.declares("EFFECT"):
            continue  # of `motionlab.effects`
        try:
            law, source = file.declared("LAW")
            _fits(law)
            if law.name in shipped or law.name in OWN:
                raise DeclarationError(
                    FieldError(f"{law.name}.name", "is the name of another law; choose another")
                )
            parameters_of([*shipped.values(), *OWN.values(), law], _TAKEN)
        except DeclarationError as error:
            PROBLEMS.append(error.error.at(str(file.path)))
        else:
            OWN[law.name] = law
            FILES[law.name] = file
            SOURCES[law.name] = source


SHIPPED = _shipped()
"""The laws of this room by name."""
OWN: dict[str, Law] = {}
"""Laws of one's own by name."""
FILES: dict[str, OwnFile] = {}
"""The file of each."""
SOURCES: dict[str, str] = {}
"""The text of the file of each."""
_own(SHIPPED)

LAWS = SHIPPED | OWN
"""Every law by its name."""

PARAMETERS = parameters_of(LAWS.values(), _TAKEN)
"""Every parameter of a law by its name."""

__all__ = [
    "FILES",
    "LAWS",
    "OWN",
    "PARAMETERS",
    "PROBLEMS",
    "SHIPPED",
    "SOURCES",
    "Law",
    "Parameter",
    "renewed",
]
