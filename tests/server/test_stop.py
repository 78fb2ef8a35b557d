"""STOP waits for nothing that a session prepares, computes or writes."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import inspect
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import anyio.to_thread
import httpx
import pytest
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute, iter_route_contexts

from motionlab.config.drive import load_drive
from motionlab.errors import ConfigError, FieldError
from motionlab.server.app import create_app
from motionlab.server.http import compression, strict_json
from motionlab.server.settings import Settings
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live, Stream, until
from tests.server.servers import PATIENCE, Server

MASS = {"plant.x.mass": 7.0}
ENDS = {"trajectory": {"kind": "line", "end": {"x": 0.001}, "edge_time": 0.4, "dwell": 0.1}}


class Gate:
    """Holds up a function of the server until it is let through."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, module: str, name: str) -> None:
        self.reached = threading.Event()
        self.let_through = threading.Event()
        held_up = getattr(importlib.import_module(module), name)

        def gated(*args: Any, **kwargs: Any) -> Any:
            self.reached.set()
            assert self.let_through.wait(PATIENCE)
            return held_up(*args, **kwargs)

        monkeypatch.setattr(f"{module}.{name}", gated)


def create(live: Live) -> None:
    Live.create(live.client).delete()


@pytest.mark.parametrize(
    ("module", "name", "ask"),
    [
        ("motionlab.server.live.session", "changed", lambda live: live.change(MASS)),
        ("motionlab.server.live.session", "ready", lambda live: live.change(MASS)),
        ("motionlab.server.live.paced", "Simulation", lambda live: live.do("reset")),
        (
            "motionlab.server.live.session",
            "latest_metrics",
            lambda live: live.client.get(f"{live.path}/metrics"),
        ),
        ("numpy", "save", lambda live: live.columns()),
        ("motionlab.server.routes.sessions", "prepare_request", create),
    ],
    ids=["check", "lanes", "reset", "metrics", "telemetry", "create"],
)
def test_a_stop_does_not_wait_for(
    monkeypatch: pytest.MonkeyPatch,
    make_live: MakeLive,
    module: str,
    name: str,
    ask: Callable[[Live], Any],
) -> None:
    live = make_live()
    live.do("play")
    gate = Gate(monkeypatch, module, name)
    with ThreadPoolExecutor(1) as asked:
        pending = asked.submit(ask, live)
        try:
            assert gate.reached.wait(PATIENCE)
            assert live.do("stop")["state"] == "stopping"
            until(lambda: live.state == "stopped")
            assert not pending.done()
        finally:
            gate.let_through.set()
        pending.result(PATIENCE)


@contextlib.contextmanager
def without_threads(server: Server) -> Iterator[None]:
    """Occupy every thread that requests share: AnyIO's, asyncio's and those of sessions."""
    over = threading.Event()

    async def occupy() -> list[asyncio.Future[Any]]:
        loop = asyncio.get_running_loop()
        limiter = anyio.to_thread.current_default_thread_limiter()
        tokens = int(limiter.total_tokens)
        taken = [asyncio.ensure_future(anyio.to_thread.run_sync(over.wait)) for _ in range(tokens)]
        pools = (None, server.app.state.sessions.threads, strict_json._READER)
        taken += [loop.run_in_executor(pool, over.wait) for pool in pools for _ in range(64)]
        while limiter.available_tokens:
            await asyncio.sleep(0.001)
        return taken

    async def end(taken: list[asyncio.Future[Any]]) -> None:
        await asyncio.gather(*taken)

    taken = server.call(occupy())
    try:
        yield
    finally:
        over.set()
        server.call(end(taken))


def test_a_stop_needs_no_thread_of_requests(make_live: MakeLive, server: Server) -> None:
    stopped, deleted = make_live(), make_live()
    for live in (stopped, deleted):
        live.do("play")
    with without_threads(server):
        assert stopped.do("stop")["state"] == "stopping"
        assert stopped.client.delete(deleted.path).status_code == 204
        assert stopped.client.get(f"{API}/health").status_code == 200
        assert stopped.client.post(f"{API}/drive/stop").status_code == 404  # has no link
    until(lambda: stopped.state == "stopped")


def test_the_answer_to_a_stop_is_not_compressed_in_its_turn(
    make_live: MakeLive, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    live = make_live()
    monkeypatch.setattr("motionlab.server.http.compression._IN_THREAD", 0)
    gate = Gate(monkeypatch, "motionlab.server.http.compression", "_gzip")
    with ThreadPoolExecutor(8) as clients:
        pending = [clients.submit(live.client.get, f"{API}/schema") for _ in range(2)]
        until(lambda: not compression._places._value)
        try:
            answer = live.post("stop")
            assert (answer.status_code, "content-encoding" in answer.headers) == (200, False)
        finally:
            gate.let_through.set()
        for each in pending:
            assert each.result(PATIENCE).headers["content-encoding"] == "gzip"


def dependencies(dependant: Dependant) -> Iterator[Callable[..., Any]]:
    for each in dependant.dependencies:
        if each.call is not None:
            yield each.call
        yield from dependencies(each)


def test_no_request_waits_for_a_thread_to_find_what_it_is_about() -> None:
    contexts = list(iter_route_contexts(create_app(Settings(drive=load_drive("virtual"))).routes))
    routes = [each.original_route for each in contexts if isinstance(each.original_route, APIRoute)]
    calls = {call for route in routes for call in dependencies(route.dependant)}
    assert {call.__name__ for call in calls} >= {"find_session", "drives_of"}
    assert [call for call in calls if not inspect.iscoroutinefunction(call)] == []
    stops = {
        each.path: each.endpoint
        for each in contexts
        if str(each.path).endswith("/stop")
        or (each.path == f"{API}/sessions/{{session_id}}" and "DELETE" in (each.methods or ()))
    }
    assert len(stops) == 3
    assert all(map(inspect.iscoroutinefunction, stops.values()))


@contextlib.contextmanager
def held_slice(server: Server, live: Live) -> Iterator[threading.Event]:
    """Hold up a session in its next slice, under its lock; the event is set once it is there."""
    (session,) = [s for s in server.app.state.sessions.all() if s.id == live.id]
    record = session.history.record
    begun, go_on = threading.Event(), threading.Event()

    def slowly(simulation: Any, ticks: int) -> None:
        record(simulation, ticks)
        begun.set()
        assert go_on.wait(PATIENCE)

    session.history.record = slowly
    try:
        yield begun
    finally:
        go_on.set()


def test_a_stop_ends_a_step(make_live: MakeLive, server: Server) -> None:
    live = make_live()
    with ThreadPoolExecutor(1) as asked:
        with held_slice(server, live) as begun:
            step = asked.submit(live.do, "step", ticks=20_000)
            assert begun.wait(PATIENCE)
            assert live.do("stop")["state"] == "stopping"
            assert live.do("stop")["state"] == "stopping"
            assert not step.done()
        assert step.result(PATIENCE)["tick"] < 20_000
    until(lambda: live.state == "stopped")


@pytest.mark.parametrize(
    ("command", "body"),
    [("push", {"axis": "x", "force": 1.0, "duration": 0.1}), ("pause", {}), ("play", {})],
)
def test_no_stop_waits_where_another_command_waits_for_a_slice(
    make_live: MakeLive, server: Server, command: str, body: dict[str, Any]
) -> None:
    live, other = make_live(), make_live()
    other.do("play")
    (session,) = [s for s in server.app.state.sessions.all() if s.id == live.id]
    with ThreadPoolExecutor(2) as asked:
        with held_slice(server, live) as begun:
            step = asked.submit(live.do, "step", ticks=20_000)
            assert begun.wait(PATIENCE)
            pending = asked.submit(live.post, command, **body)
            until(lambda: session._lock.waiting == 1)
            assert other.do("stop")["state"] == "stopping"
            assert live.do("stop")["state"] == "stopping"
            assert not pending.done()
        assert pending.result(PATIENCE).status_code == 409
        step.result(PATIENCE)
    until(lambda: live.state == "stopped")
    until(lambda: other.state == "stopped")


def test_a_stop_that_comes_with_the_end_of_a_motion_is_not_lost(
    make_live: MakeLive, server: Server
) -> None:
    live = make_live(changes=ENDS)
    live.do("step", ticks=live.info()["ends"] - 100)
    with ThreadPoolExecutor(1) as asked:
        with held_slice(server, live) as begun:
            step = asked.submit(live.do, "step", ticks=200)
            assert begun.wait(PATIENCE)
            assert live.tick == live.info()["ends"]
            live.do("stop")
        step.result(PATIENCE)
    until(lambda: live.state == "stopped")


def test_a_scheduled_change_is_published(server: Server, make_live: MakeLive) -> None:
    schedule = [{"time": 0.1, "set": {"variants.A.controller.x.k_p": 250_000.0}}]
    live = make_live(changes={"schedule": schedule})
    with Stream(server, live.id) as stream:
        stream.message("hello")
        live.do("step", ticks=199)
        before = stream.message("session")["session"]
        assert k_p(before) != 250_000.0
        live.do("play")
        while k_p(shown := stream.message("session")["session"]) != 250_000.0:
            pass
        assert shown["revision"] > before["revision"]
        assert shown["changes"] == []  # the schedule's are none of a user


def k_p(session: dict[str, Any]) -> float:
    return session["scenario"]["variants"]["A"]["controller"]["x"]["k_p"]


@pytest.mark.parametrize("state", ["stopping", "stopped", "finished"])
def test_a_push_that_cannot_act_is_refused(make_live: MakeLive, state: str) -> None:
    live = make_live(changes=ENDS)
    if state == "finished":
        live.step(live.info()["ends"])
    else:
        live.do("play")
        live.do("stop")
    if state == "stopped":
        until(lambda: live.state == "stopped")
    answer = live.post("push", axis="x", force=10.0)
    assert answer.status_code == 409
    assert live.state in answer.json()["detail"] or state == "stopping"


def test_a_refused_create_evicts_nobody(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = make_server(Settings(sessions_max=1))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        idle = Live.create(client)
        for session in server.app.state.sessions.all():
            session.touched -= 1000.0

        def check(_: int) -> None:
            raise ConfigError(FieldError("trajectory", "takes more memory than may be used"))

        monkeypatch.setattr(server.app.state.memory, "check", check)
        assert client.post(f"{API}/sessions", json={}).status_code == 422
        assert idle.state == "paused"
