"""Alembic's entry: migrates over the connection that the index gives."""

from __future__ import annotations

from alembic import context

from motionlab.library.tables import METADATA

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=METADATA,
    render_as_batch=True,  # SQLite cannot alter a column in place
)
with context.begin_transaction():
    context.run_migrations()
