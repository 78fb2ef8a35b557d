"""Stability margins among the metrics: which runs are to have theirs computed."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the index to this version; margins are computed later, a few milliseconds a run."""
    op.create_table(
        "run_margins_due",
        sa.Column(
            "run", sa.Integer, sa.ForeignKey("runs.number", ondelete="CASCADE"), primary_key=True
        ),
    )
    # What is still recorded gets them when it ends.
    op.execute(
        "INSERT INTO run_margins_due (run) SELECT number FROM runs "
        "WHERE kind IN ('simulation', 'live') AND state <> 'recording'"
    )
