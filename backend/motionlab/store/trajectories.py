"""Named trajectories as TOML files in one folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomli_w

from motionlab.config.shipped import is_name, parse
from motionlab.errors import ConfigError, StoreError, StoreFull
from motionlab.store.files import failure, replace

FILES_MAX = 1000
SIZE_MAX = 200_000
"""Largest file, bytes; a thousand points take about 50 kB."""


class TrajectoryStore:
    """Trajectories by name.

    Parameters
    ----------
    folder : Path
        Where they lie; made when the first is saved.
    files_max : int
        How many there may be.
    """

    def __init__(self, folder: Path, *, files_max: int = FILES_MAX) -> None:
        self._folder = folder
        self._files_max = files_max

    def names(self) -> list[str]:
        """Return the names of what is saved, sorted."""
        return sorted(path.stem for path in self._folder.glob("*.toml") if is_name(path.stem))

    def has(self, name: str) -> bool:
        """Return whether something is saved under a name."""
        return is_name(name) and self._path(name).is_file()

    def read(self, name: str) -> dict[str, Any]:
        """Return the tables saved under a name.

        Raises
        ------
        ConfigError
            If the file cannot be read or is not TOML.
        FileNotFoundError
            If nothing is saved under the name, perhaps since this instant.
        """
        path = self._path(name)
        try:
            return parse(path)
        except ConfigError:
            if path.is_file():
                raise
            raise FileNotFoundError(path) from None

    def write(self, name: str, tables: dict[str, Any]) -> None:
        """Save tables under a name, in place of what was there; a failure leaves that untouched.

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
            raise StoreFull(f"{self._files_max} trajectories are saved already; delete one")
        try:
            replace(self._path(name), text)
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
            self._path(name).unlink()
        except FileNotFoundError:
            return False
        except OSError as error:
            raise failure(f"{name} cannot be deleted", error) from error
        return True

    def _path(self, name: str) -> Path:
        if not is_name(name):
            raise StoreError(f"{name!r} is not a name")
        return self._folder / f"{name}.toml"
