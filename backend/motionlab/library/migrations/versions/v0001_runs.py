"""Runs, their documents, tags and metrics."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def _run() -> sa.Column[str]:
    return sa.Column(
        "run", sa.String(16), sa.ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True
    )


def upgrade() -> None:
    """Bring the index to this version."""
    op.create_table(
        "runs",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("scenario", sa.String(64), nullable=False),
        sa.Column("pinned", sa.Boolean, nullable=False),
        sa.Column("created", sa.Float(53), nullable=False),
        sa.Column("deleted", sa.Float(53)),
        sa.Column("duration", sa.Float(53), nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
        sa.Column("words", sa.Text, nullable=False),
    )
    op.create_index("runs_created", "runs", ["created", "id"])
    op.create_index("runs_deleted", "runs", ["deleted"])
    op.create_table(
        "run_documents",
        _run(),
        sa.Column("entry", sa.JSON, nullable=False),
        sa.Column("record", sa.JSON, nullable=False),
    )
    op.create_table("run_tags", _run(), sa.Column("tag", sa.String(32), primary_key=True))
    op.create_index("run_tags_tag", "run_tags", ["tag", "run"])
    op.create_table(
        "run_metrics",
        _run(),
        sa.Column("metric", sa.String(64), primary_key=True),
        sa.Column("value", sa.Float(53), nullable=False),
    )
    op.create_index("run_metrics_value", "run_metrics", ["metric", "value", "run"])
