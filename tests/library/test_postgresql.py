"""A PostgreSQL that hangs is given up."""

from __future__ import annotations

import socket
from types import SimpleNamespace

import pytest
import sqlalchemy as sa

from motionlab.errors import StoreError
from motionlab.library import postgresql
from motionlab.library.index import Index
from motionlab.library.postgresql import Deadline, connect_arguments


def test_a_server_that_never_answers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(postgresql, "CONNECT_SECONDS", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:  # accepts, and that is all
        port = server.getsockname()[1]
        with pytest.raises(StoreError, match="cannot be reached"):
            Index(f"postgresql+psycopg://lab@127.0.0.1:{port}/lab")


class Connection:
    def __init__(self, pgconn: object) -> None:
        self.pgconn = pgconn


def test_a_connection_without_an_answer_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(postgresql, "ANSWER_SECONDS", 0.0)
    monkeypatch.setattr(postgresql, "_GRACE", 0.01)
    deadline = Deadline(sa.create_engine("sqlite://"))
    ours, theirs = socket.socketpair()
    with ours, theirs:
        pgconn = SimpleNamespace(socket=ours.fileno())
        connection = Connection(pgconn)
        deadline._connections.add(connection)
        with deadline.running():
            assert ours.recv(1) == b""  # which would wait for ever


@pytest.mark.parametrize(
    ("query", "timeout", "end"),
    [("", 5, " "), ("?connect_timeout=9&options=-ca%3Db", "9", "-ca=b")],
)
def test_an_address_may_set_its_own_timeouts(query: str, timeout: object, end: str) -> None:
    arguments = connect_arguments(sa.make_url(f"postgresql+psycopg://h/d{query}"))
    assert arguments["connect_timeout"] == timeout
    assert arguments["options"].startswith("-c statement_timeout=10000 ")
    assert arguments["options"].endswith(end)
