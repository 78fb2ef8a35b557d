"""Named trajectories as TOML files in one folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import tomli_w

from motionlab.config.shipped import is_name, parse_text
from motionlab.errors import ConfigError, FieldError, StoreError, StoreFull
from motionlab.store.files import failure, opened, replace
from motionlab.store.index import Index

FILES_MAX = 1000
SIZE_MAX = 200_000
"""Largest file, bytes; a thousand points take about 50 kB."""


_HEAD = 4096  # bytes: what is saved begins with its kind
_KIND = re.compile(r"kind *= *[\"']([a-z-]*)[\"']")


def kind_in(path: Path) -> str:
    """Return the kind of motion of a trajectory's file; empty where the file does not say."""
    if path.stat().st_size > SIZE_MAX:
        return ""
    with opened(path) as file:
        text = file.read(SIZE_MAX + 1)
    found = _KIND.match(text[:_HEAD].decode("utf-8", "replace"))
    if found:
        return found[1]
    try:
        return str(parse_text(text, loc=path.stem, size_max=SIZE_MAX).get("kind", ""))
    except ConfigError:
        return ""


KINDS = Index(kind_in, most=2 * FILES_MAX)
"""Kinds of motion, by file."""


class TrajectoryStore:
    """Trajectories by name.

    Parameters
    ----------
    folder : Path
        Made when the first trajectory is saved.
    files_max : int
        How many there may be.
    """

    def __init__(self, folder: Path, *, files_max: int = FILES_MAX) -> None:
        self._folder = folder
        self._files_max = files_max

    def names(self) -> list[str]:
        """Return the names of saved trajectories, sorted."""
        return sorted(path.stem for path in self._folder.glob("*.toml") if is_name(path.stem))

    def kind(self, name: str) -> str:
        """Return the kind of motion saved under a name; empty where the file does not say.

        Raises
        ------
        FileNotFoundError
            If nothing is saved under the name, perhaps since this instant.
        """
        return KINDS.of(self._path(name))

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
            raise StoreFull(f"{self._files_max} trajectories are saved already; delete one")
        try:
            replace(self._path(name), text)
        except OSError as error:
            raise failure(f"{name} cannot be saved", error) from error

    def delete(self, name: str) -> bool:
        """Delete a saved trajectory; return whether it existed.

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
