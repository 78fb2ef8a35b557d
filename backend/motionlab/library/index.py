"""The index of runs: SQLite beside the data, or PostgreSQL by its URL."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite
from sqlalchemy.exc import ArgumentError, DBAPIError

from motionlab.config.bounds import check_text
from motionlab.errors import ConfigError, FieldError, StoreError, StoreFull, needs
from motionlab.library.index_file import back_up, check_same, identity, make_private, sqlite_file
from motionlab.library.postgresql import Deadline, connect_arguments
from motionlab.library.query import find
from motionlab.library.run import CHANGEABLE, Evicted, Page, Run, RunDetail
from motionlab.library.search import HEADLINE, LIMIT_MAX, Search
from motionlab.library.tables import DOCUMENTS, EVICTIONS, METRICS, RUNS, TAGS, WORDS

VERSION = "0006"
"""Version of the tables; migrations/versions has the way there."""

_MAPPED = 1 << 30  # bytes of SQLite's file that are read without a copy
_EVICTIONS = 1000  # of which the index knows
_BUSY_SECONDS = 10.0  # for another process's write to SQLite
_POSTGRESQL = {"postgresql", "postgresql+psycopg"}
_NARROW = {column.name for column in RUNS.columns}
_ENTRY = set(Run.model_fields) - _NARROW
_RECORD = set(RunDetail.model_fields) - set(Run.model_fields)


class Index:
    """The list of all runs.

    Parameters
    ----------
    url : str
        ``sqlite:///PATH`` or ``postgresql+psycopg://...``.

    Raises
    ------
    StoreError
        If it cannot be opened, or is of a newer version of the project.
    """

    def __init__(self, url: str) -> None:
        self._engine = _engine(url)
        self._file = sqlite_file(self._engine)
        self._alone = self._engine.execution_options(begin="IMMEDIATE")  # of SQLite's writers
        self._sqlite = self._engine.dialect.name == "sqlite"
        self._deadline = None if self._sqlite else Deadline(self._engine)
        self._opened: tuple[int, int] | None = None  # which file, once it is open
        if self._sqlite:
            event.listen(self._engine, "connect", _set_up_sqlite)
            event.listen(self._engine, "begin", _begin_sqlite)
        try:
            if self._file is not None:
                make_private(self._file)
            with _failures():
                self._migrate()
            self._opened = identity(self._file)
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
    def _reached(self) -> Iterator[None]:
        """Fail in words, and in time."""
        check_same(self._file, self._opened)
        with _failures(), contextlib.ExitStack() as bounded:
            if self._deadline is not None:
                bounded.enter_context(self._deadline.running())
            yield

    def put(self, *runs: RunDetail) -> None:
        """Insert runs, or replace what is known of them."""
        with self._reached(), self._engine.begin() as connection:
            self._put(connection, *runs)

    def finish(self, run: RunDetail) -> RunDetail:
        """Put a run that has ended, and return it with what a person has changed of it by now."""
        with self._reached(), self._alone.begin() as connection:
            known = _read(connection, run.id, lock=not self._sqlite)
            if known is not None:
                by_hand = CHANGEABLE - {"differences"}
                run = run.model_copy(update={name: getattr(known, name) for name in by_hand})
            self._put(connection, run)
        return run

    def _put(self, connection: sa.Connection, *runs: RunDetail) -> None:
        documents = [run.model_dump(mode="json") for run in runs]
        check_text(documents, loc="run")
        rows = [{name: each[name] for name in _NARROW} for each in documents]
        self._upsert(connection, RUNS, rows)
        self._upsert(connection, WORDS, [{"run": run.id, "words": _words(run)} for run in runs])
        self._upsert(
            connection,
            DOCUMENTS,
            [
                {
                    "run": each["id"],
                    "entry": {name: each[name] for name in _ENTRY},
                    "record": {name: each[name] for name in _RECORD},
                }
                for each in documents
            ],
        )
        _replace(connection, TAGS, {run.id: [{"tag": tag} for tag in run.tags] for run in runs})
        _replace(
            connection,
            METRICS,
            {
                run.id: [
                    {"metric": name, "value": value}
                    for name, value in run.metrics.items()
                    if name.rpartition(".")[2] in HEADLINE.values()
                ]
                for run in runs
            },
        )

    def get(self, run_id: str) -> RunDetail | None:
        """Return a run, also a deleted one; None if there is none of that identifier."""
        with self._reached(), self._engine.connect() as connection:
            return _read(connection, run_id)

    def named(self, name: str) -> list[str]:
        """Return the runs of that very name, two at most; no deleted ones."""
        query = sa.select(RUNS.c.id).where(RUNS.c.name == name, RUNS.c.deleted.is_(None))
        with self._reached(), self._engine.connect() as connection:
            return list(connection.execute(query.limit(2)).scalars())

    def page(
        self,
        search: Search,
        *,
        sort: str = "-created",
        limit: int = 50,
        cursor: str | None = None,
    ) -> Page:
        """Return a page of the runs that a search finds.

        Parameters
        ----------
        search : Search
            What is looked for.
        sort : str
            One of `SORTS`, or a metric such as ``B.x.max``; with ``-`` in front the other way.
            Runs without the metric come last.
        limit : int
            Runs on the page, at most `LIMIT_MAX`.
        cursor : str, optional
            Of the page before; the first page when left out.

        Raises
        ------
        ConfigError
            If it cannot be sorted that way, or the cursor is none.
        """
        with self._reached(), self._engine.connect() as connection:
            found = find(connection, search, sort, limit, cursor)
            rows = connection.execute(
                sa.select(RUNS, DOCUMENTS.c.entry).join(DOCUMENTS).where(RUNS.c.id.in_(found.ids))
            ).mappings()
            runs = {row["id"]: Run(**_narrow(row), **row["entry"]) for row in rows}
        shown = [runs[each] for each in found.ids if each in runs]
        return Page(runs=shown, total=found.total, cursor=found.cursor)

    def change(self, run_id: str, changes: Mapping[str, Any]) -> RunDetail | None:
        """Change `CHANGEABLE` fields of a run; None if there is none of that identifier."""
        check_text(
            {name: changes[name] for name in ("name", "note", "tags") if name in changes}, loc="run"
        )
        with self._reached(), self._alone.begin() as connection:
            run = _read(connection, run_id, lock=not self._sqlite)
            if run is None:
                return None
            run = run.model_copy(update={name: changes[name] for name in CHANGEABLE & set(changes)})
            row = {name: getattr(run, name) for name in ("name", "pinned", "kept", "deleted")}
            entry = run.model_dump(mode="json", include=_ENTRY)
            connection.execute(sa.update(RUNS).where(RUNS.c.id == run_id).values(**row))
            connection.execute(
                sa.update(WORDS).where(WORDS.c.run == run_id).values(words=_words(run))
            )
            connection.execute(
                sa.update(DOCUMENTS).where(DOCUMENTS.c.run == run_id).values(entry=entry)
            )
            if "tags" in changes:
                _replace(connection, TAGS, {run_id: [{"tag": tag} for tag in run.tags]})
            return run

    def condemn(self, run_id: str, deleted: float | None = None) -> bool:
        """Take a run out of every list for good, its files to be deleted next.

        Parameters
        ----------
        run_id : str
            Which.
        deleted : float, optional
            When it must have been deleted, as `deleted` lists it; when left out it is evicted,
            which takes no run that a person keeps.

        Returns
        -------
        bool
            Whether that was done; not if it has been restored, kept, pinned or dropped meanwhile.
        """
        which = _evictable() if deleted is None else RUNS.c.deleted == deleted
        change = sa.update(RUNS).where(RUNS.c.id == run_id, which).values(deleted=0.0)
        with self._reached(), self._engine.begin() as connection:
            return bool(connection.execute(change).rowcount)

    def drop(self, run_id: str) -> None:
        """Forget a run."""
        with self._reached(), self._engine.begin() as connection:
            connection.execute(sa.delete(RUNS).where(RUNS.c.id == run_id))

    def deleted(self) -> list[tuple[str, float]]:
        """Return deleted runs and when they were deleted; 0 where it is for good."""
        query = sa.select(RUNS.c.id, RUNS.c.deleted).where(RUNS.c.deleted.is_not(None))
        with self._reached(), self._engine.connect() as connection:
            return [(row.id, row.deleted) for row in connection.execute(query)]

    def recording(self) -> list[str]:
        """Return the runs that are being recorded, or were when their server was killed."""
        query = sa.select(RUNS.c.id).where(RUNS.c.state == "recording")
        with self._reached(), self._engine.connect() as connection:
            return list(connection.scalars(query))

    def evictable(self) -> list[tuple[str, int]]:
        """Return identifier and size of what may be evicted: deleted ones, then the oldest.

        The oldest are those that came into the index first, whatever the clock has said.
        """
        query = (
            sa.select(RUNS.c.id, RUNS.c.size)
            .join(WORDS)
            .where(_evictable(), RUNS.c.state != "recording")
            .order_by(RUNS.c.deleted.is_(None), WORDS.c.number)
        )
        with self._reached(), self._engine.connect() as connection:
            return [(row.id, row.size) for row in connection.execute(query)]

    def note_eviction(self, run: Run) -> None:
        """Note that a run was evicted; the latest `_EVICTIONS` are known."""
        about = {"run": run.id, "name": run.name, "created": run.created, "size": run.size}
        with self._reached(), self._engine.begin() as connection:
            connection.execute(sa.insert(EVICTIONS), [about | {"evicted": time.time()}])
            newest = sa.select(sa.func.max(EVICTIONS.c.number)).scalar_subquery()
            old = sa.delete(EVICTIONS).where(EVICTIONS.c.number <= newest - _EVICTIONS)
            connection.execute(old)

    def evictions(self, limit: int) -> list[Evicted]:
        """Return the latest evictions, the newest first."""
        query = sa.select(EVICTIONS).order_by(EVICTIONS.c.number.desc()).limit(limit)
        with self._reached(), self._engine.connect() as connection:
            return [
                Evicted.model_validate(dict(row)) for row in connection.execute(query).mappings()
            ]

    def sizes(self) -> tuple[int, int]:
        """Return the bytes that runs take, also deleted ones, and of these the ones that stay."""
        stays = sa.not_(_evictable())
        query = sa.select(
            sa.func.coalesce(sa.func.sum(RUNS.c.size), 0),
            sa.func.coalesce(sa.func.sum(sa.case((stays, RUNS.c.size), else_=0)), 0),
        )
        with self._reached(), self._engine.connect() as connection:
            held, kept = connection.execute(query).one()
        return int(held), int(kept)

    def totals(self) -> dict[str, Any]:
        """Return how many runs there are, their bytes, those pinned; counts by tag and scenario."""
        alive = RUNS.c.deleted.is_(None)
        pinned, kept = (
            sa.func.coalesce(sa.func.sum(sa.case((which, RUNS.c.size), else_=0)), 0)
            for which in (RUNS.c.pinned, sa.or_(RUNS.c.pinned, RUNS.c.kept))
        )
        sums = sa.select(
            sa.func.count().label("runs"),
            sa.func.coalesce(sa.func.sum(RUNS.c.size), 0).label("size"),
            pinned.label("pinned_size"),
            kept.label("kept_size"),
        ).where(alive)
        tags = (
            sa.select(TAGS.c.tag, sa.func.count())
            .join(RUNS)
            .where(alive)
            .group_by(TAGS.c.tag)
            .order_by(sa.func.count().desc(), TAGS.c.tag)
            .limit(LIMIT_MAX)
        )
        with self._reached(), self._engine.connect() as connection:
            numbers = connection.execute(sums).mappings().one()
            result: dict[str, Any] = {name: int(value) for name, value in numbers.items()}
            result["tags"] = {tag: count for tag, count in connection.execute(tags)}
            for name in ("scenario", "kind", "state"):
                column = RUNS.c[name]
                counts = (
                    sa.select(column, sa.func.count())
                    .where(alive)
                    .group_by(column)
                    .order_by(sa.func.count().desc(), column)
                    .limit(LIMIT_MAX)
                )
                result[f"{name}s"] = {value: count for value, count in connection.execute(counts)}
        return result

    def _upsert(
        self, connection: sa.Connection, table: sa.Table, rows: list[dict[str, Any]]
    ) -> None:
        key = "id" if table is RUNS else "run"
        insert = (insert_sqlite if self._sqlite else insert_postgresql)(table)
        others = {name: insert.excluded[name] for name in rows[0] if name != key}
        connection.execute(insert.on_conflict_do_update(index_elements=[key], set_=others), rows)

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
                back_up(self._file, version, VERSION)
            config.attributes["connection"] = connection
            command.upgrade(config, "head")


def _read(connection: sa.Connection, run_id: str, *, lock: bool = False) -> RunDetail | None:
    query = (
        sa.select(RUNS, DOCUMENTS.c.entry, DOCUMENTS.c.record)
        .join(DOCUMENTS)
        .where(RUNS.c.id == run_id)
    )
    if lock:
        query = query.with_for_update(of=RUNS)
    row = connection.execute(query).mappings().one_or_none()
    return None if row is None else RunDetail(**_narrow(row), **row["entry"], **row["record"])


def _evictable() -> sa.ColumnElement[bool]:
    """Return the condition of runs without a pin that no person keeps, or one has deleted."""
    return sa.and_(
        sa.not_(RUNS.c.pinned), sa.or_(sa.not_(RUNS.c.kept), RUNS.c.deleted.is_not(None))
    )


def _replace(
    connection: sa.Connection,
    table: sa.Table,
    rows: Mapping[str, Sequence[Mapping[str, Any]]],
) -> None:
    """Put rows, by run, in place of those that a table has of these runs."""
    gone = sa.delete(table).where(table.c.run == sa.bindparam("of"))
    connection.execute(gone, [{"of": run_id} for run_id in rows])
    if new := [{"run": run_id, **row} for run_id, some in rows.items() for row in some]:
        connection.execute(sa.insert(table), new)


def _narrow(row: sa.RowMapping) -> dict[str, Any]:
    return {name: row[name] for name in _NARROW}


def _words(run: Run) -> str:
    """Return everything of a run that a word can be found in, in lower case."""
    changes = (f"{each.path} {each.value}" for each in run.differences)
    parts = (run.id, run.name, run.scenario, run.note, *run.tags, *run.labels.values(), *changes)
    return "\n".join(parts).lower()


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
    file = sqlite_file(engine)
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
