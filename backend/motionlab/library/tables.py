"""Tables of the index of runs.

What lists filter and sort by lies in narrow columns of `RUNS`; what only one run at a time is asked
for lies in `DOCUMENTS`, so that a search over all runs reads little. Tables refer to a run by its
number, the order in which it came: numbers are looked up sooner than identifiers. Migrations add an
index of the trigrams of `WORDS`, `run_words_trigrams`: FTS5 in SQLite, pg_trgm in PostgreSQL.
"""

from __future__ import annotations

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    false,
    text,
)

METADATA = MetaData()
_DELETED = text("deleted IS NOT NULL")

RUNS = Table(
    "runs",
    METADATA,
    Column("number", Integer, primary_key=True),
    Column("id", String(16), nullable=False, unique=True),
    Column("kind", String(16), nullable=False),
    Column("state", String(16), nullable=False),
    Column("name", Text, nullable=False),
    Column("scenario", String(64), nullable=False),
    Column("pinned", Boolean, nullable=False),
    Column("kept", Boolean, nullable=False, server_default=false()),
    Column("created", Float(53), nullable=False),
    Column("deleted", Float(53)),
    Column("duration", Float(53), nullable=False),
    Column("size", BigInteger, nullable=False),
    Index("runs_created", "created", "number"),
    Index("runs_name", "name", "number"),
    Index("runs_duration", "duration", "number"),
    Index("runs_size", "size", "number"),
    Index("runs_deleted", "deleted", sqlite_where=_DELETED, postgresql_where=_DELETED),
)


def _run() -> Column[int]:
    return Column("run", ForeignKey("runs.number", ondelete="CASCADE"), primary_key=True)


WORDS = Table(
    "run_words",
    METADATA,
    _run(),
    Column("words", Text, nullable=False),  # name, note, tags, labels, differences in lower case
)

DOCUMENTS = Table(
    "run_documents",
    METADATA,
    _run(),
    Column("entry", JSON, nullable=False),  # what a list shows beside the columns of RUNS
    Column("record", JSON, nullable=False),  # what makes it reproducible, and its result
)

TAGS = Table(
    "run_tags",
    METADATA,
    Column("tag", String(32), primary_key=True),
    _run(),
    Index("run_tags_run", "run"),
    sqlite_with_rowid=False,
)

METRICS = Table(
    "run_metrics",
    METADATA,
    Column("metric", String(64), primary_key=True),
    _run(),
    Column("value", Float(53), nullable=False),
    Index("run_metrics_value", "metric", "value", "run"),
    Index("run_metrics_run", "run"),
    sqlite_with_rowid=False,
)

# Simulated runs of an earlier index, whose stability margins are still to be computed.
MARGINS_DUE = Table("run_margins_due", METADATA, _run())

EVICTIONS = Table(
    "evictions",
    METADATA,
    Column("number", Integer, primary_key=True),
    Column("run", String(16), nullable=False),
    Column("name", Text, nullable=False),
    Column("created", Float(53), nullable=False),
    Column("evicted", Float(53), nullable=False),
    Column("size", BigInteger, nullable=False),
)

GAIN_SETS = Table(
    "gain_sets",
    METADATA,
    Column("name", String(60), primary_key=True),
    Column("created", Float(53), nullable=False),
    Column("document", JSON, nullable=False),
)

LAYOUTS = Table(
    "layouts",
    METADATA,
    Column("name", String(60), primary_key=True),
    Column("scopes", JSON, nullable=False),
)
