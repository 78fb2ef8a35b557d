"""Named layouts of scopes."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the index to this version."""
    op.create_table(
        "layouts",
        sa.Column("name", sa.String(60), primary_key=True),
        sa.Column("scopes", sa.JSON, nullable=False),
    )
