"""Servers for tests: the application behind uvicorn in a thread, on a free loopback port."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

import uvicorn
from fastapi import FastAPI

from motionlab.server.app import create_app
from motionlab.server.serve import configuration, listen
from motionlab.server.settings import Settings
from tests.server import forkservers

PATIENCE = 120.0
"""Seconds after which a test gives up; nothing is expected to take a noticeable part of it."""

T = TypeVar("T")


class Server:
    """A running server; its application and its event loop are at hand for counting.

    Parameters
    ----------
    settings : Settings, optional
        Loopback without a token when left out.
    """

    def __init__(self, settings: Settings | None = None) -> None:
        forkservers.install()
        self.app: FastAPI = create_app(settings)
        self._listener = listen("127.0.0.1", 0)
        self.port: int = self._listener.getsockname()[1]
        config = configuration(self.app, log_level="critical")
        self._uvicorn = uvicorn.Server(config)
        self.loop = asyncio.new_event_loop()
        self._started = threading.Event()
        self._thread = threading.Thread(target=self._run, name="server")
        self._thread.start()
        assert self._started.wait(PATIENCE)

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    def stream(self, session_id: str) -> str:
        """Return the address of a session's stream."""
        return f"ws://127.0.0.1:{self.port}/api/v1/sessions/{session_id}/stream"

    def call(self, work: Coroutine[Any, Any, T]) -> T:
        """Return what `work` returns in the server's event loop."""
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(PATIENCE)

    @property
    def listeners(self) -> int:
        """Streams of all sessions."""
        return sum(len(session.listeners) for session in self.app.state.sessions.all())

    @property
    def unsent(self) -> list[int]:
        """Bytes that wait in this process for each connection, until the kernel takes them."""

        async def count() -> list[int]:
            connections = self._uvicorn.server_state.connections
            transports = [c.transport for c in connections]  # pyright: ignore
            return [t.get_write_buffer_size() for t in transports if t is not None]

        return self.call(count())

    def stop(self) -> None:
        """End the server and wait until it is gone."""
        self._uvicorn.should_exit = True
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        self._listener.close()
        self.loop.close()

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        self.loop.run_until_complete(self._serve())

    async def _serve(self) -> None:
        serving = asyncio.create_task(self._uvicorn.serve(sockets=[self._listener]))
        while not self._uvicorn.started and not serving.done():
            await asyncio.sleep(0.005)
        self._started.set()
        await serving
