"""Laws of friction compensation, a file each; `laws.law` says what such a file declares.

Besides those of this room there are those of one's own: of folders that MOTIONLAB_LAWS names, and
of installed packages with an entry point of the group ``motionlab.laws``.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from motionlab.declarations import DeclarationError, declared_in, parameters_of
from motionlab.effects import OWN as EFFECTS
from motionlab.effects import PROBLEMS
from motionlab.errors import FieldError
from motionlab.laws.law import ROWS, Law, Parameter
from motionlab.own_files import ENTRY_POINTS, VARIABLE, OwnFile, accepted_versions, own_files

_TAKEN = frozenset({"law", "enabled", "values"})
"""Names in the config of every law."""
_BEFORE = "@before"
"""Ends the name of the version before of a law; names in files have no @."""


def _fits(law: Law) -> None:
    for record in (law.Parameters, law.State):
        if (count := len(record._fields)) > ROWS:
            name = f"{law.name}.{record.__name__}"
            raise DeclarationError(
                FieldError(name, "has too many fields", count, f"at most {ROWS}")
            )


def other_version(name: str, file: OwnFile, text: str | None = None) -> tuple[Law, str]:
    """Read another version of the file of a law of one's own.

    Parameters
    ----------
    name : str
        Of the law, or of its version before.
    file : OwnFile
        The file.
    text : str, optional
        The version; left out, what the file holds now.

    Returns
    -------
    Law, str
        What it declares, and the text.

    Raises
    ------
    DeclarationError
        If it cannot be used, or has another name.
    """
    law, source = file.declared("LAW", text)
    _fits(law)
    if law.name != base_of(name):
        message = "is another name than before: a new law needs a file of its own"
        error = FieldError("LAW.name", message, law.name, base_of(name), place=str(file.path))
        raise DeclarationError(error)
    return (law if name == law.name else _before(law)), source


def new_law(file: OwnFile, text: str | None = None) -> tuple[Law, str]:
    """Read a file whose law is not among those that are here.

    Parameters
    ----------
    file : OwnFile
        The file.
    text : str, optional
        As in `other_version`.

    Returns
    -------
    Law, str
        What it declares, and the text.

    Raises
    ------
    DeclarationError
        If it cannot be used, or another law or an effect has its name.
    """
    law, source = file.declared("LAW", text)
    _fits(law)
    for names, owner in (({*SHIPPED, *OWN}, "another law"), (EFFECTS, "an effect")):
        if law.name in names:  # runs keep the texts of both by name
            message = f"is the name of {owner}; choose another"
            raise DeclarationError(FieldError(f"{law.name}.name", message))
    return law, source


def declared_with(own: Mapping[str, Law]) -> tuple[dict[str, Law], dict[str, Parameter]]:
    """Return laws of one's own as they are beside each other and those that ship.

    A version before has the present declaration of a parameter that another law has, too.

    Returns
    -------
    dict of str to Law, dict of str to Parameter
        The laws, and the parameters of every law, by name.

    Raises
    ------
    DeclarationError
        If two laws declare a name otherwise, or a version before could not take a value of it.
    """
    laws = dict(own)
    present = [law for name, law in laws.items() if name == base_of(name)]
    shared = parameters_of([*SHIPPED.values(), *present], _TAKEN)
    for name, law in own.items():
        if name == base_of(name):
            continue
        parameters = tuple(_shared(each, shared, law) for each in law.parameters)
        if parameters != law.parameters:
            laws[name] = replace(law, parameters=parameters)
        shared |= {each.name: each for each in parameters}
    return laws, shared


def _shared(own: Parameter, shared: Mapping[str, Parameter], law: Law) -> Parameter:
    """Return the parameter of a version before, as others declare it if they do."""
    other = shared.get(own.name, own)
    if (own.choices, own.default is None) != (other.choices, other.default is None):
        message = "takes other kinds of values in the version before; choose another name"
        raise DeclarationError(FieldError(f"{base_of(law.name)}.{own.name}", message))
    return other


def put(laws: Mapping[str, Law], sources: Mapping[str, str], files: Mapping[str, OwnFile]) -> None:
    """Have these be the laws of one's own, with their texts and files, as `declared_with`."""
    _, parameters = declared_with(laws)
    _replace(OWN, laws)
    _replace(LAWS, SHIPPED | dict(laws))
    _replace(SOURCES, sources)
    _replace(FILES, files)
    if parameters != PARAMETERS:
        _replace(PARAMETERS, parameters)
    for renew in REDECLARED:
        renew()


def _replace(table: dict[str, Any], entries: Mapping[str, Any]) -> None:
    """Put entries in place of those of a table, at no time without one of both."""
    table.update(entries)
    for name in table.keys() - entries.keys():
        del table[name]


def before_of(name: str) -> str:
    """Return the name under which the version before of a law's file runs."""
    return f"{name}{_BEFORE}"


def base_of(name: str) -> str:
    """Return the name in a law's file, of the law itself or of its version before."""
    return name.removesuffix(_BEFORE)


def _before(law: Law) -> Law:
    """Return a version of a law as the one before another."""
    label, about = f"{law.label}, before", f"The version before of {law.label}"
    return replace(law, name=before_of(law.name), label=label, description=about)


def with_before(law: Law, file: OwnFile) -> tuple[dict[str, Law], dict[str, OwnFile]]:
    """Return a new law, and the version before under its name, with the file of each."""
    laws, files = {law.name: law}, {law.name: file}
    if not file.module:  # else it is imported once: it has no other version
        name = before_of(law.name)  # the same until another is saved
        laws[name], files[name] = _before(law), replace(file, version=_BEFORE)
    return laws, files


def _shipped() -> dict[str, Law]:
    """Return the laws of this room by name; the one that adds nothing first."""
    laws: list[Law] = declared_in(__name__, __path__, "LAW")
    for law in laws:
        _fits(law)
    return {law.name: law for law in sorted(laws, key=lambda law: (law.adds, law.name))}


def _own() -> None:
    """Take the laws of one's own that can be taken, and note why others cannot.

    Of files of which a server has taken versions, those are what is read.
    """
    versions = {path: texts for *texts, path in accepted_versions().values()}
    files = list(own_files(os.environ.get(VARIABLE, ""), ENTRY_POINTS))
    there = {str(file.path) for file in files}
    files += [OwnFile(Path(path)) for path in versions if path not in there]
    for file in files:
        texts = versions.get(str(file.path), ())
        if not texts and file.declares("EFFECT"):
            continue  # of `motionlab.effects`
        try:
            _take(file, *texts)
        except DeclarationError as error:
            PROBLEMS.append(error.error.at(str(file.path)))


def _take(file: OwnFile, text: str | None = None, before: str | None = None) -> None:
    """Take the law of a file, whose version before had another text if there is one."""
    law, source = new_law(file, text)
    laws, files = with_before(law, file)
    sources = dict.fromkeys(laws, source)
    former = before_of(law.name)
    if before not in {None, source}:
        laws[former], sources[former] = other_version(former, files[former], before)
    declared_with(OWN | laws)
    OWN.update(laws)
    FILES.update(files)
    SOURCES.update(sources)


SHIPPED = _shipped()
"""The laws of this room by name."""
OWN: dict[str, Law] = {}
"""Laws of one's own by name."""
FILES: dict[str, OwnFile] = {}
"""The file of each; of a version before it is that of the law."""
SOURCES: dict[str, str] = {}
"""The text of the file of each."""
_own()

_DECLARED, PARAMETERS = declared_with(OWN)
"""Every parameter of a law by its name."""

OWN.update(_DECLARED)
LAWS = SHIPPED | OWN
"""Every law by its name."""

REDECLARED: list[Callable[[], None]] = []
"""Called once other laws are in place: they renew what was made of the declarations before."""

__all__ = [
    "FILES",
    "LAWS",
    "OWN",
    "PARAMETERS",
    "PROBLEMS",
    "REDECLARED",
    "SHIPPED",
    "SOURCES",
    "Law",
    "Parameter",
    "base_of",
    "before_of",
    "declared_with",
    "new_law",
    "other_version",
    "put",
    "with_before",
]
