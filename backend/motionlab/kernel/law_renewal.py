"""Other versions of laws of one's own, and new laws, put in place while lanes have them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.law_calls import code_of, compiled_law, law_number, put_laws
from motionlab.kernel.layout import LAW_OF_STATE, LAW_STATE, LawState
from motionlab.laws import (
    FILES,
    OWN,
    SOURCES,
    Law,
    before_of,
    declared_with,
    new_law,
    other_version,
    put,
    with_before,
)
from motionlab.own_files import OwnFile

Array = NDArray[np.float64]

_STATES = len(LawState._fields)


class LawVersion(NamedTuple):
    """A version of a law's file that is to run.

    Attributes
    ----------
    name : str
        Of the law.
    text : str
        The version.
    before : str
        Version that is to run as the one before.
    file : OwnFile
        The file.
    """

    name: str
    text: str
    before: str
    file: OwnFile


class Renewal:
    """Other versions of laws' files, or new laws, compiled; and what they replace.

    Parameters
    ----------
    versions : iterable of LawVersion
        Versions that are taken at once.
    compiles : bool
        Whether to compile them now, rather than when a lane first has them.

    Raises
    ------
    DeclarationError
        If a version cannot be used as it is declared, beside the other laws.
    """

    def __init__(self, versions: Iterable[LawVersion], *, compiles: bool = True) -> None:
        self._former = (dict(OWN), dict(SOURCES), dict(FILES))
        self._laws, self._sources, self._files = dict(OWN), dict(SOURCES), dict(FILES)
        self._code: dict[str, Any] = {}
        self._compiles = compiles
        for each in versions:
            if each.name not in OWN:
                law, _ = new_law(each.file, each.text)
                self._files |= with_before(law, each.file)[1]
            self._read(each)
        self._former_code = {name: code_of(name) for name in self._code}
        self._laws, _ = declared_with(self._laws)
        self.names = frozenset(self._code)

    def _read(self, version: LawVersion) -> None:
        name, text, before, _ = version
        law, _ = other_version(name, self._files[name], text)
        code = self._set(name, law, text, None)
        if (former := before_of(name)) not in self._files:
            return
        present = code_of(former)
        if before == text:
            there = code
        elif before == SOURCES.get(name):
            there = code_of(name)
        else:
            there = present if before == SOURCES.get(former) else None
        law, _ = other_version(former, self._files[former], before)
        self._set(former, law, before, there, needed=present is not None)

    def _set(self, name: str, law: Law, text: str, code: Any, *, needed: bool = True) -> Any:
        """Have a law run under a name, and return its code, which is compiled if it is needed."""
        if code is None and needed and self._compiles:
            code = compiled_law(law, text)
        self._laws[name], self._sources[name], self._code[name] = law, text, code
        return code

    @property
    def redeclares(self) -> bool:
        """Whether configs, or the numbers of lanes that they make, are others with it."""
        former, *_ = self._former
        return any(
            law.lane is not None or _declaration(law) != _declaration(former.get(name))
            for name, law in self._laws.items()
            if name not in former or law is not former[name]
        )

    def take(self) -> None:
        """Put the versions in place: lanes that have them call them from now on."""
        put_laws(self._laws, self._code)
        put(self._laws, self._sources, self._files)

    def take_back(self) -> None:
        """Put in place what there was before; a new law is gone but for its number."""
        laws, sources, files = self._former
        put_laws(laws, {name: code for name, code in self._former_code.items() if name in laws})
        put(laws, sources, files)

    def carry(self, state: Array) -> None:
        """Give states of the former versions to these: numbers of the same name, or zero.

        What a version resets begins at zero.

        Parameters
        ----------
        state : ndarray, shape (..., STATE_ROWS, lanes)
            State of lanes, of which those that have these laws are concerned.
        """
        former, *_ = self._former
        for name in self.names & former.keys():
            law, fields = self._laws[name], former[name].State._fields
            own = (state[..., LAW_OF_STATE, :] == law_number(name))[..., None, :]
            rows = state[..., LAW_STATE : LAW_STATE + _STATES, :]
            old = rows.copy()
            new = np.zeros_like(old)
            for row, field in enumerate(law.State._fields):
                if field in fields and field not in law.resets:
                    new[..., row, :] = old[..., fields.index(field), :]
            rows[...] = np.where(own, new, old)


def _declaration(law: Law | None) -> Any:
    """Return what configs and lanes are made of."""
    if law is None:
        return None
    named = (law.label, law.description, law.parameters, law.adds, law.limits)
    return *named, law.Parameters._fields, law.State._fields
