"""Further servers, and sessions that end."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import httpx
import pytest

from motionlab.server.settings import Settings
from tests.server.live import Live, Stream
from tests.server.servers import Server

MakeServer = Callable[[Settings], Server]
MakeLive = Callable[..., Live]
Connect = Callable[..., Stream]


@pytest.fixture
def make_server() -> Iterator[MakeServer]:
    """Start further servers, with settings of their own."""
    with contextlib.ExitStack() as ended:

        def make(settings: Settings) -> Server:
            server = Server(settings)
            ended.callback(server.stop)
            return server

        yield make


@pytest.fixture
def make_live(client: httpx.Client) -> Iterator[MakeLive]:
    """Create sessions that are deleted when the test is over."""
    with contextlib.ExitStack() as ended:

        def make(scenario: Any = "circle", changes: dict[str, Any] | None = None) -> Live:
            live = Live.create(client, scenario, changes)
            ended.callback(live.delete)
            return live

        yield make


@pytest.fixture
def live(make_live: MakeLive) -> Live:
    """Return a session of the circle, paused at tick 0."""
    return make_live()


@pytest.fixture
def connect(server: Server, live: Live) -> Iterator[Connect]:
    """Open streams of the session, greeted, that are closed when the test is over."""
    with contextlib.ExitStack() as ended:

        def make(**options: Any) -> Stream:
            stream = ended.enter_context(Stream(server, live.id, **options))
            stream.message("hello")
            return stream

        yield make
