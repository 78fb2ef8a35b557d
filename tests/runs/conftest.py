"""An index of runs on each kind of database, and a library in a folder of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from motionlab.runs.index import Index
from motionlab.runs.library import Library
from tests.runs.databases import DATABASES, database


@pytest.fixture(params=DATABASES)
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    with database(request.param, tmp_path) as address:
        yield address


@pytest.fixture
def index(url: str) -> Iterator[Index]:
    index = Index(url)
    yield index
    index.close()


@pytest.fixture
def library(tmp_path: Path) -> Iterator[Library]:
    library = Library(tmp_path / "data")
    yield library
    library.close()
