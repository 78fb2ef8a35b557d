"""Words in a table of their own with an index of trigrams; indexes of what filters ask for."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
from sqlalchemy.exc import DBAPIError

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

_FILTERS = ("kind", "state", "scenario", "pinned")
_TRIGRAMS = (
    "CREATE VIRTUAL TABLE run_words_trigrams USING fts5("
    "words, content='run_words', content_rowid='number', tokenize='trigram case_sensitive 1')",
    "INSERT INTO run_words_trigrams(run_words_trigrams) VALUES ('rebuild')",
    "CREATE TRIGGER run_words_inserted AFTER INSERT ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(rowid, words) VALUES (new.number, new.words); END",
    "CREATE TRIGGER run_words_deleted AFTER DELETE ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(run_words_trigrams, rowid, words) "
    "VALUES ('delete', old.number, old.words); END",
    "CREATE TRIGGER run_words_updated AFTER UPDATE ON run_words BEGIN "
    "INSERT INTO run_words_trigrams(run_words_trigrams, rowid, words) "
    "VALUES ('delete', old.number, old.words); "
    "INSERT INTO run_words_trigrams(rowid, words) VALUES (new.number, new.words); END",
)


def upgrade() -> None:
    """Bring the index to this version."""
    op.create_table(
        "run_words",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column(
            "run",
            sa.String(16),
            sa.ForeignKey("runs.id", ondelete="CASCADE"),
            nullable=False,
            unique=True,
        ),
        sa.Column("words", sa.Text, nullable=False),
    )
    op.execute("INSERT INTO run_words (run, words) SELECT id, words FROM runs")
    op.drop_column("runs", "words")
    for column in _FILTERS:
        op.create_index(f"runs_{column}", "runs", [column])
    # Nearly every run is not deleted: an index of those would mislead SQLite's planner.
    op.drop_index("runs_deleted", "runs")
    there = sa.text("deleted IS NOT NULL")
    op.create_index("runs_deleted", "runs", ["deleted"], sqlite_where=there, postgresql_where=there)
    if op.get_bind().dialect.name == "sqlite":
        for statement in _TRIGRAMS:
            op.execute(statement)
    else:
        _trigrams_of_postgresql()


def _trigrams_of_postgresql() -> None:
    """Index trigrams where the extension is there and may be created; words are found without."""
    connection = op.get_bind()
    try:
        with connection.begin_nested():
            op.execute("CREATE EXTENSION IF NOT EXISTS pg_trgm WITH SCHEMA public")
            op.execute(
                "CREATE INDEX run_words_trigrams ON run_words USING gin (words public.gin_trgm_ops)"
            )
    except DBAPIError:
        return
