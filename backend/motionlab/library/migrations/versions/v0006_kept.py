"""Which runs a person keeps, and which were evicted."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Bring the index to this version; what may have been kept by a person is kept from now on."""
    # Not in a batch, which would make the table anew: what refers to the old one goes with it.
    op.add_column("runs", sa.Column("kept", sa.Boolean, nullable=False, server_default=sa.false()))
    runs = sa.table(
        "runs",
        *(sa.column(name) for name in ("id", "kind", "name", "scenario", "kept")),
    )
    words = sa.table("run_documents", sa.column("run"), sa.column("entry", sa.JSON))
    tags = sa.table("run_tags", sa.column("run"))
    connection = op.get_bind()
    by_hand = sa.or_(
        runs.c.kind.in_(["simulation", "measurement"]),
        runs.c.id.in_(sa.select(tags.c.run)),
        sa.and_(runs.c.kind == "live", runs.c.name != runs.c.scenario),
        # Drives' runs were named by the lab: their scenario, variants and the link.
        sa.and_(runs.c.kind == "drive", sa.not_(runs.c.name.like("% on %"))),
    )
    connection.execute(sa.update(runs).where(by_hand).values(kept=sa.true()))
    noted = [
        row.run
        for row in connection.execute(
            sa.select(words.c.run, words.c.entry)
            .join(runs, runs.c.id == words.c.run)
            .where(runs.c.kept.is_(sa.false()))
        )
        if row.entry.get("note")
    ]
    for run in noted:
        connection.execute(sa.update(runs).where(runs.c.id == run).values(kept=sa.true()))
    op.create_table(
        "evictions",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("run", sa.String(16), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("created", sa.Float(53), nullable=False),
        sa.Column("evicted", sa.Float(53), nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
    )
