"""An index of runs on each kind of database, a library on each kind of file system."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from pathlib import Path

import pytest

from motionlab.library.index import Index
from motionlab.library.library import Library
from tests.library.databases import DATABASES, database


@pytest.fixture(params=DATABASES)
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    with database(request.param, tmp_path) as address:
        yield address


@pytest.fixture
def index(url: str) -> Iterator[Index]:
    index = Index(url)
    yield index
    index.close()


@pytest.fixture(scope="session")
def s3() -> Iterator[str]:
    """A server that speaks S3: its address."""
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    yield f"http://{host}:{port}"
    server.stop()


@pytest.fixture
def bucket(s3: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A bucket of its own: the URL of a folder in it."""
    from pyarrow import fs

    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "key")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "secret")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    name = f"runs-{secrets.token_hex(4)}"
    options = f"endpoint_override={s3}&region=us-east-1&allow_bucket_creation=true"
    system, _ = fs.FileSystem.from_uri(f"s3://{name}?{options}")
    system.create_dir(name)
    return f"s3://{name}/lab?{options}"


@pytest.fixture(params=["folder", "s3"])
def library(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Library]:
    if request.param == "s3":
        monkeypatch.setenv("MOTIONLAB_RUNS_URL", request.getfixturevalue("bucket"))
    library = Library(tmp_path / "data")
    yield library
    library.close()
