"""Indexes of what runs are sorted by."""

from __future__ import annotations

from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

_SORTS = ("name", "duration", "size")


def upgrade() -> None:
    """Bring the index to this version."""
    for column in _SORTS:
        op.create_index(f"runs_{column}", "runs", [column, "id"])
