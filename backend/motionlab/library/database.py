"""The database of the index: SQLite beside the data, or PostgreSQL by its address."""

from __future__ import annotations

import contextlib
import glob
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.exc import ArgumentError, DBAPIError

from motionlab.errors import ConfigError, FieldError, StoreError, StoreFull, needs
from motionlab.files import complete_file, private_file
from motionlab.library.postgresql import Deadline, connect_arguments

VERSION = "0008"
"""Version of the tables; migrations/versions has the way there."""

_MAPPED = 1 << 30  # bytes of SQLite's file that are read without a copy
_BUSY_SECONDS = 10.0  # for another process's write to SQLite
_POSTGRESQL = {"postgresql", "postgresql+psycopg"}
_BACKUP, _BACKUPS = ".backup", 3  # copies that stay


class Database:
    """Connections to the index, its tables brought to `VERSION`.

    Raises
    ------
    StoreError
        If it cannot be opened, or is of a newer version of the project.
    """

    def __init__(self, url: str) -> None:
        self._engine = _engine(url)
        self._file = _sqlite_file(self._engine)
        self._alone = self._engine.execution_options(begin="IMMEDIATE")  # of SQLite's writers
        self._sqlite = self._engine.dialect.name == "sqlite"
        self._deadline = None if self._sqlite else Deadline(self._engine)
        self._opened: tuple[int, int] | None = None  # which file, once it is open
        if self._sqlite:
            event.listen(self._engine, "connect", _set_up_sqlite)
            event.listen(self._engine, "begin", _begin_sqlite)
        try:
            if self._file is not None:
                _make_private(self._file)
            with _failures():
                self._migrate()
            self._opened = _identity(self._file)
        except StoreError:
            self.close()
            raise

    def close(self) -> None:
        """Close its connections."""
        self._engine.dispose()

    @contextlib.contextmanager
    def begin(self) -> Iterator[sa.Connection]:
        """Give a connection whose changes are kept together at its end, or not at all.

        Raises
        ------
        StoreError
            If the index cannot be reached; `StoreFull` where its disk is full.
        """
        with self._reached(), self._alone.begin() as connection:
            yield connection

    @contextlib.contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Give a connection that changes nothing.

        Raises
        ------
        StoreError
            If the index cannot be reached.
        """
        with self._reached(), self._engine.connect() as connection:
            yield connection

    @contextlib.contextmanager
    def _reached(self) -> Iterator[None]:
        """Fail in words, and in time."""
        _check_same(self._file, self._opened)
        with _failures(), contextlib.ExitStack() as bounded:
            if self._deadline is not None:
                bounded.enter_context(self._deadline.running())
            yield

    def _migrate(self) -> None:
        """Bring the tables to `VERSION`, one process at a time; quick where they are there."""
        with self._reached(), self._engine.connect() as connection:
            if sa.inspect(connection).has_table("alembic_version"):
                version = connection.execute(
                    sa.text("SELECT version_num FROM alembic_version")
                ).scalar()
                if version == VERSION:
                    return
        from alembic import command  # noqa: PLC0415 - seldom needed, and slow to load
        from alembic.config import Config  # noqa: PLC0415
        from alembic.script import ScriptDirectory  # noqa: PLC0415

        config = Config()
        config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
        with self._alone.begin() as connection:
            if not self._sqlite:
                connection.execute(sa.text("SET LOCAL statement_timeout = 0"))  # it takes its time
                connection.execute(sa.text("SELECT pg_advisory_xact_lock(7212019)"))
            rows = []
            if sa.inspect(connection).has_table("alembic_version"):
                rows = connection.execute(sa.text("SELECT version_num FROM alembic_version")).all()
            version = rows[0][0] if rows else None
            known = {
                script.revision for script in ScriptDirectory.from_config(config).walk_revisions()
            }
            if version is not None and version not in known:
                raise StoreError(
                    f"the index of runs is of version {version}, this motionlab knows {VERSION}: "
                    "use a newer one"
                )
            if self._file is not None and version is not None:
                _back_up(self._file, version, VERSION)
            config.attributes["connection"] = connection
            command.upgrade(config, "head")


def _set_up_sqlite(connection: Any, _: Any) -> None:
    """Let readers and a writer work at once, and enforce foreign keys."""
    connection.isolation_level = None  # transactions begin where SQLAlchemy says, not the module
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout = {int(1e3 * _BUSY_SECONDS)}")
    cursor.execute("PRAGMA journal_mode = WAL")
    cursor.execute("PRAGMA synchronous = NORMAL")  # a run survives a kill; power may take seconds
    cursor.execute("PRAGMA foreign_keys = ON")
    cursor.execute(f"PRAGMA mmap_size = {_MAPPED}")
    cursor.close()


def _begin_sqlite(connection: sa.Connection) -> None:
    kind = connection.get_execution_options().get("begin", "DEFERRED")
    connection.exec_driver_sql(f"BEGIN {kind}")


def _engine(url: str) -> sa.Engine:
    try:
        address = sa.make_url(url)
        arguments = connect_arguments(address) if address.drivername in _POSTGRESQL else {}
        return sa.create_engine(address, pool_pre_ping=True, connect_args=arguments)
    except (ArgumentError, ValueError):  # which may quote it, with its password
        raise _no_address(url) from None
    except ModuleNotFoundError:
        raise StoreError(f"PostgreSQL {needs('psycopg')}") from None


@contextlib.contextmanager
def _failures() -> Iterator[None]:
    try:
        yield
    except DBAPIError as error:
        reason = (str(error.orig).strip().splitlines() or [type(error.orig).__name__])[0]
        if "full" in reason or "No space" in reason:
            raise StoreFull(f"the index of runs cannot be written: {reason}") from error
        raise StoreError(f"the index of runs cannot be reached: {reason}") from error


def check_address(root: Path) -> None:
    """Refuse an address of the index that can never work; nothing is connected or made.

    Raises
    ------
    ConfigError
        If it is none, its folder is missing, or what speaks to the database is not installed.
    """
    try:
        engine = _engine(index_url(root))
    except StoreError as error:
        raise ConfigError(FieldError("MOTIONLAB_DATABASE_URL", str(error))) from None
    file = _sqlite_file(engine)
    engine.dispose()
    if file is None and engine.dialect.name == "sqlite":
        raise _no_address(str(engine.url))
    if file is not None and os.environ.get("MOTIONLAB_DATABASE_URL") and not file.parent.is_dir():
        raise ConfigError(
            FieldError("MOTIONLAB_DATABASE_URL", "its folder does not exist", str(file.parent))
        )


def index_url(root: Path) -> str:
    """Return where the index lies: MOTIONLAB_DATABASE_URL, or a file in the folder of the data."""
    url = os.environ.get("MOTIONLAB_DATABASE_URL") or ""
    if not url:
        return f"sqlite:///{(root / 'runs.sqlite').absolute()}"
    if url.startswith(("postgresql://", "postgres://")):
        return "postgresql+psycopg://" + url.partition("://")[2]
    if url.startswith(("sqlite:///", "postgresql+psycopg://")):
        return url
    raise _no_address(url)


def _no_address(url: str) -> ConfigError:
    return ConfigError(
        FieldError(
            "MOTIONLAB_DATABASE_URL",
            "is no address of a database that can be used",
            url.partition(":")[0],
            "sqlite:///PATH or postgresql://USER@HOST/DATABASE",
        )
    )


def _sqlite_file(engine: sa.Engine) -> Path | None:
    """Return the file of an index, None where it is elsewhere or in memory."""
    place = engine.url.database if engine.dialect.name == "sqlite" else None
    return None if place in {None, "", ":memory:"} else Path(str(place))


def _make_private(file: Path) -> None:
    """Give a new file of SQLite to its owner alone; what it writes beside it is like it."""
    with contextlib.suppress(OSError):  # SQLite says why it cannot be opened
        private_file(file)


def _identity(file: Path | None) -> tuple[int, int] | None:
    """Return device and number of a file, None where there is none."""
    try:
        status = None if file is None else file.stat()
    except OSError:
        return None
    return None if status is None else (status.st_dev, status.st_ino)


def _check_same(file: Path | None, opened: tuple[int, int] | None) -> None:
    """Refuse to use an index whose file has gone: SQLite would go on with what no one else sees.

    Raises
    ------
    StoreError
        If the file is not the one that was opened.
    """
    if opened is None:
        return
    now = _identity(file)
    if now is None:
        raise StoreError("the index of runs has been removed: put its folder back")
    if now != opened:
        raise StoreError("the index of runs has been replaced by another file: start again")


def _back_up(file: Path, version: str, target_version: str) -> None:
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
