"""A scene's own server: who it speaks to, what it keeps, when it ends."""

from __future__ import annotations

import gc
import json
import subprocess
import sys
import threading
from collections.abc import Iterator

import httpx
import msgspec
import numpy as np
import pytest
from viser import _viser
from websockets.exceptions import ConnectionClosed

from motionlab.scene3d import protocol, server, viewer_websockets
from motionlab.scene3d.server import SceneServer
from motionlab.scene3d.view_settings import ViewSettings
from tests.scene3d.viewers import Viewer
from tests.server.live import until
from tests.server.servers import PATIENCE
from tests.server.test_view3d import refused

# As in the scene's own process: a viewer may leave while something is written to it.
pytestmark = pytest.mark.filterwarnings("ignore:Queued a .* on a closed connection:UserWarning")

ORIGIN = "lab://this-test"
AXES = (protocol.DrawnAxis(0.085, 7.2e-3, 0.0), protocol.DrawnAxis(0.145, 7.2e-3, 0.0))
START = protocol.SceneDescription(
    ORIGIN, AXES, {"A": "one", "B": "other"}, [(0.0, 0.0), (0.01, 0.0)]
)


@pytest.fixture(scope="module")
def scene() -> Iterator[SceneServer]:
    scene = SceneServer(START)
    yield scene
    scene.server.stop()


def address(scene: SceneServer) -> str:
    return f"ws://127.0.0.1:{scene.port}"


def pose(seconds: float) -> protocol.Values:
    """Return one pose, different at each time."""
    values = np.sin(seconds + np.arange(protocol.width(2), dtype=np.float32))
    return (0.01 * values)[None].astype(np.float32)


def watching(scene: SceneServer, viewers: int) -> None:
    until(lambda: len(scene._views) == viewers)


@pytest.mark.parametrize("origin", [None, "null", "http://127.0.0.1:8000", "http://evil.example"])
def test_only_the_lab_is_spoken_to(scene: SceneServer, origin: str | None) -> None:
    assert refused(lambda: Viewer(address(scene), origin=origin)) == 403
    headers = {} if origin is None else {"Origin": origin}
    page = httpx.get(f"http://127.0.0.1:{scene.port}/", headers=headers, timeout=PATIENCE)
    assert page.status_code == 403


def test_it_listens_on_loopback_alone(scene: SceneServer) -> None:
    with open("/proc/net/tcp") as table:
        listening = [line.split()[1] for line in table if line.split()[3] == "0A"]
    own = [place for place in listening if place.endswith(f":{scene.port:04X}")]
    assert own == [f"0100007F:{scene.port:04X}"]


def test_no_share_tunnel_can_be_asked_for(
    scene: SceneServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = threading.Event()

    class Tunnel:
        def __init__(self, *_: object) -> None:
            opened.set()
            raise AssertionError("a tunnel was opened")

    monkeypatch.setattr(_viser, "ViserTunnel", Tunnel)
    with Viewer(address(scene), origin=ORIGIN) as viewer:
        viewer.look()
        viewer.send("ShareUrlRequest")
        assert not opened.wait(0.5)
        viewer.send("ShareUrlDisconnect")
        scene.show(pose(0.0))
        assert viewer.window()


def test_what_a_joining_client_goes_through_does_not_grow(scene: SceneServer) -> None:
    """Viser looks at each number that the shared buffer ever gave out, for each that joins."""
    shared = scene.server._websock_server.get_message_buffer()
    with Viewer(address(scene), origin=ORIGIN) as viewer:
        viewer.look()
        watching(scene, 1)
        before = shared.message_counter
        for tick in range(300):
            scene.show(pose(0.01 * tick))
        viewer.positions("/lab/A/y")
        assert shared.message_counter == before
    assert before < 200


def test_what_waits_for_a_slow_viewer_does_not_grow(scene: SceneServer) -> None:
    watching(scene, 0)
    with Viewer(address(scene), origin=ORIGIN, max_queue=1) as viewer:
        viewer.look()
        watching(scene, 1)
        [view] = scene._views.values()
        waiting = view.client._websock_connection.get_message_buffer()
        for tick in range(400):
            scene.show(pose(0.01 * tick))
        assert waiting.message_counter > 2_000
        assert len(waiting.message_from_id) < 200
    watching(scene, 0)


def test_a_variant_that_diverged_stays_where_it_was(scene: SceneServer) -> None:
    with Viewer(address(scene), origin=ORIGIN) as viewer:
        viewer.look()
        lost = pose(1.0)
        lost[0, 4 : 4 + 12] = np.nan
        scene.show(lost)
        scene.show(pose(2.0))
        assert np.isfinite(viewer.positions("/lab/A/y")["/lab/A/y"]).all()


VIEWER = "0123456789abcdef"


def test_what_a_viewer_chose_reaches_it_alone(scene: SceneServer) -> None:
    with (
        Viewer(f"{address(scene)}/{VIEWER}", origin=ORIGIN).look() as viewer,
        Viewer(address(scene), origin=ORIGIN).look(),
    ):
        watching(scene, 2)
        scene.configure(VIEWER, ViewSettings(camera="top", ghost=True, magnification=200.0))

        def from_above() -> bool:
            told = [m for m in viewer.window() if m["type"] == "SetCameraPositionMessage"]
            return any(m["position"][2] > 10.0 * np.hypot(*m["position"][:2]) for m in told)

        until(from_above)  # after where it looked from at first
        views = {view.name: view for view in scene._views.values()}
        assert views[VIEWER].settings.camera == "top"
        assert views[""].settings == ViewSettings()
        # B stands in the frame of A.
        assert [stage.frame.position[0] for stage in views[VIEWER]._stages] == [0.0, 0.0]
        assert views[""]._stages[1].frame.position[0] > 0.1

        scene.show(pose(1.0))
        error = pose(1.0)[0, 4:6] - pose(1.0)[0, :2]
        drawn = pose(1.0)[0, :2] + 200.0 * error
        reach = np.array([axis.stroke for axis in AXES])
        expected = np.clip(drawn, -reach, reach)
        assert views[VIEWER]._stages[0].place == pytest.approx(tuple(expected))
        assert views[""]._stages[0].place == pytest.approx(tuple(pose(1.0)[0, 4:6]))


def test_a_choice_is_kept_for_a_viewer_that_joins_later(scene: SceneServer) -> None:
    watching(scene, 0)
    scene.configure(VIEWER, ViewSettings(camera="section", machine="B", axis="y"))
    for other in range(server.CHOICES_MAX - 1):
        scene.configure(f"other{other:03}", ViewSettings())
    with Viewer(f"{address(scene)}/{VIEWER}", origin=ORIGIN).look():
        watching(scene, 1)
        [view] = scene._views.values()
        assert view.settings.machine == "B"
        scene.show(pose(2.0))
        assert list(view._sections) == ["y"]
        assert view._sections["y"].frame.visible
        assert not view._root.visible
    assert len(scene._choices) == server.CHOICES_MAX
    scene.configure("one-more", ViewSettings())
    assert VIEWER not in scene._choices


def test_the_process_ends_with_its_parents_pipe() -> None:
    command = (sys.executable, "-m", "motionlab.scene3d")
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(START.encode())
        process.stdin.flush()
        port = json.loads(process.stdout.readline())["port"]
        with Viewer(f"ws://127.0.0.1:{port}", origin=ORIGIN) as viewer:
            viewer.look()
            process.stdin.write(protocol.poses(pose(0.5)))
            process.stdin.flush()
            viewer.positions("/lab/A/y")
            process.stdin.close()
            assert process.wait(PATIENCE) == 0


def update(uuid: object, updates: object) -> bytes:
    """Return a change of the panel as a viewer sends it."""
    return msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})


@pytest.mark.parametrize(
    "message",
    [
        "text",
        b"",
        b"\xc1",
        msgspec.msgpack.encode([1]),
        msgspec.msgpack.encode({"type": "nothing\nof the kind"}),
        msgspec.msgpack.encode({"type": ["x"]}),
        msgspec.msgpack.encode({"type": "ViewerCameraMessage"}),
        msgspec.msgpack.encode({"type": "GuiButtonHoldMessage", "uuid": 1, "frequency": {}}),
        update({"a": 1}, {"value": 1}),
    ],
    ids=["text", "empty", "code", "list", "kind", "kinds", "camera", "hold", "uuid"],
)
def test_what_is_no_message_ends_its_own_connection_with_one_line(
    scene: SceneServer, caplog: pytest.LogCaptureFixture, message: str | bytes
) -> None:
    with (
        Viewer(address(scene), ORIGIN).look() as other,
        Viewer(address(scene), ORIGIN).look() as viewer,
    ):
        watching(scene, 2)
        viewer.socket.send(message)
        with pytest.raises(ConnectionClosed) as caught:
            viewer.drain(PATIENCE)
        assert caught.value.rcvd is not None
        assert caught.value.rcvd.code == viewer_websockets.NOT_UNDERSTOOD
        watching(scene, 1)
        scene.show(pose(1.0))
        other.drain(0.1)  # it is still told
    gc.collect()  # a task's failure that nobody has asked for comes to light when it is forgotten
    (line,) = caplog.records
    assert "\n" not in line.getMessage()
    assert line.exc_info is None
    assert "connection closed" in line.getMessage()
