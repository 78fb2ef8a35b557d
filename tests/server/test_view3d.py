"""The 3-D view as a client of the server finds it: page, websocket, guard, bounds, return."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator

import httpx
import numpy as np
import pytest
from fastapi import HTTPException
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from motionlab.server.settings import Settings
from motionlab.server.view3d import processes, proxy
from motionlab.server.view3d.process import Scene
from motionlab.server.view3d.processes import Scenes
from tests.scene3d.viewers import Viewer
from tests.server.conftest import MakeServer
from tests.server.live import Live, until
from tests.server.servers import PATIENCE, Server

TOKEN = "a-token-of-some-length"


@pytest.fixture
def own(make_server: MakeServer) -> Server:
    """Return a server of the test's own, so that its scenes can be counted."""
    return make_server(Settings())


@pytest.fixture
def own_live(own: Server) -> Iterator[Live]:
    with httpx.Client(base_url=own.url, timeout=PATIENCE) as client:
        yield Live.create(client)


@pytest.fixture(scope="module")
def shown(client: httpx.Client) -> Iterator[Live]:
    """Return a session whose scene many tests watch: each would start a process of its own."""
    live = Live.create(client)
    yield live
    live.delete()


def address(server: Server, session_id: str = "", end: str = "/") -> str:
    return f"ws://127.0.0.1:{server.port}/scene/{session_id}{end if session_id else ''}"


def only(server: Server) -> Scene:
    [scene] = server.app.state.scenes.all()
    return scene


def gone(pid: int) -> bool:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, 0)
        return False
    return True


def refused(connecting: Callable[[], object]) -> int:
    """Return the HTTP status with which a handshake is refused."""
    with pytest.raises(InvalidStatus) as caught:
        connecting()
    return caught.value.response.status_code


@pytest.mark.parametrize("end", ["", "/"])
def test_the_page_and_its_websocket_are_carried(server: Server, shown: Live, end: str) -> None:
    response = httpx.get(f"{server.url}/scene/{shown.id}{end}", timeout=PATIENCE)
    assert response.status_code == 200
    assert response.headers["content-type"].startswith("text/html")
    assert "<html" in response.text
    policy = response.headers["content-security-policy"]
    assert "frame-ancestors 'self'" in policy
    assert "connect-src 'self' " in policy
    assert "http" not in policy
    with Viewer(address(server, shown.id, end)) as viewer:
        assert viewer.socket.subprotocol is not None
        assert viewer.socket.subprotocol.startswith("viser-v")
        assert viewer.window()


def test_another_version_of_the_page_is_told_so(server: Server, shown: Live) -> None:
    with Viewer(address(server, shown.id), subprotocols=["viser-v0.0.1"]) as viewer:
        with pytest.raises(ConnectionClosed) as caught:
            viewer.window()
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1002


def test_platforms_stand_where_the_telemetry_says(server: Server, live: Live) -> None:
    live.step(700)
    with Viewer(address(server, live.id)) as viewer:
        viewer.look()
        names = ("/lab/A/y", "/lab/A/y/x", "/lab/B/y", "/lab/B/y/x")
        viewer.positions(*names)
        live.step(900)
        found = viewer.positions(*names)
    columns = live.columns()
    x = y = 0.0
    for variant in "AB":
        x, y = (columns[f"{variant}.{axis}.position"][-1] for axis in "xy")
        assert found[f"/lab/{variant}/y"] == pytest.approx([0.0, y, 0.0], abs=1e-7)
        assert found[f"/lab/{variant}/y/x"] == pytest.approx([x, 0.0, 0.0], abs=1e-7)
    assert np.hypot(x, y) > 1e-3


def test_nothing_is_sent_while_nothing_moves(server: Server, live: Live) -> None:
    live.step(100)
    with Viewer(address(server, live.id)) as viewer:
        viewer.look()
        viewer.positions("/lab/A/y")
        until(lambda: viewer.drain(1.0) == 0)
        live.step(100)
        viewer.positions("/lab/A/y")


def test_nothing_is_fed_while_nobody_watches(own: Server, own_live: Live) -> None:
    session = own.app.state.sessions.find(own_live.id)
    with Viewer(address(own, own_live.id)):
        until(lambda: len(session.listeners) == 1)
    until(lambda: not session.listeners)
    assert only(own).alive


def test_without_a_session_the_motor_rests_at_mid_stroke(own: Server) -> None:
    nodes: set[str] = set()
    with Viewer(address(own)) as viewer:
        viewer.look()
        while not {"/lab/A/y/x", "/lab/B/y/x"} <= nodes:
            told = viewer.window()
            nodes |= {message["name"] for message in told if "name" in message}
            moved = [m for m in told if m["type"] == "SetPositionMessage"]
            assert not any(np.any(m["position"]) for m in moved if m["name"].endswith(("/y", "/x")))
    assert only(own).session is None


def test_without_an_id_the_newest_or_the_playing_session_is_shown(own: Server) -> None:
    with httpx.Client(base_url=own.url, timeout=PATIENCE) as client:
        first, last = Live.create(client), Live.create(client)
        assert client.head("/scene/").status_code == 200
        assert only(own).session.id == last.id  # type: ignore[union-attr]
        first.do("play")
        assert client.head("/scene/").status_code == 200
        assert own.app.state.scenes.all()[-1].session.id == first.id


def test_an_unknown_session_has_no_scene(server: Server) -> None:
    response = httpx.get(f"{server.url}/scene/nobody/", timeout=PATIENCE)
    assert response.status_code == 404
    assert "nobody" in response.json()["detail"]
    assert refused(lambda: Viewer(address(server, "nobody"))) == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_page_of_another_origin_cannot_watch(server: Server, shown: Live, origin: str) -> None:
    assert refused(lambda: Viewer(address(server, shown.id), origin=origin)) == 403
    assert refused(lambda: Viewer(address(server), origin=origin)) == 403
    with Viewer(address(server, shown.id), origin=server.url) as viewer:
        assert viewer.window()


def test_a_foreign_host_cannot_watch(server: Server, live: Live) -> None:
    headers = {"Host": "evil.example"}
    foreign = httpx.get(f"{server.url}/scene/{live.id}/", headers=headers, timeout=PATIENCE)
    assert foreign.status_code == 403
    with socket.create_connection(("127.0.0.1", server.port)) as link:
        there = f"ws://evil.example:{server.port}/scene/{live.id}"
        assert refused(lambda: connect(there, sock=link)) == 403


def test_a_scene_needs_the_token(make_server: MakeServer) -> None:
    server = make_server(Settings(token=TOKEN))
    header = {"Authorization": f"Bearer {TOKEN}"}
    for path in ("/scene", "/scene/", "/scene/any", "/scene/any/"):
        assert httpx.get(server.url + path, timeout=PATIENCE).status_code == 401
    assert refused(lambda: Viewer(address(server))) == 403
    with Viewer(address(server), additional_headers=header) as viewer:
        assert viewer.window()


def test_a_killed_process_comes_back_and_the_rest_goes_on(own: Server, own_live: Live) -> None:
    with Viewer(address(own, own_live.id)) as viewer:
        viewer.look()
        first = only(own).pid
        assert first is not None
        os.kill(first, signal.SIGKILL)
        with pytest.raises(ConnectionClosed):
            viewer.drain(PATIENCE)
    own_live.step(500)
    with Viewer(address(own, own_live.id)) as viewer:
        viewer.look()
        viewer.positions("/lab/A/y")
    assert only(own).pid != first


def test_the_request_after_a_kill_gets_a_page(own: Server, own_live: Live) -> None:
    with httpx.Client(base_url=own.url, timeout=PATIENCE) as client:
        for _ in range(3):
            assert client.get(f"/scene/{own_live.id}/").status_code == 200
            (scene,) = own.app.state.scenes.all()
            os.kill(scene.pid, signal.SIGKILL)
        assert client.get(f"/scene/{own_live.id}/").status_code == 200


def test_a_hung_process_is_replaced(own: Server, own_live: Live) -> None:
    with httpx.Client(base_url=own.url, timeout=PATIENCE) as client:
        assert client.get(f"/scene/{own_live.id}/").status_code == 200
        hung = only(own).pid
        assert hung is not None
        os.kill(hung, signal.SIGSTOP)
        assert client.get(f"/scene/{own_live.id}/").status_code == 200
        assert only(own).pid != hung
        until(lambda: gone(hung))


def test_a_hung_process_ends_while_it_is_watched(
    own: Server, own_live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(proxy, "HANG_SECONDS", 0.5)
    with Viewer(address(own, own_live.id)) as viewer:
        viewer.look()
        hung = only(own).pid
        assert hung is not None
        os.kill(hung, signal.SIGSTOP)
        with pytest.raises(ConnectionClosed):
            viewer.drain(PATIENCE)
    until(lambda: gone(hung))


def test_a_scene_that_does_not_start_keeps_nobody_waiting(own: Server, own_live: Live) -> None:
    """Every other scene starts, is watched and ends meanwhile."""
    kept = own.app.state.scenes
    never = (sys.executable, "-c", "import time; time.sleep(1000)")
    with httpx.Client(base_url=own.url, timeout=PATIENCE) as client:
        other = Live.create(client)
        kept._command = never
        waiting = asyncio.run_coroutine_threadsafe(
            kept.of(own.app.state.sessions.find(own_live.id)), own.loop
        )
        until(lambda: len(kept.all()) == 1)
        kept._command = processes.COMMAND
        assert client.get(f"/scene/{other.id}/").status_code == 200
        own.call(_sweep_once(own))
        assert not waiting.done()
        stuck, _ = kept.all()
        own.loop.call_soon_threadsafe(kept.drop, stuck)
        with pytest.raises(HTTPException, match="ended before it was ready"):
            waiting.result(PATIENCE)


def test_a_scene_ends_with_its_session(own: Server, own_live: Live) -> None:
    with Viewer(address(own, own_live.id)) as viewer:
        pid = only(own).pid
        assert pid is not None
        own_live.delete()
        with pytest.raises(ConnectionClosed):
            viewer.drain(PATIENCE)
    until(lambda: gone(pid))


def test_a_scene_that_nobody_watches_ends(
    own: Server, own_live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Viewer(address(own, own_live.id)):
        pid = only(own).pid
        assert pid is not None
        monkeypatch.setattr(processes, "UNWATCHED_SECONDS", 0.0)
        own.call(_sweep_once(own))
        assert not gone(pid)
    until(lambda: gone(pid))


async def _sweep_once(server: Server) -> None:
    await server.app.state.scenes.evict_idle()


def test_scenes_are_bounded_in_number(make_server: MakeServer) -> None:
    server = make_server(Settings(scenes_max=1))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        first, second = Live.create(client), Live.create(client)
        with Viewer(address(server, first.id)):
            response = client.get(f"/scene/{second.id}/")
            assert response.status_code == 429
            assert "1 scenes" in response.json()["detail"]
        until(lambda: only(server).viewers == 0)
        assert client.get(f"/scene/{second.id}/").status_code == 200
        assert only(server).session.id == second.id  # type: ignore[union-attr]


def test_viewers_of_a_scene_are_bounded_in_number(
    own: Server, own_live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motionlab.server.view3d.process.VIEWERS_MAX", 1)
    with Viewer(address(own, own_live.id)):
        assert refused(lambda: Viewer(address(own, own_live.id))) == 403


MISSING = (
    "import runpy, sys; sys.modules['viser'] = None; "
    "runpy.run_module('motionlab.scene3d', run_name='__main__')"
)


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ((sys.executable, "-c", MISSING), "viser cannot be loaded"),
        ((sys.executable, "-c", "pass"), "ended before it was ready"),
        ((sys.executable, "-c", "print('hello')"), "nothing that can be understood"),
        (("/nowhere/python",), "cannot be started: No such file"),
    ],
)
def test_what_cannot_be_started_is_said_and_the_rest_works(
    own: Server, own_live: Live, command: tuple[str, ...], reason: str
) -> None:
    own.app.state.scenes = Scenes(most=1, command=command)
    response = httpx.get(f"{own.url}/scene/{own_live.id}/", timeout=PATIENCE)
    assert response.status_code == 503
    assert reason in response.json()["detail"]
    assert refused(lambda: Viewer(address(own, own_live.id))) == 403
    own_live.step(10)


def test_a_viewer_that_never_reads_is_turned_away(
    own: Server, own_live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket() as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        link.connect(("127.0.0.1", own.port))
        viewer = Viewer(address(own, own_live.id), sock=link, max_queue=1)
        viewer.look()
        until(lambda: only(own).viewers == 1)
        monkeypatch.setattr(proxy, "STALLED_SECONDS", 0.3)
        own_live.do("play", speed=1.0)
        until(lambda: only(own).viewers == 0)


def test_a_message_too_large_ends_the_connection(server: Server, shown: Live) -> None:
    with Viewer(address(server, shown.id)) as viewer:
        viewer.socket.send(bytes(proxy.MESSAGE_MAX + 1))
        with pytest.raises(ConnectionClosed) as caught:
            viewer.drain(PATIENCE)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == 1009


def test_two_sessions_have_two_scenes(own: Server, own_live: Live) -> None:
    other = Live.create(own_live.client)
    with Viewer(address(own, own_live.id)), Viewer(address(own, other.id)):
        assert len({scene.pid for scene in own.app.state.scenes.all()}) == 2
