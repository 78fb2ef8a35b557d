"""Named gain sets."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the index to this version."""
    op.create_table(
        "gain_sets",
        sa.Column("name", sa.String(60), primary_key=True),
        sa.Column("created", sa.Float(53), nullable=False),
        sa.Column("document", sa.JSON, nullable=False),
    )
