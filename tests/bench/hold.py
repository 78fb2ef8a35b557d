"""How a server holds: STOP, memory and other clients under load and under attack."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from motionlab.server.memory_budget import recordable
from motionlab.server.settings import Settings
from tests.bench import attacks
from tests.bench.attacks import Client, again, under
from tests.bench.serving import Serving
from tests.bench.table import Row

_P99, _WORST = 0.05, 0.25  # s
_STREAM = 0.03  # s
_SECONDS = 12.0  # of each attack
_MORE = 500_000_000  # bytes beyond memory_max
_LONG = {"scenario": "fig5", "exact": True, "set": {}}


@dataclass
class Held:
    """What was measured while something went on.

    Attributes
    ----------
    stop, health, echo : ndarray
        How long each stop, each GET /health and each echo of a bare server took, s.
    errors : list of str
        Stops that failed.
    peak : int
        Most resident memory of the server and its child processes, bytes.
    """

    stop: np.ndarray
    health: np.ndarray
    echo: np.ndarray
    errors: list[str]
    peak: int


def hold() -> Iterator[Row]:
    """Measure STOP at rest, under the mix of everything lawful, and under each attack."""
    with Serving() as server:
        server.warm()
        client = Client(server.port)
        quiet = _held(server, contextlib.nullcontext())
        yield from _rows("at rest", quiet, None)
        yield from _mix(server, client, quiet)
    for what, prepared, threads in _attacks():
        with Serving() as server:
            server.warm()
            client = Client(server.port)
            attack = prepared(client)
            yield from _rows(what, _held(server, under(attack, client, threads)), quiet)


def _attacks() -> Iterator[tuple[str, Callable[[Client], attacks.Attack], int]]:
    """Yield a name, what prepares the attack, and from how many threads it comes."""
    wide = attacks.wide(100)
    gain = {"set": {"variants.B.controller.x.k_p": 210_000.0}}
    swapped = {f"variants.{v}.controller": "lugre-observer" for v in attacks.VARIANTS}
    texts = {f"variants.A.controller.x.k_p{i}": "x" for i in range(4000)}
    yield "sessions of 26 variants x 100 events", lambda c: again("POST", "/sessions", wide), 2
    yield "PATCH, 26 variants x 100 events", lambda c: _on(c, wide, "PATCH", "parameters", gain), 4
    yield (
        "PATCH of 26 controllers by name",
        lambda c: _on(c, wide, "PATCH", "parameters", {"set": swapped}),
        4,
    )
    yield "PATCH of 4000 texts", lambda c: _on(c, {}, "PATCH", "parameters", {"set": texts}), 4
    yield "reset, 26 variants x 100 events", lambda c: _on(c, wide, "POST", "reset"), 4
    yield (
        "step of 20000, 26 variants",
        lambda c: _on(c, attacks.wide(0), "POST", "step", {"ticks": 20_000}),
        4,
    )
    yield (
        "44 TOML bombs",
        lambda c: again("POST", "/scenarios/parse", attacks.BOMB, media="text/plain"),
        44,
    )
    for what, body in attacks.BODIES.items():
        yield f"80 clients, 250 kB {what}", lambda c, b=body: again("POST", "/simulate", b), 80
    yield "4 clients, 60 kB of equal headers", _equal_headers, 4
    yield "garbage by one websocket", lambda c: attacks.flood(1, b"garbage"), 1
    yield "pings that two never read", lambda c: attacks.flood(9, b"ping"), 2
    yield "10000 websockets", lambda c: attacks.many_websockets, 1
    yield "2000 slow bodies", lambda c: attacks.slow_bodies, 1
    yield "24 unread CSV", _unread, 8
    yield "CSV of 26 variants", _files, 3
    yield "50 browsers that drag", lambda c: attacks.dragging, 50
    columns = [f"{v}.{a}.following_error" for v in "AB" for a in "xy"]
    yield (
        "three what-ifs of 512 columns, 180 s",
        lambda c: again("POST", "/whatif", _LONG | {"columns": (128 * columns)}),
        3,
    )


def _on(client: Client, body: Any, method: str, what: str, asked: Any = None) -> attacks.Attack:
    """Return an attack on a session of its own."""
    return again(method, f"{client.session(body)}/{what}", asked)


def _equal_headers(_: Client) -> attacks.Attack:
    path = "/runs/import?preview=true"
    return again("POST", path, attacks.EQUAL_HEADERS, media="application/octet-stream")


def _unread(client: Client) -> attacks.Attack:
    return attacks.unread_files(_filled(client, {}), "csv")


def _files(client: Client) -> attacks.Attack:
    return again("GET", f"{_filled(client, attacks.wide(0))}/telemetry?format=csv")


def _filled(client: Client, body: Any) -> str:
    """Return a session whose ring is full."""
    session = client.session(body)
    for _ in range(3):
        client.ask("POST", f"{session}/step", {"ticks": 20_000})
    return session


def _mix(server: Serving, client: Client, quiet: Held) -> Iterator[Row]:
    """31 sessions at 10x, 60 downloads, two jobs, 20 what-ifs a second, 400 stream clients."""
    watched = client.session().rpartition("/")[2]
    with contextlib.ExitStack() as load:
        clients = load.enter_context(attacks.watchers(client, watched, 400, 2 * _SECONDS))
        sessions = [client.session() for _ in range(29)]  # two more: the watched one, the probe's
        for session in sessions:
            client.ask("POST", f"{session}/play", {"speed": 10.0})
        for session in sessions[:10]:
            load.enter_context(
                under(again("GET", f"{session}/telemetry?format=csv"), client, threads=6)
            )
        load.enter_context(under(attacks.jobs, client))
        load.enter_context(under(attacks.what_ifs(20.0), client))
        held = _held(server, contextlib.nullcontext())
        assert clients.stdout is not None
        figures = json.loads(clients.stdout.readline())
    yield from _rows("mix: 31 x 10, files, jobs, what-ifs, 400", held, quiet)
    (window,) = figures["windows"]
    yield Row(
        "  its 400 stream clients",
        f"p99 <= {_STREAM * 1e3:g} ms",
        f"p99 {window['p99'] * 1e3:.0f} ms",
        f"{window['frames']:.0f} frames/s",
        f"{figures['dropped']} gone",
        window["p99"] <= _STREAM,
    )


def _held(server: Serving, load: contextlib.AbstractContextManager[Any]) -> Held:
    """Probe while `load` lasts."""
    command = (sys.executable, "-m", "tests.bench.probe", str(server.port))
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        if process.stdout.readline() != "probing\n":
            raise RuntimeError("the probe failed")
        peak = _Peak(server)
        with load:
            time.sleep(_SECONDS)
            process.stdin.write("\n")
            process.stdin.flush()
            got = json.loads(process.stdout.readline())
    stop, health, echo = (np.array(got[name]) for name in ("stop", "health", "echo"))
    return Held(stop, health, echo, got["errors"], peak.end())


class _Peak:
    """Watches the memory of a server."""

    def __init__(self, server: Serving) -> None:
        self._server = server
        self._most = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def end(self) -> int:
        """Return the most that was seen, bytes."""
        self._over.set()
        self._thread.join()
        return self._most

    def _watch(self) -> None:
        while not self._over.wait(0.1):
            self._most = max(self._most, self._server.tree())


def _rows(what: str, held: Held, quiet: Held | None) -> Iterator[Row]:
    if len(held.stop) == 0:
        yield Row(what, "an answer", f"none: {held.errors[:1]}", met=False)
        return
    p99, worst = np.percentile(held.stop, 99), held.stop.max()
    floor, floor_worst = np.percentile(held.echo, 99), held.echo.max()
    yield Row(
        f"STOP, {what}",
        f"{_P99 * 1e3:g}, {_WORST * 1e3:g} ms",
        f"{np.median(held.stop) * 1e3:.1f}, {p99 * 1e3:.1f}, {worst * 1e3:.0f} ms",
        f"echo: {np.median(held.echo) * 1e3:.1f}, {floor * 1e3:.1f}, {floor_worst * 1e3:.0f} ms",
        "" if quiet is None else f"{p99 / np.percentile(quiet.stop, 99):.1f}",
        bool(p99 - floor <= _P99 and worst - floor_worst <= _WORST and not held.errors),
    )
    most = recordable(Settings().memory_max) + _MORE
    yield Row(
        f"  memory; {len(held.stop)} stops, {len(held.errors)} failed",
        f"<= {most / 1e9:.1f} GB",
        f"{held.peak / 1e9:.2f} GB",
        f"health: p99 {np.percentile(held.health, 99) * 1e3:.0f} ms",
        "",
        held.peak <= most,
    )
