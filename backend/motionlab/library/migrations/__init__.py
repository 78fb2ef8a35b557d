"""Migrations of the index, carried out by Alembic when it is opened."""
