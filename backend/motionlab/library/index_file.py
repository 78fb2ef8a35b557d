"""The file of an index in SQLite: whose it is, and copies from before it was migrated."""

from __future__ import annotations

import contextlib
import glob
import sqlite3
from pathlib import Path

import sqlalchemy as sa

from motionlab.errors import StoreError
from motionlab.files import complete_file, private_file

_BACKUP, _BACKUPS = ".backup", 3  # copies that stay


def sqlite_file(engine: sa.Engine) -> Path | None:
    """Return the file of an index, None where it is elsewhere or in memory."""
    place = engine.url.database if engine.dialect.name == "sqlite" else None
    return None if place in {None, "", ":memory:"} else Path(str(place))


def make_private(file: Path) -> None:
    """Give a new file of SQLite to its owner alone; what it writes beside it is like it."""
    with contextlib.suppress(OSError):  # SQLite says why it cannot be opened
        private_file(file)


def identity(file: Path | None) -> tuple[int, int] | None:
    """Return device and number of a file, None where there is none."""
    try:
        status = None if file is None else file.stat()
    except OSError:
        return None
    return None if status is None else (status.st_dev, status.st_ino)


def check_same(file: Path | None, opened: tuple[int, int] | None) -> None:
    """Refuse to use an index whose file has gone: SQLite would go on with what no one else sees.

    Raises
    ------
    StoreError
        If the file is not the one that was opened.
    """
    if opened is None:
        return
    now = identity(file)
    if now is None:
        raise StoreError("the index of runs has been removed: put its folder back")
    if now != opened:
        raise StoreError("the index of runs has been replaced by another file: start again")


def back_up(file: Path, version: str, target_version: str) -> None:
    """Copy an index beside it before it is migrated; the latest `_BACKUPS` copies are kept.

    Raises
    ------
    StoreError
        If it cannot be copied: it is not migrated then.
    """
    target = file.with_name(f"{file.name}.{version}{_BACKUP}")
    try:
        # The transaction that is about to migrate has read, and not yet written.
        with (
            complete_file(str(target), mode=0o600) as part,
            contextlib.closing(sqlite3.connect(part)) as copy,
            contextlib.closing(sqlite3.connect(file)) as source,
        ):
            source.backup(copy)
        copies = sorted(file.parent.glob(f"{glob.escape(file.name)}.*{_BACKUP}"))
        for old in copies[:-_BACKUPS]:
            old.unlink(missing_ok=True)
    except (OSError, sqlite3.Error, StoreError) as error:
        raise StoreError(
            f"the index of runs is not brought to version {target_version}, because it cannot be "
            f"copied first: {error}"
        ) from error
