"""The viser server of a scene: on loopback, for its own lab alone, without a share tunnel."""

from __future__ import annotations

import asyncio
import functools
import hmac
import http
import socket
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import viser
import websockets.asyncio.server
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from motionlab.scene3d.cameras import FIELD_OF_VIEW, camera_of
from motionlab.scene3d.protocol import RATE, TRAIL_SECONDS, SceneDescription, Values
from motionlab.scene3d.view import View
from motionlab.scene3d.view_settings import ViewSettings
from motionlab.scene3d.viewer_websockets import contained, viewer_name

SEND_BUFFER = 64 * 1024
"""Bytes that a slow viewer can leave unread in the kernel."""

CHOICES_MAX = 64
"""Viewers whose choices are kept, the latest."""


class LabServer(viser.ViserServer):
    """A viser server without a public share tunnel."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse a public share tunnel: the lab is never exposed on a viewer's request."""
        return None


def open_server(start: SceneDescription) -> LabServer:
    """Return a server on a free loopback port that accepts `start.origin` alone.

    viser binds to every address and accepts any connection. It hands both its port and its
    page to one call of websockets' ``serve``; that call is given a loopback socket, a check, and
    a handler that no viewer's message can make print a traceback.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)  # inherited
    listener.bind(("127.0.0.1", 0))
    original = websockets.asyncio.server.serve

    @functools.wraps(original)
    def serve(
        handler: Any, _host: str, _port: int, *, process_request: Callable[..., Any], **options: Any
    ) -> Any:
        def guarded(connection: Any, request: Request) -> Response | None:
            if not hmac.compare_digest(
                request.headers.get("Origin", "").encode(), start.origin.encode()
            ):
                headers = Headers({"Content-Length": "0", "Connection": "close"})
                return Response(http.HTTPStatus.FORBIDDEN.value, "Forbidden", headers)
            return process_request(connection, request)

        return original(contained(handler), sock=listener, process_request=guarded, **options)

    websockets.asyncio.server.serve = serve  # type: ignore[assignment]
    try:
        return LabServer("127.0.0.1", 0, label="View", verbose=False)
    finally:
        websockets.asyncio.server.serve = original  # type: ignore[assignment]


class SceneServer:
    """Shows poses to every viewer.

    Attributes
    ----------
    forces : ndarray, shape (variants, 2, 2, 3)
        Thrust and normal force of each variant, axis and phase at the pose that is shown next, N.
    """

    def __init__(self, start: SceneDescription) -> None:
        self._start = start
        self._trail: Values = np.empty((0, 0), np.float32)
        self.forces: Values = np.zeros((len(start.variants), 2, 2, 3), np.float32)
        self._choices: dict[str, ViewSettings] = {}
        self._views: dict[int, View] = {}
        self._lock = threading.Lock()
        self.server = open_server(start)
        camera = self.server.initial_camera
        camera.fov = FIELD_OF_VIEW
        camera.near, camera.far = 0.01, 20.0
        camera.position = np.array(camera_of(ViewSettings(), start).position(2.0))
        camera.look_at = np.zeros(3)
        gui = self.server.gui
        gui.configure_theme(control_width="small", show_logo=False, show_share_button=False)
        gui.main_panel.minimize()
        self.server.on_client_connect(self._join)
        self.server.on_client_disconnect(self._leave)

    @property
    def port(self) -> int:
        """Port of the server on loopback."""
        return self.server.get_port()

    def show(self, poses: Values) -> None:
        """Accept newer poses, oldest first, and draw the last; a repeated one is drawn anew."""
        with self._lock:
            if self._trail.shape[1:] != poses.shape[1:]:
                self._trail = poses[:0]
            again = np.array_equal(self._trail[-1:], poses)
            if not again:
                kept = round(RATE * TRAIL_SECONDS)
                self._trail = np.concatenate([self._trail, poses])[-kept:]
            self._forget_gone()
            for view in self._views.values():
                view.show(self._trail, self.forces, complete=again or len(poses) > 1)

    def clear(self) -> None:
        """Clear the trace."""
        with self._lock:
            self._trail = self._trail[:0]

    def configure(self, viewer: str, settings: ViewSettings) -> None:
        """Show what the viewer of a name has chosen, now and whenever it connects."""
        with self._lock:
            self._choices.pop(viewer, None)
            self._choices[viewer] = settings
            while len(self._choices) > CHOICES_MAX:
                self._choices.pop(next(iter(self._choices)))
            self._forget_gone()
            for view in self._views.values():
                if view.name == viewer:
                    view.apply(settings)
                    self._show(view)

    def _show(self, view: View) -> None:
        if len(self._trail):
            view.show(self._trail, self.forces)

    async def _join(self, client: viser.ClientHandle) -> None:
        # Its name is known in the context of its connection alone.
        await asyncio.to_thread(self._add, client, viewer_name())

    def _add(self, client: viser.ClientHandle, name: str) -> None:
        with self._lock:
            view = View(client, name, self._start, self._choices.get(name, ViewSettings()))
            self._views[client.client_id] = view
            self._show(view)

        @client.camera.on_update
        def _(_: viser.CameraHandle) -> None:
            if view.resized():
                with self._lock:
                    view.look()

    def _leave(self, _client: viser.ClientHandle) -> None:
        with self._lock:
            self._forget_gone()

    def _forget_gone(self) -> None:
        """Remove viewers that have left; one may leave while its join is still queued."""
        present = self.server.get_clients()
        self._views = {key: view for key, view in self._views.items() if key in present}
