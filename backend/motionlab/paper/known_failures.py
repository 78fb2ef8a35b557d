"""Known failures: rows that do not hold, each with the reason, from known_failures.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from motionlab.errors import StoreError

FILE = Path(__file__).with_name("known_failures.toml")
"""Table of identifiers and reasons, part of the package; docs/known-failures.md shows it."""


def known_failures(path: Path | None = None) -> Mapping[str, str]:
    """Return the reason why each known failure fails, by the row's identifier.

    Parameters
    ----------
    path : Path, optional
        Another file than the project's.

    Raises
    ------
    StoreError
        If the file cannot be read, is not TOML, or holds anything but texts.
    """
    path = FILE if path is None else path
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # not UTF-8, not TOML, or a row that comes twice
        raise StoreError(f"{path} is not valid TOML: {error}") from None
    for row, reason in found.items():
        if not isinstance(reason, str):
            raise StoreError(f"{path}: {row} needs a reason in quotes")
    return found
