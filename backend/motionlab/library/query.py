"""Pages of the index: which runs meet a search, in which order, without reading all of them.

Every condition can be asked in two ways: as the list of runs that meet it, from an index of its
own, and as a test of one run. If few runs meet one of them, only those runs are tested; else the
lists are intersected here, which is quicker than a test of each run by the database. The page is
then walked to in the order of the list, by an index, and ends as soon as it is full.

What a search has found is kept with the connection, for further pages and other orders, until any
process has changed the index.
"""

from __future__ import annotations

import base64
import json
import math
import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sqlalchemy as sa

from motionlab.errors import ConfigError, FieldError
from motionlab.library.run import is_id
from motionlab.library.search import SORTS, Search, metric_name
from motionlab.library.tables import METRICS, RUNS, TAGS, WORDS

_FEW = 2000  # runs that are looked at one by one
_KEPT = 300_000  # identifiers that a connection keeps at most, about 100 bytes each
_KEPT_SEARCHES = 100  # also of searches that find nothing
_SPARE = 1.3  # runs that are walked past over those expected
_TRIGRAM = 3  # characters; shorter words are in no index
_LAST = 1e300  # key of runs without the metric that is sorted by
_SIGNS = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
_PLACES = sa.table("run_words_trigrams", sa.column("rowid"), sa.column("words"))


@dataclass(frozen=True)
class _Condition:
    """What runs must meet.

    Attributes
    ----------
    runs : Select
        Identifiers of those that meet it, from an index where there is one.
    test : ColumnElement
        Whether a row of `RUNS` meets it; written so that no index of `RUNS` applies.
    """

    runs: sa.Select[Any]
    test: sa.ColumnElement[bool]


@dataclass(frozen=True)
class _Members:
    """Runs that meet a search.

    Attributes
    ----------
    known : set of str
        Those that do, or if `inverse` those that do not.
    inverse : bool
        Which of the two.
    count : int
        How many meet it.
    share : float
        Of all runs.
    """

    known: set[str]
    inverse: bool
    count: int
    share: float

    def __contains__(self, run_id: str) -> bool:
        return (run_id in self.known) is not self.inverse


@dataclass(frozen=True)
class Found:
    """A page of the runs that meet a search: identifiers, how many there are, what is next."""

    ids: list[str]
    total: int
    cursor: str | None


def find(
    connection: sa.Connection, search: Search, sort: str, limit: int, cursor: str | None
) -> Found:
    """Return a page of the runs that meet a search; `Index.page` says more."""
    order = _Order.of(sort)
    after = None if cursor is None else order.place(cursor)
    members = _Kept.of(connection).members(connection, search)
    found: list[Any] = []
    for query in order.queries(after):
        if (wanted := limit + 1 - len(found)) > 0 and members.count:
            found += _walk(connection, query, members, wanted)
    more = order.cursor(found[limit - 1]) if len(found) > limit else None
    return Found([row.id for row in found[:limit]], members.count, more)


def _walk(connection: sa.Connection, query: _Query, members: _Members, wanted: int) -> list[Any]:
    """Return the first runs of a query that are members."""
    if not members.inverse and members.count <= _FEW:
        among = query.select.where(query.run.in_(members.known))
        return [*connection.execute(among.limit(wanted))]
    found: list[Any] = []
    passed, step = 0, math.ceil(_SPARE * wanted / members.share)
    while len(found) < wanted:
        rows = connection.execute(query.select.limit(step).offset(passed)).all()
        found += [row for row in rows if row.id in members]
        passed += len(rows)
        if len(rows) < step:
            break
        step *= 2
    return found[:wanted]


class _Kept:
    """What the searches of one connection have found since the index was changed last."""

    def __init__(self) -> None:
        self._state: Any = None
        self._found: dict[Search, _Members] = {}
        self._every = 0  # runs there were when they were counted last

    @classmethod
    def of(cls, connection: sa.Connection) -> _Kept:
        return connection.info.setdefault("kept searches", cls())

    def members(self, connection: sa.Connection, search: Search) -> _Members:
        """Return the runs that meet a search."""
        # Read before the runs: what is changed in between is then taken for a later change.
        state = _state(connection)
        if state != self._state:
            self._state = state
            self._found.clear()
        found = self._found.pop(search, None) or self._find(connection, search)
        if len(found.known) <= _KEPT:
            self._found[search] = found  # the most recent last
        while len(self._found) > _KEPT_SEARCHES or self._size() > _KEPT:
            del self._found[next(iter(self._found))]
        return found

    def _size(self) -> int:
        return sum(len(each.known) for each in self._found.values())

    def _find(self, connection: sa.Connection, search: Search) -> _Members:
        conditions = [*_conditions(search, sqlite=connection.dialect.name == "sqlite")]
        if not self._every or not (conditions or search.deleted):
            count_all = sa.select(sa.func.count()).select_from(RUNS)
            self._every = connection.execute(count_all).scalar_one()
        deleted = _set(connection, sa.select(RUNS.c.id).where(RUNS.c.deleted.is_not(None)))
        if not conditions and not search.deleted:
            count = self._every - len(deleted)
            return _Members(deleted, inverse=True, count=count, share=count / max(self._every, 1))
        meet = _meeting(connection, conditions) if conditions else set(deleted)
        if search.deleted:
            meet &= deleted
        else:
            meet -= deleted
        # An old count is good enough for the share, which only says how far a page is.
        share = len(meet) / max(self._every, len(meet), 1)
        return _Members(meet, inverse=False, count=len(meet), share=share)


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


def _meeting(connection: sa.Connection, conditions: list[_Condition]) -> set[str]:
    """Return the runs that meet all conditions; those of the rarest are looked at if few."""
    at_most = [each.runs.limit(_FEW + 1).subquery() for each in conditions]
    counts = (sa.select(sa.func.count()).select_from(each).scalar_subquery() for each in at_most)
    sizes = connection.execute(sa.select(*counts)).one()
    least = min(range(len(sizes)), key=lambda i: sizes[i])
    if sizes[least] <= _FEW:
        few = _set(connection, conditions[least].runs)
        tests = [each.test for i, each in enumerate(conditions) if i != least]
        if not tests:
            return few
        return _set(connection, sa.select(RUNS.c.id).where(RUNS.c.id.in_(few), *tests))
    # Only the shortest becomes a set: the others are looked up in it.
    shortest, *others = sorted((_text(connection, each.runs) for each in conditions), key=len)
    meet = _identifiers(shortest)
    for text in others:
        meet.intersection_update(text.split(","))
    return meet


def _set(connection: sa.Connection, runs: sa.Select[Any]) -> set[str]:
    """Return the identifiers that a query finds."""
    return _identifiers(_text(connection, runs))


def _text(connection: sa.Connection, runs: sa.Select[Any]) -> str:
    """Return the identifiers that a query finds with commas between, quicker than as rows."""
    (column,) = runs.subquery().columns
    text = connection.execute(sa.select(sa.func.aggregate_strings(column, ","))).scalar_one()
    return text or ""


def _identifiers(text: str) -> set[str]:
    return set(text.split(",")) if text else set()


def _conditions(search: Search, *, sqlite: bool) -> Iterator[_Condition]:
    yield from _words(search.words, sqlite=sqlite)
    for tag in search.tags:
        yield _elsewhere(TAGS, TAGS.c.tag == tag)
    for bound in search.bounds:
        within = _SIGNS[bound.sign](METRICS.c.value, bound.value)
        yield _elsewhere(METRICS, METRICS.c.metric == bound.metric, within)
    for name in ("kind", "state", "scenario"):
        if values := getattr(search, f"{name}s"):
            yield _own(RUNS.c[name].in_(values), sa.func.coalesce(RUNS.c[name], "").in_(values))
    if search.after is not None:
        yield _own(RUNS.c.created >= search.after, RUNS.c.created + 0.0 >= search.after)
    if search.before is not None:
        yield _own(RUNS.c.created < search.before, RUNS.c.created + 0.0 < search.before)
    if search.pinned:
        yield _own(RUNS.c.pinned.is_(True), sa.func.coalesce(RUNS.c.pinned, sa.false()))


def _own(indexed: sa.ColumnElement[bool], test: sa.ColumnElement[bool]) -> _Condition:
    """Return a condition on a column of `RUNS`; the test is written so that no index applies."""
    return _Condition(sa.select(RUNS.c.id).where(indexed), test)


def _elsewhere(table: sa.Table, *tests: sa.ColumnElement[bool]) -> _Condition:
    """Return a condition on another table's row of a run."""
    its = sa.exists().where(table.c.run == RUNS.c.id, *tests).correlate(RUNS)
    return _Condition(sa.select(table.c.run).where(*tests), its)


def _words(words: Sequence[str], *, sqlite: bool) -> Iterator[_Condition]:
    """Yield what words ask for; SQLite looks up all that its trigrams can find at once."""
    found = [word for word in words if sqlite and len(word) >= _TRIGRAM]
    if found:
        phrases = " ".join('"' + word.replace('"', '""') + '"' for word in found)
        join = WORDS.join(_PLACES, _PLACES.c.rowid == WORDS.c.number)
        runs = sa.select(WORDS.c.run).select_from(join)
        contain = (WORDS.c.words.contains(word, autoescape=True) for word in found)
        test = _elsewhere(WORDS, *contain).test
        yield _Condition(runs.where(_PLACES.c.words.op("MATCH")(phrases)), test)
    for word in words:
        if word not in found:
            yield _elsewhere(WORDS, WORDS.c.words.contains(word, autoescape=True))


class _Query(NamedTuple):
    select: sa.Select[*tuple[Any, ...]]
    run: sa.ColumnElement[str]


class _Order:
    """What a list is sorted by, with the identifier to break ties."""

    def __init__(self, name: str, *, descending: bool) -> None:
        self.name = name
        self.descending = descending
        self.metric = None if name in SORTS else metric_name(name, "sort")

    @classmethod
    def of(cls, sort: str) -> _Order:
        return cls(sort.removeprefix("-"), descending=sort.startswith("-"))

    def queries(self, after: tuple[Any, str] | None) -> Iterator[_Query]:
        """Yield queries that give all runs one after the other, each by an index."""
        if self.metric is None:
            yield self._query(RUNS.c[self.name], RUNS.c.id, after)
            return
        # A run without the metric comes last, whichever way.
        if after is None or abs(after[0]) < _LAST:
            query = self._query(METRICS.c.value, METRICS.c.run, after)
            yield _Query(query.select.where(METRICS.c.metric == self.metric), query.run)
            after = None
        last = sa.literal(-_LAST if self.descending else _LAST)
        having = sa.exists().where(METRICS.c.run == RUNS.c.id, METRICS.c.metric == self.metric)
        query = self._query(last, RUNS.c.id, after)
        yield _Query(query.select.where(~having), query.run)

    def _query(self, key: Any, run: Any, after: tuple[Any, str] | None) -> _Query:
        query = sa.select(run.label("id"), key.label("key"))
        columns = (run,) if isinstance(key, sa.BindParameter) else (key, run)
        if after is not None:
            here, there = sa.tuple_(*columns), sa.tuple_(*after[-len(columns) :])
            query = query.where(here < there if self.descending else here > there)
        order = (c.desc() if self.descending else c.asc() for c in columns)
        return _Query(query.order_by(*order), run)

    def cursor(self, row: Any) -> str:
        return base64.urlsafe_b64encode(json.dumps([self.name, row.key, row.id]).encode()).decode()

    def place(self, cursor: str) -> tuple[Any, str]:
        """Return key and identifier of the last run of the page before."""
        try:
            name, key, run_id = json.loads(base64.urlsafe_b64decode(cursor.encode()))
            if name != self.name or not is_id(run_id):
                raise ValueError(cursor)
            # Also no half of a surrogate pair is a name.
            if name == "name" and b"\0" in str.encode(key):
                raise ValueError(cursor)
            if name != "name" and not math.isfinite(key := float(key)):
                raise ValueError(cursor)
        except (ValueError, TypeError, OverflowError, RecursionError):
            raise ConfigError(FieldError("cursor", "is of no list of runs", cursor)) from None
        return key, run_id
