"""The telemetry stream: latency at its clients, a client that does not read, load of the server."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

from tests.bench.clients import COLUMNS
from tests.bench.serving import Serving
from tests.bench.table import Row

_LATENCY = 0.02  # s
_GROWTH = 1.0  # MB
_CPU = 0.05  # of a core
_FILL = 20_000, 3  # ticks of a step, steps: the ring is full, so that it grows no more
_FROZEN_WINDOWS = 2  # of 4 s


def stream() -> Iterator[Row]:
    """Watch one session with 1, 20 and 100 clients, then with one of the 100 frozen."""
    with Serving() as server:
        session = server.post("/sessions", scenario="circle")["id"]
        ticks, steps = _FILL
        for _ in range(steps):
            server.post(f"/sessions/{session}/step", ticks=ticks)
        one, cpu, _ = watch(server, session, "--clients", "1")
        yield _latency(1, one, "sleep late", one["oversleep"])
        twenty, _, _ = watch(server, session, "--clients", "20")
        yield _latency(20, twenty, "1 client", _best(one))
        # Once for what a hundred connections allocate, so that the next growth is that of time.
        hundred, load, grown = watch(server, session, "--clients", "100")
        yield _latency(100, hundred, "1 client", _best(one))
        more = ("--clients", "101", "--frozen", "1", "--windows", str(_FROZEN_WINDOWS))
        frozen, _, growth = watch(server, session, *more)
        what = "  while another is frozen for 8 s"
        yield _latency(100, frozen, "none frozen", _best(hundred), what)
        yield Row(
            "  server memory meanwhile",
            f"<= {_GROWTH:g} MB more",
            f"{growth / 1e6:+.2f} MB",
            f"none frozen: {grown / 1e6:+.2f}",
            "",
            growth <= _GROWTH * 1e6,
        )
        yield Row(
            "session at 1x, 1 client: server's processor",
            f"<= {_CPU:.0%} of a core",
            f"{cpu:.1%}",
            f"100 clients: {load:.0%}",
            "",
            cpu <= _CPU,
        )


def watch(server: Serving, session: str, *options: str) -> tuple[dict[str, Any], float, int]:
    """Watch a session; return its client's figures, the load of a core and growth in bytes."""
    with watching(server, session, *options) as process:
        assert process.stdin is not None and process.stdout is not None
        memory, used, before = server.resident(), server.cpu(), time.perf_counter()
        figures = json.loads(process.stdout.readline())
        load = (server.cpu() - used) / (time.perf_counter() - before)
        growth = server.resident() - memory
        process.stdin.write("\n")
        process.stdin.flush()
    return figures, load, growth


@contextlib.contextmanager
def watching(server: Serving, session: str, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Provide the process of clients of a session that plays."""
    # A session's name may begin with a dash.
    where = ("--", str(server.port), session)
    command = (sys.executable, "-m", "tests.bench.clients", *options, *where)
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        if process.stdout.readline() != "playing\n":
            raise RuntimeError("the clients failed")
        yield process


def _best(figures: dict[str, Any]) -> float:
    """Return p99 of the window that the rest of the machine disturbed least, s."""
    return min(window["p99"] for window in figures["windows"])


def _latency(
    clients: int, figures: dict[str, Any], reference: str, value: float, what: str = ""
) -> Row:
    best = _best(figures)
    return Row(
        what or f"stream, {COLUMNS} channels, 2 kHz, {clients} client{'s' * (clients > 1)}",
        f"p99 <= {_LATENCY * 1e3:g} ms",
        f"p99 {best * 1e3:.1f} ms",
        f"{reference}: {value * 1e3:.1f} ms",
        f"{best / value:.2f}",
        best <= _LATENCY,
    )
