"""Documents that users keep by name, and those of them that are TOML files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, Generic, TypeVar

import tomli_w

from motionlab.config.named_configs import (
    Kind,
    config_root,
    data_root,
    is_name,
    names,
    own_names,
    parse_text,
)
from motionlab.errors import ConfigError, FieldError, Shipped, StoreError, StoreFull, Unknown
from motionlab.files import failure, opened, replace

COUNT_MAX = 1000
SIZE_MAX = 600_000
"""Largest file, bytes; a trajectory of a thousand points takes about 60 kB."""

Entry = TypeVar("Entry")
Document = TypeVar("Document")


class NamedDocuments(ABC, Generic[Entry, Document]):
    """Documents of one kind, each under a name; errors call them by noun and plural."""

    def __init__(self, noun: str, plural: str, count_max: int = COUNT_MAX) -> None:
        self.noun, self._plural, self._count_max = noun, plural, count_max

    @abstractmethod
    def all(self) -> list[Entry]:
        """Return what a list shows of each document, in its order."""

    @abstractmethod
    def get(self, name: str) -> Document:
        """Return a document.

        Raises
        ------
        Unknown
            If there is none of that name.
        ConfigError
            If its file is damaged.
        """

    def delete(self, name: str) -> None:
        """Delete a document.

        Raises
        ------
        Unknown
            If there is none of that name.
        Shipped
            If it ships with the project.
        StoreError
            If it cannot be deleted.
        """
        if not self._removed(name):
            raise self.unknown(name)

    def unknown(self, name: str) -> Unknown:
        """Return the error of a name without a document."""
        return Unknown(f"no {self.noun} {name!r}")

    @abstractmethod
    def _removed(self, name: str) -> bool:
        """Delete a document; return whether there was one."""

    def _check_room(self, count: int) -> None:
        if count >= self._count_max:
            raise StoreFull(f"{self._count_max} {self._plural} are saved already; delete one")


class TomlDocuments(NamedDocuments[Entry, Document]):
    """Documents in TOML files: those that ship, and those in ``MOTIONLAB_DATA/KIND``."""

    def __init__(self, kind: Kind, noun: str, count_max: int = COUNT_MAX) -> None:
        super().__init__(noun, kind, count_max)
        self.kind: Kind = kind

    def all(self) -> list[Entry]:
        """Return the entries of those that ship, then of one's own, each by name."""
        shipped = [self.entry(name, shipped=True) for name in names(self.kind)]
        own = [self.entry(name, shipped=False) for name in own_names(self.kind)]
        return [entry for entry in shipped + own if entry is not None]

    @abstractmethod
    def entry(self, name: str, *, shipped: bool) -> Entry | None:
        """Return what a list shows of a document; None where its file has gone."""

    def is_shipped(self, name: str) -> bool:
        """Return whether the document of a name ships with the project."""
        return name in names(self.kind)

    def path(self, name: str) -> Path:
        """Return the file of a name."""
        if not is_name(name):
            raise StoreError(f"{name!r} is not a name")
        root = config_root() if self.is_shipped(name) else data_root()
        return root / self.kind / f"{name}.toml"

    def read(self, name: str) -> dict[str, Any]:
        """Return the tables in the file of a name; raises as `get` does."""
        path = self.path(name)
        try:
            with opened(path) as file:
                text = file.read(SIZE_MAX + 1)
        except OSError as error:
            if not path.is_file():
                raise self.unknown(name) from None
            text = f"cannot be read: {error.strerror or error}"
            raise ConfigError(FieldError(name, text)) from None
        return parse_text(text, loc=name, size_max=SIZE_MAX)

    def write(self, name: str, tables: dict[str, Any]) -> None:
        """Save or replace tables under a name; a failure leaves the old ones untouched.

        Raises
        ------
        Shipped
            If the document of that name ships with the project.
        StoreFull
            If there are too many, it is too large, or the disk is full.
        StoreError
            If the folder cannot be written.
        """
        self.check_own(name)
        path, text = self.path(name), tomli_w.dumps(tables).encode()
        if len(text) > SIZE_MAX:
            raise StoreFull(f"{name} takes {len(text)} bytes; {SIZE_MAX} are the most")
        if not path.is_file():
            self._check_room(len(own_names(self.kind)))
        try:
            replace(path, text)
        except OSError as error:
            raise failure(f"{name} cannot be saved", error) from error

    def check_own(self, name: str) -> None:
        """Refuse with `Shipped` to change a document that ships."""
        if self.is_shipped(name):
            raise Shipped(f"{name!r} ships with the project and cannot be changed")

    def _removed(self, name: str) -> bool:
        self.check_own(name)
        return removed_file(self.path(name))


def removed_file(path: Path) -> bool:
    """Delete the file of a document; return whether there was one."""
    try:
        path.unlink()
    except FileNotFoundError:
        return False
    except OSError as error:
        raise failure(f"{path.stem} cannot be deleted", error) from error
    return True
