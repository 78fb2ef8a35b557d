"""Worker processes: what they return and raise, how they end, and that none is left behind."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from fastapi import HTTPException

from motionlab.errors import ConfigError, Infeasible, StoreFull
from motionlab.server.settings import Settings
from motionlab.server.workers import pool
from motionlab.server.workers.channel import Failure
from motionlab.server.workers.pool import Workers
from tests.processes import runs
from tests.server import calls
from tests.server.conftest import MakeServer
from tests.server.live import API, until
from tests.server.servers import PATIENCE, Server


def run(server: Server, function: Callable[..., Any], *arguments: Any, **how: Any) -> Any:
    """Return what a worker returns."""

    async def asked() -> Any:
        answer = await server.app.state.workers.run(function, *arguments, **how)
        value = answer.value if answer.contents is None else answer.contents.read()
        answer.close()
        return value

    return server.call(asked())


def pids(server: Server) -> list[int]:
    """Return the processes of the pool."""
    return sorted(worker.pid for worker in server.app.state.workers._alive)


def taken(server: Server) -> int:
    return server.app.state.memory._taken


def test_a_call_is_carried_out_elsewhere_by_the_same_process_again(server: Server) -> None:
    first = run(server, calls.identity)
    assert first != os.getpid()
    assert run(server, calls.identity) == first  # whose caches are warm


def test_a_worker_is_niced_and_knows_no_secret(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_TOKEN", "x" * 16)
    server = make_server(Settings())
    assert run(server, calls.priority) > 0
    assert "MOTIONLAB_TOKEN" not in run(server, calls.environment)


def test_a_worker_sees_the_folders_of_the_server(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_CONFIGS", "elsewhere")
    assert "MOTIONLAB_CONFIGS" in run(server, calls.environment)
    monkeypatch.delenv("MOTIONLAB_CONFIGS")
    assert "MOTIONLAB_CONFIGS" not in run(server, calls.environment)


@pytest.mark.parametrize("size", [0, 256, 30_000_000])
def test_bytes_come_whole(server: Server, size: int) -> None:
    content = run(server, calls.text, size)
    assert content == bytes(range(256)) * (size // 256)


def test_failures_come_with_all_that_they_say(server: Server) -> None:
    with pytest.raises(ConfigError) as refused:
        run(server, calls.refuse)
    assert refused.value.errors == (calls.FIELD,)
    assert str(refused.value) == str(calls.FIELD)
    with pytest.raises(Infeasible) as infeasible:
        run(server, calls.fail_to_follow)
    assert vars(infeasible.value).items() >= calls.PLACE.items()
    with pytest.raises(StoreFull, match="no room"):
        run(server, calls.fill)
    with pytest.raises(ZeroDivisionError) as unforeseen:
        run(server, calls.divide)
    assert "return 1 / 0" in unforeseen.value.__notes__[0]


@pytest.mark.parametrize("error", [SystemExit(3), KeyboardInterrupt(), GeneratorExit()])
def test_what_ends_a_process_ends_no_more_than_its_call(error: BaseException) -> None:
    failed = Failure.of(error).error()
    assert isinstance(failed, RuntimeError)
    assert str(failed).startswith(type(error).__name__)


def test_a_call_that_takes_too_long_is_given_up_and_its_process_replaced(
    make_server: MakeServer,
) -> None:
    server = make_server(Settings(workers=1))
    run(server, calls.identity)
    until(lambda: len(pids(server)) == 2)
    before = pids(server)
    with pytest.raises(HTTPException) as late:
        run(server, calls.sleep, 60.0, seconds=0.1)
    assert late.value.status_code == 503
    assert "0.1 s" in late.value.detail
    until(lambda: len(pids(server)) == 2 and pids(server) != before)
    (gone,) = set(before) - set(pids(server))
    until(lambda: not runs(gone))
    assert run(server, calls.identity) in pids(server)


@pytest.mark.parametrize(
    ("function", "reason"), [(calls.leave, "status 3"), (calls.hold_and_die, "SIGKILL")]
)
def test_a_process_that_ends_ends_its_call_with_the_reason(
    server: Server, function: Callable[..., Any], reason: str
) -> None:
    arguments = () if function is calls.leave else (1000,)
    before = taken(server)
    with pytest.raises(HTTPException) as lost:
        run(server, function, *arguments)
    assert lost.value.status_code == 503
    assert reason in lost.value.detail
    assert taken(server) == before
    assert run(server, calls.identity) in pids(server)


def test_memory_that_was_not_asked_for_is_bounded(server: Server) -> None:
    with pytest.raises(HTTPException) as refused:
        run(server, calls.allocate, 3_000_000_000)
    assert refused.value.status_code == 503
    assert "memory" in refused.value.detail
    assert run(server, calls.allocate, 1000) == 1000


def test_memory_is_held_until_the_answer_has_been_passed_on(make_server: MakeServer) -> None:
    server = make_server(Settings(memory_max=1000))
    with pytest.raises(ConfigError, match="memory_max"):
        run(server, calls.hold, 1001)

    async def asked() -> None:
        answer = await server.app.state.workers.run(calls.hold, 600)
        assert taken(server) == 600
        with pytest.raises(HTTPException, match="600 of 1000"):
            await server.app.state.workers.run(calls.hold, 600)
        answer.close()
        assert taken(server) == 0

    server.call(asked())
    assert run(server, calls.hold, 1000) == b"held"


def test_a_process_that_has_grown_is_replaced(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool, "_RESIDENT_MAX", 400_000_000)
    grown = run(server, calls.grow, 400_000_000)
    until(lambda: not runs(grown))
    until(lambda: grown not in pids(server))
    assert run(server, calls.identity) != grown


def test_calls_wait_for_their_turn_and_too_many_are_refused(make_server: MakeServer) -> None:
    server = make_server(Settings(workers=1, waiting_max=2))
    workers: Workers = server.app.state.workers
    run(server, calls.identity)

    async def asked() -> None:
        order: list[int] = []

        async def one(number: int) -> None:
            (await workers.run(calls.work, 0.5)).close()
            order.append(number)

        tasks = [asyncio.create_task(one(number)) for number in range(3)]
        while len(workers._turns[False]) != 2:
            await asyncio.sleep(0.005)
        with pytest.raises(HTTPException) as refused:
            await workers.run(calls.identity)
        assert refused.value.status_code == 429
        assert refused.value.headers == {"Retry-After": "1"}
        # what takes milliseconds has a process of its own
        (await workers.run(calls.identity, light=True)).close()
        await asyncio.gather(*tasks)
        assert order == [0, 1, 2]

    server.call(asked())


def test_a_client_that_leaves_gives_up_its_place_and_ends_its_call(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pool, "_CANCEL_SECONDS", PATIENCE)  # on a busy machine
    server = make_server(Settings(workers=1))
    workers: Workers = server.app.state.workers
    body = '{"set": {"trajectory.laps": 60}}'
    head = f"POST {API}/simulate HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    request = f"{head}Content-Length: {len(body)}\r\n\r\n{body}".encode()
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        until(lambda: workers.forks.complete.is_set() and len(pids(server)) == 2)
        until(lambda: not workers._stale)  # no process is replaced any more
        assert client.post(f"{API}/simulate", json={}).status_code == 200
        connections = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(2)]
        for connection in connections:
            connection.sendall(request)
        until(lambda: workers._heavy == 1 and len(workers._turns[False]) == 1)
        until(lambda: taken(server) > 0)
        before = pids(server)
        for connection in connections:
            connection.close()
        until(lambda: workers._heavy == 0 and not workers._turns[False])
        until(lambda: taken(server) == 0)
        assert pids(server) == before  # it could be asked to end
        assert client.post(f"{API}/simulate", json={}).status_code == 200


def test_the_fork_server_is_started_again(make_server: MakeServer) -> None:
    server = make_server(Settings(workers=1))
    run(server, calls.identity)
    first = server.app.state.workers.forks.pid
    before = pids(server)
    os.kill(first, signal.SIGKILL)
    until(lambda: not any(runs(pid) for pid in before))
    until(lambda: server.app.state.workers.forks.pid != first)
    assert run(server, calls.identity) not in before


def test_a_server_that_ends_leaves_no_process(make_server: MakeServer) -> None:
    server = make_server(Settings())
    run(server, calls.identity)
    left = [server.app.state.workers.forks.pid, *pids(server)]
    hung = threading.Thread(target=_give_up, args=(server,))
    hung.start()
    until(lambda: server.app.state.workers._heavy == 1)
    server.stop()
    hung.join(PATIENCE)
    until(lambda: not any(runs(pid) for pid in left))


def _give_up(server: Server) -> None:
    with pytest.raises(BaseException):  # noqa: B017 - however the loop ends it
        run(server, calls.sleep, 60.0)


_SERVED = """\
import asyncio, sys
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.workers.pool import Workers
from tests.server import calls

async def main():
    workers = Workers(count=1, waiting_max=1, memory=MemoryBudget(10))
    workers.start()
    pid = (await workers.run(calls.identity)).value
    print(workers.forks.pid, pid, flush=True)
    await workers.run(calls.sleep, 60.0)

asyncio.run(main())
"""


def test_a_server_that_is_killed_leaves_no_process() -> None:
    command = (sys.executable, "-c", _SERVED)
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        left = [int(pid) for pid in process.stdout.readline().split()]
        assert len(left) == 2
        assert all(map(runs, left))
        process.kill()
        process.wait()
    until(lambda: not any(map(runs, left)))
