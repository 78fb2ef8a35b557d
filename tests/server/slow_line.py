"""A line of little bandwidth between clients and a server."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from types import TracebackType
from typing import Self

_PIECE = 1400  # bytes, as of a packet
_BUFFER = 4096  # bytes, of a kernel's buffer of a connection
_CLOSING = 0.05  # s in which connections that were aborted close


class SlowLine:
    """Passes connections on to a port of this machine, a number of bytes a second for all of them.

    Parameters
    ----------
    port : int
        Where to.
    rate : float
        From the server to all clients, bytes/s; may be changed.
    delay : float
        Either way, s.
    """

    def __init__(self, port: int, rate: float, delay: float = 0.0) -> None:
        self._to, self.rate, self._delay = port, rate, delay
        self.port = 0
        self._free = 0.0
        self._loop = asyncio.new_event_loop()
        self._began = threading.Event()
        self._thread = threading.Thread(target=self._run, name="slow line")

    def __enter__(self) -> Self:
        self._thread.start()
        assert self._began.wait(30.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._loop.call_soon_threadsafe(self._ends.set)
        self._thread.join()

    def stream(self, session_id: str) -> str:
        """Return the address of a session's stream."""
        return f"ws://127.0.0.1:{self.port}/api/v1/sessions/{session_id}/stream"

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._serve())
        self._loop.close()

    async def _serve(self) -> None:
        self._ends = asyncio.Event()
        listener = socket.create_server(("127.0.0.1", 0))
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
        server = await asyncio.start_server(self._connect, sock=listener, limit=_BUFFER)
        self.port = listener.getsockname()[1]
        self._began.set()
        await self._ends.wait()
        server.close()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.sleep(_CLOSING)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        upstream = socket.socket()
        upstream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        upstream.setblocking(False)
        await self._loop.sock_connect(upstream, ("127.0.0.1", self._to))
        answers, requests = await asyncio.open_connection(sock=upstream, limit=_BUFFER)
        ways = (self._pass(answers, writer, slow=True), self._pass(reader, requests, slow=False))
        tasks = [asyncio.create_task(way) for way in ways]
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        except asyncio.CancelledError:  # the line ends; who made this task reads its exception
            pass
        finally:
            for task in tasks:
                task.cancel()
            requests.transport.abort()
            writer.transport.abort()

    async def _pass(
        self, source: asyncio.StreamReader, target: asyncio.StreamWriter, *, slow: bool
    ) -> None:
        """Pass on what comes, each piece in its turn on the line and then after the delay."""
        under_way: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()

        async def arrive() -> None:
            while True:
                due, data = await under_way.get()
                await asyncio.sleep(due - time.monotonic())
                target.write(data)
                await target.drain()

        arriving = asyncio.create_task(arrive())
        try:
            while data := await source.read(_PIECE):
                now = time.monotonic()
                if slow:
                    self._free = max(self._free, now) + len(data) / self.rate
                    await asyncio.sleep(self._free - now)
                under_way.put_nowait((time.monotonic() + self._delay, data))
        finally:
            arriving.cancel()
