"""Databases for tests: a file, or a schema of its own in the PostgreSQL that is named."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

import pytest

DATABASES = ("sqlite", "postgresql")
NAMED = "MOTIONLAB_TEST_DATABASE_URL"


@contextlib.contextmanager
def database(kind: str, folder: Path) -> Iterator[str]:
    """Give the address of an empty database, which is gone afterwards."""
    if kind == "sqlite":
        yield f"sqlite:///{folder / 'runs.sqlite'}"
        return
    address = os.environ.get(NAMED)
    if not address:
        reason = f"no PostgreSQL: {NAMED}=postgresql://USER@HOST/DATABASE names one"
        if os.environ.get("CI") == "true":
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)
    import psycopg  # not among the lowest versions

    schema = f"test_{secrets.token_hex(8)}"
    with psycopg.connect(address, autocommit=True) as connection:
        connection.execute(f"CREATE SCHEMA {schema}".encode())
        try:
            separator = "&" if "?" in address else "?"
            plain = address.partition("://")[2]
            options = f"options=-csearch_path%3D{schema}"
            yield f"postgresql+psycopg://{plain}{separator}{options}"
        finally:
            connection.execute(f"DROP SCHEMA {schema} CASCADE".encode())
