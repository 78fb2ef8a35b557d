"""``python -m tests.bench.probe``: how soon a session is stopped, asked by a process of its own.

A session plays; it is stopped, reset and played again, ten times a second. What is timed is the
stop, from before the request is sent until the answer has been read: on a connection that is kept
open, and every other time on a new one.
"""

from __future__ import annotations

import http.client
import json
import selectors
import sys
import time

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


def main() -> None:
    """Probe until a line comes on standard input, then print what was measured."""
    probe = Probe(int(sys.argv[1]))
    print("probing", flush=True)
    ended = selectors.DefaultSelector()
    ended.register(sys.stdin, selectors.EVENT_READ)
    stops: list[float] = []
    healths: list[float] = []
    errors: list[str] = []
    while not ended.select(_PERIOD):
        try:
            stops.append(probe.stop(anew=len(stops) % 2 == 1))
            healths.append(probe.health())
        except (OSError, RuntimeError, http.client.HTTPException) as error:
            errors.append(repr(error))
            probe._kept.close()
    print(json.dumps({"stop": stops, "health": healths, "errors": errors}), flush=True)


if __name__ == "__main__":
    main()
