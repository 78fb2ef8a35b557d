"""Viewers of a scene as a browser is one, without a browser: viser's messages over a websocket."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Any, Self

import msgspec
import numpy as np
import viser
import zstandard
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from tests.server.servers import PATIENCE

PROTOCOL = f"viser-v{viser.__version__}"
_HEADER_BYTES = 16


class Viewer:
    """One viewer.

    Parameters
    ----------
    url : str
        Address of the websocket.
    origin : str, optional
        Origin header, as a page would send it.
    options
        Further arguments of ``websockets.sync.client.connect``.
    """

    def __init__(self, url: str, origin: str | None = None, **options: Any) -> None:
        options = {"subprotocols": [Subprotocol(PROTOCOL)], "compression": None} | options
        self.socket = connect(
            url,
            origin=None if origin is None else Origin(origin),
            max_size=None,
            proxy=None,
            open_timeout=PATIENCE,  # its process is started first
            **options,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.socket.close()

    def send(self, kind: str, **fields: Any) -> None:
        """Send a message of viser's."""
        self.socket.send(msgspec.msgpack.encode({"type": kind} | fields))

    def look(self) -> Self:
        """Report a camera, from when on viser counts it as connected."""
        self.send(
            "ViewerCameraMessage",
            wxyz=(1.0, 0.0, 0.0, 0.0),
            position=(0.0, -1.0, 1.0),
            fov=0.6,
            near=0.01,
            far=20.0,
            image_height=300,
            image_width=800,
            look_at=(0.0, 0.0, 0.0),
            up_direction=(0.0, 0.0, 1.0),
        )
        return self

    def window(self, timeout: float = PATIENCE) -> list[dict[str, Any]]:
        """Return the next messages, which come together."""
        data = self.socket.recv(timeout)
        assert isinstance(data, bytes)
        size = int.from_bytes(data[8:_HEADER_BYTES], "little")
        packed = data[_HEADER_BYTES : _HEADER_BYTES + size]
        inner = zstandard.ZstdDecompressor().decompress(packed)
        return list(msgspec.msgpack.decode(inner)["messages"])

    def positions(self, *names: str) -> dict[str, Any]:
        """Return the next positions of some nodes, once each has been told."""
        found: dict[str, Any] = {}
        end = time.monotonic() + PATIENCE
        while set(found) != set(names):
            assert time.monotonic() < end, f"no position of {set(names) - set(found)}"
            for message in self.window():
                if message["type"] == "SetPositionMessage" and message["name"] in names:
                    found[message["name"]] = np.array(message["position"])
        return found

    def find(self, kind: str) -> dict[str, Any]:
        """Return the next message of a kind."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for message in self.window():
                if message["type"] == kind:
                    return message
        raise AssertionError(f"no {kind}")

    def drain(self, quiet: float) -> int:
        """Read until nothing has come for some seconds; return how many bytes came."""
        received = 0
        while True:
            try:
                received += len(self.socket.recv(quiet))
            except TimeoutError:
                return received
