"""Known failures: docs/known-failures.md is their one list, and the page that people read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from motionlab.errors import StoreError

_ROW = re.compile(r"^\| `(?P<id>[a-z0-9.-]+)` \| (?P<reason>.+?) \|$", re.MULTILINE)


def page() -> Path:
    """Return the page of known failures: the package's, or the checkout's."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "docs" / "known-failures.md"
    return installed if installed.is_file() else package.parent.parent / "docs" / installed.name


def known_failures(path: Path | None = None) -> Mapping[str, str]:
    """Return the reason why each known failure fails, by the row's identifier.

    A line of the page's table is an identifier in backquotes and its reason.

    Parameters
    ----------
    path : Path, optional
        Another page than the project's.

    Raises
    ------
    StoreError
        If the page cannot be read or names a row twice.
    """
    path = page() if path is None else path
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror or error}") from None
    found: dict[str, str] = {}
    for row in _ROW.finditer(text):
        if row["id"] in found:
            raise StoreError(f"{path} names {row['id']} twice")
        found[row["id"]] = row["reason"].strip()
    return found
