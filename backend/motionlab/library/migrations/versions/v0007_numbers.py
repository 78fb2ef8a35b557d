"""Runs by number in all tables, metrics and tags in the order of runs; no index that misleads."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op
from sqlalchemy.exc import DBAPIError

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

_INDEXES = {
    "runs": (
        "created",
        "name",
        "duration",
        "size",
        "kind",
        "state",
        "scenario",
        "pinned",
        "deleted",
    ),
    "run_tags": ("tag",),
    "run_metrics": ("value",),
}
_TRIGRAMS = (
    "CREATE VIRTUAL TABLE run_words_trigrams USING fts5("
    "words, content='run_words', content_rowid='run', tokenize='trigram case_sensitive 1')",
    "INSERT INTO run_words_trigrams(run_words_trigrams) VALUES ('rebuild')",
    "CREATE TRIGGER run_words_inserted AFTER INSERT ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(rowid, words) VALUES (new.run, new.words); END",
    "CREATE TRIGGER run_words_deleted AFTER DELETE ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(run_words_trigrams, rowid, words) "
    "VALUES ('delete', old.run, old.words); END",
    "CREATE TRIGGER run_words_updated AFTER UPDATE ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(run_words_trigrams, rowid, words) "
    "VALUES ('delete', old.run, old.words); "
    "INSERT INTO run_words_trigrams(rowid, words) VALUES (new.run, new.words); END",
)
_NARROW = "id, kind, state, name, scenario, pinned, kept, created, deleted, duration, size"


def upgrade() -> None:
    """Bring the index to this version."""
    sqlite = op.get_bind().dialect.name == "sqlite"
    if sqlite:
        for change in ("inserted", "deleted", "updated"):
            op.execute(f"DROP TRIGGER run_words_{change}")
        op.execute("DROP TABLE run_words_trigrams")
    for table, columns in _INDEXES.items():
        for column in columns:
            op.drop_index(f"{table}_{column}", table)
    tables = ("run_words", "run_documents", "run_tags", "run_metrics", "runs")
    for table in tables:
        op.rename_table(table, f"old_{table}")
    _create_tables()
    op.execute(
        f"INSERT INTO runs (number, {_NARROW}) SELECT w.number, {_NARROW} "
        "FROM old_runs r JOIN old_run_words w ON w.run = r.id ORDER BY w.number"
    )
    op.execute("INSERT INTO run_words SELECT number, words FROM old_run_words ORDER BY number")
    for table, columns, order in (
        ("run_documents", "entry, record", "number"),
        ("run_tags", "tag", "tag, number"),
        ("run_metrics", "metric, value", "metric, number"),
    ):
        op.execute(
            f"INSERT INTO {table} (run, {columns}) SELECT w.number, {columns} "
            f"FROM old_{table} o JOIN old_run_words w ON w.run = o.run ORDER BY {order}"
        )
    for table in tables:
        op.drop_table(f"old_{table}")
    _create_indexes()
    if sqlite:
        for statement in _TRIGRAMS:
            op.execute(statement)
    else:
        op.execute(
            "SELECT setval(pg_get_serial_sequence('runs', 'number'), max(number)) FROM runs "
            "HAVING max(number) IS NOT NULL"
        )
        _trigrams_of_postgresql()


def _create_tables() -> None:
    op.create_table(
        "runs",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(16), nullable=False, unique=True),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("scenario", sa.String(64), nullable=False),
        sa.Column("pinned", sa.Boolean, nullable=False),
        sa.Column("kept", sa.Boolean, nullable=False, server_default=sa.false()),
        sa.Column("created", sa.Float(53), nullable=False),
        sa.Column("deleted", sa.Float(53)),
        sa.Column("duration", sa.Float(53), nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
    )
    op.create_table("run_words", _run(), sa.Column("words", sa.Text, nullable=False))
    op.create_table(
        "run_documents",
        _run(),
        sa.Column("entry", sa.JSON, nullable=False),
        sa.Column("record", sa.JSON, nullable=False),
    )
    # The rows of a tag, and of a metric, lie together in the order of the runs.
    op.create_table(
        "run_tags",
        sa.Column("tag", sa.String(32), primary_key=True),
        _run(),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "run_metrics",
        sa.Column("metric", sa.String(64), primary_key=True),
        _run(),
        sa.Column("value", sa.Float(53), nullable=False),
        sqlite_with_rowid=False,
    )


def _run() -> sa.Column[Any]:
    of_a_run = sa.ForeignKey("runs.number", ondelete="CASCADE")
    return sa.Column("run", sa.Integer, of_a_run, primary_key=True)


def _create_indexes() -> None:
    # None of what few values have: a look at each run is quicker, and leaves the order of a list.
    for column in ("created", "name", "duration", "size"):
        op.create_index(f"runs_{column}", "runs", [column, "number"])
    there = sa.text("deleted IS NOT NULL")
    op.create_index("runs_deleted", "runs", ["deleted"], sqlite_where=there, postgresql_where=there)
    op.create_index("run_tags_run", "run_tags", ["run"])
    op.create_index("run_metrics_run", "run_metrics", ["run"])
    op.create_index("run_metrics_value", "run_metrics", ["metric", "value", "run"])


def _trigrams_of_postgresql() -> None:
    """Index trigrams where the extension is there; words are searched without."""
    try:
        with op.get_bind().begin_nested():
            op.execute(
                "CREATE INDEX run_words_trigrams ON run_words USING gin (words public.gin_trgm_ops)"
            )
    except DBAPIError:
        return
