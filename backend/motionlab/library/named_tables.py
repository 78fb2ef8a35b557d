"""Named tables as TOML files in one folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomli_w

from motionlab.config.shipped import is_name, parse_text
from motionlab.errors import ConfigError, FieldError, StoreError, StoreFull
from motionlab.files import failure, opened, replace

FILES_MAX = 1000
SIZE_MAX = 600_000
"""Largest file, bytes; a trajectory of a thousand points takes about 60 kB."""


class NamedTables:
    """Tables by name, each a TOML file.

    Parameters
    ----------
    folder : Path
        Made when the first one is saved.
    what : str
        What they are, in the plural, for errors.
    files_max : int
        How many there may be.
    """

    def __init__(self, folder: Path, what: str, *, files_max: int = FILES_MAX) -> None:
        self._folder = folder
        self._what = what
        self._files_max = files_max

    def names(self) -> list[str]:
        """Return the names under which something is saved, sorted."""
        return sorted(path.stem for path in self._folder.glob("*.toml") if is_name(path.stem))

    def has(self, name: str) -> bool:
        """Return whether something is saved under a name."""
        return is_name(name) and self.path(name).is_file()

    def read(self, name: str) -> dict[str, Any]:
        """Return the tables saved under a name.

        Raises
        ------
        ConfigError
            If the file cannot be read or is not TOML.
        FileNotFoundError
            If nothing is saved under the name, perhaps since this instant.
        """
        path = self.path(name)
        try:
            with opened(path) as file:
                text = file.read(SIZE_MAX + 1)
        except OSError as error:
            if not path.is_file():
                raise FileNotFoundError(path) from None
            message = f"cannot be read: {error.strerror or error}"
            raise ConfigError(FieldError(name, message)) from None
        return parse_text(text, loc=name, size_max=SIZE_MAX)

    def write(self, name: str, tables: dict[str, Any]) -> None:
        """Save or replace tables under a name; a failure leaves the old ones untouched.

        Parameters
        ----------
        name : str
            ``[a-z0-9-]{1,64}``.
        tables : dict
            What TOML can hold.

        Raises
        ------
        StoreFull
            If there are too many, it is too large, or the disk is full.
        StoreError
            If the folder cannot be written.
        """
        text = tomli_w.dumps(tables).encode()
        if len(text) > SIZE_MAX:
            raise StoreFull(f"{name} takes {len(text)} bytes; {SIZE_MAX} are the most")
        if not self.has(name) and len(self.names()) >= self._files_max:
            raise StoreFull(f"{self._files_max} {self._what} are saved already; delete one")
        try:
            replace(self.path(name), text)
        except OSError as error:
            raise failure(f"{name} cannot be saved", error) from error

    def delete(self, name: str) -> bool:
        """Delete what is saved under a name; return whether there was anything.

        Raises
        ------
        StoreError
            If the folder cannot be written.
        """
        try:
            self.path(name).unlink()
        except FileNotFoundError:
            return False
        except OSError as error:
            raise failure(f"{name} cannot be deleted", error) from error
        return True

    def path(self, name: str) -> Path:
        """Return the file of a name.

        Raises
        ------
        StoreError
            If it is none.
        """
        if not is_name(name):
            raise StoreError(f"{name!r} is not a name")
        return self._folder / f"{name}.toml"
