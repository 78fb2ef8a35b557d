"""The index of runs: which there are, what is known of each, what goes first."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.postgresql import insert as insert_postgresql
from sqlalchemy.dialects.sqlite import insert as insert_sqlite

from motionlab.config.bounds import check_text
from motionlab.library.database import Database
from motionlab.library.histogram import RunHistogram, histogram
from motionlab.library.query import find
from motionlab.library.run import CHANGEABLE, Evicted, Page, Run, RunDetail
from motionlab.library.search import HEADLINE, LIMIT_MAX, Search, metric_name
from motionlab.library.tables import DOCUMENTS, EVICTIONS, MARGINS_DUE, METRICS, RUNS, TAGS, WORDS

_EVICTIONS = 1000  # of which the index knows
_MARGINS_AT_ONCE = 100  # runs, for a second or two
_NARROW = {column.name for column in RUNS.columns} - {"number"}
_ENTRY = set(Run.model_fields) - _NARROW
_RECORD = set(RunDetail.model_fields) - set(Run.model_fields)


class Index(Database):
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

    def put(self, *runs: RunDetail) -> None:
        """Insert runs, or replace what is known of them."""
        with self.begin() as connection:
            self._put(connection, *runs)

    def finish(self, run: RunDetail) -> RunDetail:
        """Put a run that has ended, and return it with what a person has changed of it by now."""
        with self.begin() as connection:
            known = _read(connection, run.id, lock=not self._sqlite)
            if known is not None:
                by_hand = CHANGEABLE - {"differences"} - (set() if known.named else {"name"})
                run = run.model_copy(update={name: getattr(known, name) for name in by_hand})
            self._put(connection, run)
        return run

    def _put(self, connection: sa.Connection, *runs: RunDetail) -> None:
        documents = [run.model_dump(mode="json") for run in runs]
        check_text(documents, loc="run")
        rows = [{name: each[name] for name in _NARROW} for each in documents]
        self._upsert(connection, RUNS, rows)
        of_these = RUNS.c.id.in_([run.id for run in runs])
        numbered = sa.select(RUNS.c.id, RUNS.c.number).where(of_these)
        numbers = {row.id: row.number for row in connection.execute(numbered)}
        words = [{"run": numbers[run.id], "words": _words(run)} for run in runs]
        self._upsert(connection, WORDS, words)
        self._upsert(
            connection,
            DOCUMENTS,
            [
                {
                    "run": numbers[each["id"]],
                    "entry": {name: each[name] for name in _ENTRY},
                    "record": {name: each[name] for name in _RECORD},
                }
                for each in documents
            ],
        )
        tags = {numbers[run.id]: [{"tag": tag} for tag in run.tags] for run in runs}
        _replace(connection, TAGS, tags)
        _replace(
            connection,
            METRICS,
            {
                numbers[run.id]: [
                    {"metric": name, "value": value}
                    for name, value in run.metrics.items()
                    if name.rpartition(".")[2] in HEADLINE.values()
                ]
                for run in runs
            },
        )

    def get(self, run_id: str) -> RunDetail | None:
        """Return a run, also a deleted one; None if there is none of that identifier."""
        with self.reading() as connection:
            return _read(connection, run_id)

    def named(self, name: str) -> list[str]:
        """Return the runs of that very name, two at most; no deleted ones."""
        query = sa.select(RUNS.c.id).where(RUNS.c.name == name, RUNS.c.deleted.is_(None))
        with self.reading() as connection:
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
        with self.reading() as connection:
            hits = find(connection, search, sort, limit, cursor)
            rows = connection.execute(
                sa.select(RUNS, DOCUMENTS.c.entry)
                .join(DOCUMENTS)
                .where(RUNS.c.number.in_(hits.numbers))
            ).mappings()
            runs = {row["number"]: Run(**_narrow(row), **row["entry"]) for row in rows}
        shown = [runs[number] for number in hits.numbers if number in runs]
        return Page(runs=shown, total=hits.total, cursor=hits.cursor)

    def histogram(self, search: Search, metric: str) -> RunHistogram:
        """Return how a metric, such as ``B.x.max``, is spread over what a search finds.

        Raises
        ------
        ConfigError
            If there is no such metric.
        """
        full = metric_name(metric, "metric")
        with self.reading() as connection:
            return histogram(connection, search, full)

    def change(self, run_id: str, changes: Mapping[str, Any]) -> RunDetail | None:
        """Change `CHANGEABLE` fields of a run; None if there is none of that identifier."""
        check_text(
            {name: changes[name] for name in ("name", "note", "tags") if name in changes}, loc="run"
        )
        with self.begin() as connection:
            run = _read(connection, run_id, lock=not self._sqlite)
            if run is None:
                return None
            run = run.model_copy(update={name: changes[name] for name in CHANGEABLE & set(changes)})
            row = {name: getattr(run, name) for name in ("name", "pinned", "kept", "deleted")}
            entry = run.model_dump(mode="json", include=_ENTRY)
            connection.execute(sa.update(RUNS).where(RUNS.c.id == run_id).values(**row))
            number = connection.scalars(sa.select(RUNS.c.number).where(RUNS.c.id == run_id)).one()
            connection.execute(
                sa.update(WORDS).where(WORDS.c.run == number).values(words=_words(run))
            )
            connection.execute(
                sa.update(DOCUMENTS).where(DOCUMENTS.c.run == number).values(entry=entry)
            )
            if "tags" in changes:
                _replace(connection, TAGS, {number: [{"tag": tag} for tag in run.tags]})
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
        with self.begin() as connection:
            return bool(connection.execute(change).rowcount)

    def drop(self, run_id: str) -> None:
        """Forget a run."""
        with self.begin() as connection:
            connection.execute(sa.delete(RUNS).where(RUNS.c.id == run_id))

    def deleted(self) -> list[tuple[str, float]]:
        """Return deleted runs and when they were deleted; 0 where it is for good."""
        query = sa.select(RUNS.c.id, RUNS.c.deleted).where(RUNS.c.deleted.is_not(None))
        with self.reading() as connection:
            return [(row.id, row.deleted) for row in connection.execute(query)]

    def recording(self) -> list[str]:
        """Return the runs that are being recorded, or were when their server was killed."""
        query = sa.select(RUNS.c.id).where(RUNS.c.state == "recording")
        with self.reading() as connection:
            return list(connection.scalars(query))

    def margins_due(self) -> list[str]:
        """Return runs whose stability margins are still to be computed, the newest first."""
        query = sa.select(RUNS.c.id).join(MARGINS_DUE).order_by(RUNS.c.number.desc())
        with self.reading() as connection:
            return list(connection.scalars(query.limit(_MARGINS_AT_ONCE)))

    def add_margins(self, run_id: str, margins: Mapping[str, float]) -> None:
        """Add stability margins to the metrics of a run for which they are due."""
        with self.begin() as connection:
            run = _read(connection, run_id, lock=not self._sqlite)
            if run is None:
                return
            run = run.model_copy(update={"metrics": {**run.metrics, **margins}})
            self._put(connection, run)
            number = sa.select(RUNS.c.number).where(RUNS.c.id == run_id).scalar_subquery()
            connection.execute(sa.delete(MARGINS_DUE).where(MARGINS_DUE.c.run == number))

    def evictable(self) -> list[tuple[str, int]]:
        """Return identifier and size of what may be evicted: deleted ones, then the oldest.

        The oldest are those that came into the index first, whatever the clock has said.
        """
        query = (
            sa.select(RUNS.c.id, RUNS.c.size)
            .where(_evictable(), RUNS.c.state != "recording")
            .order_by(RUNS.c.deleted.is_(None), RUNS.c.number)
        )
        with self.reading() as connection:
            return [(row.id, row.size) for row in connection.execute(query)]

    def note_eviction(self, run: Run) -> None:
        """Note that a run was evicted; the latest `_EVICTIONS` are known."""
        about = {"run": run.id, "name": run.name, "created": run.created, "size": run.size}
        with self.begin() as connection:
            connection.execute(sa.insert(EVICTIONS), [about | {"evicted": time.time()}])
            newest = sa.select(sa.func.max(EVICTIONS.c.number)).scalar_subquery()
            old = sa.delete(EVICTIONS).where(EVICTIONS.c.number <= newest - _EVICTIONS)
            connection.execute(old)

    def evictions(self, limit: int) -> list[Evicted]:
        """Return the latest evictions, the newest first."""
        query = sa.select(EVICTIONS).order_by(EVICTIONS.c.number.desc()).limit(limit)
        with self.reading() as connection:
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
        with self.reading() as connection:
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
        with self.reading() as connection:
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
    rows: Mapping[int, Sequence[Mapping[str, Any]]],
) -> None:
    """Put rows, by run, in place of those that a table has of these runs."""
    gone = sa.delete(table).where(table.c.run == sa.bindparam("of"))
    connection.execute(gone, [{"of": number} for number in rows])
    if new := [{"run": number, **row} for number, some in rows.items() for row in some]:
        connection.execute(sa.insert(table), new)


def _narrow(row: sa.RowMapping) -> dict[str, Any]:
    return {name: row[name] for name in _NARROW}


def _words(run: Run) -> str:
    """Return everything of a run that a word can be found in, in lower case."""
    changes = (f"{each.path} {each.value}" for each in run.differences)
    stopped = f"stopped {run.stopped}" if run.stopped else ""
    own = (run.id, run.name, run.scenario, run.note, stopped)
    parts = (*own, *run.tags, *run.labels.values(), *changes)
    return "\n".join(parts).lower()
