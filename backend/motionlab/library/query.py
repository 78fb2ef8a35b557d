"""Pages of the index: which runs meet a search, in which order, without reading all of them.

A count begins with the runs of one condition, from its index, and tests each for the others. A page
walks the index of what the list is sorted by and tests each run until it is full. The runs of a
search that finds few are listed instead, and sorted.
"""

from __future__ import annotations

import base64
import json
import math
import operator
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sqlalchemy as sa

from motionlab.errors import ConfigError, FieldError
from motionlab.library.search import SORTS, Search, metric_name
from motionlab.library.tables import METRICS, RUNS, TAGS, WORDS

_FEW = 2000  # runs that are listed and sorted
_KEPT_SEARCHES = 100  # of a connection
_NUMBER_MAX = 2**31 - 1
_TRIGRAM = 3  # characters; shorter words are in no index
_LAST = 1e300  # key of runs without the metric that is sorted by
_SIGNS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
_TRIGRAMS = sa.table("run_words_trigrams", sa.column("rowid"), sa.column("words"))


_Test = Callable[[sa.ColumnElement[int]], sa.ColumnElement[bool]]


class _Condition(NamedTuple):
    """What runs must meet.

    Attributes
    ----------
    runs : Select
        The numbers of those that do.
    test : callable
        Returns whether the run of a number does.
    counted_by : callable
        The same for many runs, where a list of all that do is quicker to look up.
    """

    runs: sa.Select[Any]
    test: _Test
    counted_by: _Test


@dataclass(frozen=True)
class Hits:
    """A page of the runs that meet a search: numbers, how many there are, what is next."""

    numbers: list[int]
    total: int
    cursor: str | None


def find(
    connection: sa.Connection, search: Search, sort: str, limit: int, cursor: str | None
) -> Hits:
    """Return a page of the runs that meet a search; `Index.page` says more."""
    order = _Order.of(sort)
    after = None if cursor is None else order.place(cursor)
    total, few = _Totals.of(connection).get(connection, search)
    conditions = _elsewhere(connection, search)
    rows: list[Any] = []
    for walk in order.walks(search, after):
        missing = limit + 1 - len(rows)
        if total and missing > 0:
            tests = (each.test(walk.run) for each in (*conditions, *walk.conditions))
            listed = walk.rows.where(*tests if few is None else [_listed(walk.run, few)])
            rows += connection.execute(listed.limit(missing))
    more = order.cursor(rows[limit - 1]) if len(rows) > limit else None
    return Hits([row.number for row in rows[:limit]], total, more)


def conditions_on(
    connection: sa.Connection, search: Search, run: sa.ColumnElement[int]
) -> list[sa.ColumnElement[bool]]:
    """Return what a search asks of the run of a number, in a query that joins `RUNS`."""
    return [
        *(each.test(run) for each in _elsewhere(connection, search)),
        *_own(search, RUNS),
        _is_deleted(RUNS, deleted=search.deleted),
    ]


def _listed(run: sa.ColumnElement[int], numbers: Sequence[int]) -> sa.ColumnElement[bool]:
    # As text: a parameter for each costs more time than the query.
    return run.in_([sa.literal_column(",".join(map(str, numbers)), sa.Integer)])


class _Totals:
    """How many runs the latest searches of a connection find, and which where they are few."""

    def __init__(self) -> None:
        self._state: Any = None
        self._kept: OrderedDict[Search, tuple[int, list[int] | None]] = OrderedDict()

    @classmethod
    def of(cls, connection: sa.Connection) -> _Totals:
        return connection.info.setdefault("totals", cls())

    def get(self, connection: sa.Connection, search: Search) -> tuple[int, list[int] | None]:
        # Read before the runs: what is changed in between is then taken for a later change.
        state = _state(connection)
        if state != self._state:
            self._state = state
            self._kept.clear()
        if search not in self._kept:
            self._kept[search] = _total(connection, search)
        self._kept.move_to_end(search)
        while len(self._kept) > _KEPT_SEARCHES:
            self._kept.popitem(last=False)
        return self._kept[search]


def _state(connection: sa.Connection) -> Any:
    """Return what is equal only as long as no process has changed the database.

    PostgreSQL: which transactions are seen. SQLite: changes by other connections and by this one;
    asking for them begins the transaction that the search reads in.
    """
    if connection.dialect.name == "sqlite":
        others = connection.exec_driver_sql("PRAGMA data_version").scalar_one()
        own = connection.connection.dbapi_connection
        return others, getattr(own, "total_changes", None)
    return connection.exec_driver_sql("SELECT pg_current_snapshot()::text").scalar_one()


def _total(connection: sa.Connection, search: Search) -> tuple[int, list[int] | None]:
    """Return how many runs meet a search, and their numbers if they are few."""
    conditions = _elsewhere(connection, search)
    if [*_own(search, RUNS)]:
        conditions.append(_of_runs(search))
    # Few are deleted: they are looked up first, and counted rather than tested for in each run.
    deleted = _meeting(_of_runs(Search(), deleted=True), *conditions)
    there = deleted if search.deleted else _meeting(*conditions, _of_runs(Search(), deleted=False))
    numbers = [*connection.scalars(there.limit(_FEW + 1))]
    if len(numbers) <= _FEW:
        return len(numbers), numbers
    first, *others = conditions or [_of_runs(search)]
    many = _count(_where(first, [each.counted_by for each in others]))
    total = many - _count(deleted) if not search.deleted else _count(deleted)
    return connection.execute(sa.select(total)).scalar_one(), None


def _count(runs: sa.Select[Any]) -> sa.ScalarSelect[int]:
    return sa.select(sa.func.count()).select_from(runs.subquery()).scalar_subquery()


def _meeting(first: _Condition, *others: _Condition) -> sa.Select[Any]:
    """Return the numbers of the runs that meet all conditions, from the index of the first."""
    return _where(first, [each.test for each in others])


def _where(first: _Condition, tests: Sequence[_Test]) -> sa.Select[Any]:
    (run,) = first.runs.selected_columns
    return first.runs.where(*(test(run) for test in tests))


def _elsewhere(connection: sa.Connection, search: Search) -> list[_Condition]:
    """Return the conditions on other tables than that of runs, those with the best index first."""
    conditions: list[_Condition] = []
    long, short = list(search.words), []
    if connection.dialect.name == "sqlite":
        long, short = (
            [word for word in search.words if (len(word) >= _TRIGRAM) is indexed]
            for indexed in (True, False)
        )
    if long and connection.dialect.name == "sqlite":
        phrases = " ".join('"' + word.replace('"', '""') + '"' for word in long)
        match = _TRIGRAMS.c.words.op("MATCH")(phrases)
        conditions.append(_contain(long)._replace(runs=sa.select(_TRIGRAMS.c.rowid).where(match)))
    elif long:
        conditions.append(_contain(long))
    for tag in search.tags:
        tags = TAGS.alias()
        conditions.append(_in(tags.c.run, tags.c.tag == tag))
    for bound in search.bounds:
        metrics = METRICS.alias()
        within = _SIGNS[bound.sign](metrics.c.value, bound.value)
        met = _in(metrics.c.run, metrics.c.metric == bound.metric, within)
        conditions.append(met._replace(counted_by=_one_of(met.runs)))
    if short:
        conditions.append(_contain(short))
    return conditions


def _contain(words: Sequence[str]) -> _Condition:
    table = WORDS.alias()
    return _in(table.c.run, *(table.c.words.contains(word, autoescape=True) for word in words))


def _of_runs(search: Search, *, deleted: bool | None = None) -> _Condition:
    """Return the condition on the columns of runs."""
    runs = RUNS.alias()
    tests = [*_own(search, runs)]
    if deleted is not None:
        tests.append(_is_deleted(runs, deleted=deleted))
    return _in(runs.c.number, *tests)


def _own(search: Search, runs: sa.FromClause) -> Iterator[sa.ColumnElement[bool]]:
    for name in ("kind", "state", "scenario", "name"):
        if values := getattr(search, f"{name}s"):
            yield runs.c[name].in_(values)
    if search.after is not None:
        yield runs.c.created >= search.after
    if search.before is not None:
        yield runs.c.created < search.before
    if search.pinned:
        yield runs.c.pinned.is_(True)


def _is_deleted(runs: sa.FromClause, *, deleted: bool) -> sa.ColumnElement[bool]:
    return runs.c.deleted.is_not(None) if deleted else runs.c.deleted.is_(None)


def _in(run: Any, *tests: sa.ColumnElement[bool]) -> _Condition:
    """Return the condition that a table has a row of the run that passes tests."""
    row = sa.exists().where(*tests).correlate_except(run.table)

    def test(number: sa.ColumnElement[int]) -> sa.ColumnElement[bool]:
        return row.where(run == number)

    return _Condition(sa.select(run).where(*tests), test, test)


def _one_of(runs: sa.Select[Any]) -> _Test:
    return lambda number: number.in_(runs)


class _Walk(NamedTuple):
    """Runs in the order of a list, by an index: number and key; conditions that it leaves."""

    rows: sa.Select[Any, Any]
    run: sa.ColumnElement[int]
    conditions: tuple[_Condition, ...] = ()


class _Order:
    """What a list is sorted by, with the number to break ties."""

    def __init__(self, name: str, *, descending: bool) -> None:
        self.name = name
        self.descending = descending
        self.metric = None if name in SORTS else metric_name(name, "sort")

    @classmethod
    def of(cls, sort: str) -> _Order:
        return cls(sort.removeprefix("-"), descending=sort.startswith("-"))

    def walks(self, search: Search, after: tuple[Any, int] | None) -> Iterator[_Walk]:
        """Yield walks that give all runs one after the other."""
        own = [*_own(search, RUNS), _is_deleted(RUNS, deleted=search.deleted)]
        if self.metric is None:
            yield _Walk(
                self._rows(RUNS.c[self.name], RUNS.c.number, after).where(*own), RUNS.c.number
            )
            return
        # A run without the metric comes last, whichever way.
        if after is None or abs(after[0]) < _LAST:
            rows = self._rows(METRICS.c.value, METRICS.c.run, after)
            rows = rows.where(METRICS.c.metric == self.metric)
            for bound in search.bounds:  # where the walk begins or ends
                if bound.metric == self.metric:
                    rows = rows.where(_SIGNS[bound.sign](METRICS.c.value, bound.value))
            yield _Walk(rows, METRICS.c.run, (_of_runs(search, deleted=search.deleted),))
            after = None
        last = sa.literal(-_LAST if self.descending else _LAST)
        having = sa.exists().where(METRICS.c.run == RUNS.c.number, METRICS.c.metric == self.metric)
        yield _Walk(self._rows(last, RUNS.c.number, after).where(*own, ~having), RUNS.c.number)

    def _rows(self, key: Any, run: Any, after: tuple[Any, int] | None) -> sa.Select[Any, Any]:
        rows = sa.select(run.label("number"), key.label("key"))
        columns = (run,) if isinstance(key, sa.BindParameter) else (key, run)
        if after is not None:
            row, last = sa.tuple_(*columns), sa.tuple_(*after[-len(columns) :])
            rows = rows.where(row < last if self.descending else row > last)
        return rows.order_by(*(c.desc() if self.descending else c.asc() for c in columns))

    def cursor(self, row: Any) -> str:
        document = json.dumps([self.name, row.key, row.number])
        return base64.urlsafe_b64encode(document.encode()).decode()

    def place(self, cursor: str) -> tuple[Any, int]:
        """Return key and number of the last run of the page before."""
        try:
            name, key, number = json.loads(base64.urlsafe_b64decode(cursor.encode()))
            if name != self.name or type(number) is not int or not 0 <= number <= _NUMBER_MAX:
                raise ValueError(cursor)
            # Also no half of a surrogate pair is a name.
            if name == "name" and b"\0" in str.encode(key):
                raise ValueError(cursor)
            if name != "name" and not math.isfinite(key := float(key)):
                raise ValueError(cursor)
        except (ValueError, TypeError, OverflowError, RecursionError):
            raise ConfigError(FieldError("cursor", "is of no list of runs", cursor)) from None
        return key, number
