"""``python -m tests.bench.probe``: how soon a session is stopped, asked by a process of its own.

A session plays; it is stopped, reset and played again, ten times a second. What is timed is the
stop, from before the request is sent until the answer has been read: on a connection that is kept
open, and every other time on a new one. An echo of a bare asyncio server in a further process, in
the same moments, is the floor of the machine.
"""

from __future__ import annotations

import asyncio
import http.client
import json
import multiprocessing
import selectors
import socket
import sys
import time
from multiprocessing.connection import Connection

_PERIOD = 0.1  # s
_PATIENCE = 60.0  # s


class Probe:
    """Stops a session again and again.

    Parameters
    ----------
    port : int
        Where the server listens.
    """

    def __init__(self, port: int) -> None:
        self._port = port
        self._kept = self._connect()
        session = json.loads(self._ask(self._kept, "POST", "/sessions", {}))
        self._path = f"/sessions/{session['id']}"

    def stop(self, anew: bool) -> float:
        """Return how long a stop takes, s."""
        self._ask(self._kept, "POST", f"{self._path}/reset")
        self._ask(self._kept, "POST", f"{self._path}/play")
        begun = time.perf_counter()
        connection = self._connect() if anew else self._kept
        self._ask(connection, "POST", f"{self._path}/stop")
        taken = time.perf_counter() - begun
        if anew:
            connection.close()
        return taken

    def health(self) -> float:
        """Return how long the simplest request takes on a new connection, s."""
        begun = time.perf_counter()
        connection = self._connect()
        self._ask(connection, "GET", "/health")
        connection.close()
        return time.perf_counter() - begun

    def _connect(self) -> http.client.HTTPConnection:
        return http.client.HTTPConnection("127.0.0.1", self._port, timeout=_PATIENCE)

    def _ask(
        self, connection: http.client.HTTPConnection, method: str, path: str, body: object = None
    ) -> bytes:
        text = None if body is None else json.dumps(body)
        headers = {} if body is None else {"Content-Type": "application/json"}
        connection.request(method, f"/api/v1{path}", text, headers)
        answer = connection.getresponse()
        content = answer.read()
        if answer.status >= 300:
            raise RuntimeError(f"{method} {path}: {answer.status} {content[:200]!r}")
        return content


class Echo:
    """A bare asyncio server in a process of its own, and a connection to it."""

    def __init__(self) -> None:
        ours, theirs = multiprocessing.Pipe()
        multiprocessing.Process(target=_serve_echo, args=(theirs,), daemon=True).start()
        self._connection = socket.create_connection(("127.0.0.1", ours.recv()), _PATIENCE)

    def time(self) -> float:
        """Return how long a few bytes take there and back, s."""
        begun = time.perf_counter()
        self._connection.sendall(b"echo")
        self._connection.recv(4)
        return time.perf_counter() - begun


def _serve_echo(port: Connection) -> None:
    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while data := await reader.read(4):
            writer.write(data)

    async def serve() -> None:
        server = await asyncio.start_server(echo, "127.0.0.1", 0)
        port.send(server.sockets[0].getsockname()[1])
        await server.serve_forever()

    asyncio.run(serve())


def main() -> None:
    """Probe until a line comes on standard input, then print what was measured."""
    echo = Echo()
    probe = Probe(int(sys.argv[1]))
    print("probing", flush=True)
    ended = selectors.DefaultSelector()
    ended.register(sys.stdin, selectors.EVENT_READ)
    stops: list[float] = []
    healths: list[float] = []
    echoes: list[float] = []
    errors: list[str] = []
    while not ended.select(_PERIOD):
        try:
            stops.append(probe.stop(anew=len(stops) % 2 == 1))
            echoes.append(echo.time())
            healths.append(probe.health())
        except (OSError, RuntimeError, http.client.HTTPException) as error:
            errors.append(repr(error))
            probe._kept.close()
    measured = {"stop": stops, "health": healths, "echo": echoes, "errors": errors}
    print(json.dumps(measured), flush=True)


if __name__ == "__main__":
    main()
