"""The 3-D view: a page and its websocket, carried from a process of their own."""

from __future__ import annotations

import re

from fastapi import APIRouter, HTTPException, Request, Response, WebSocket
from starlette.requests import HTTPConnection

from motionlab.server.live.session import Session
from motionlab.server.live.stream import refuse
from motionlab.server.routes.view3d import VIEWER
from motionlab.server.view3d import proxy
from motionlab.server.view3d.process import Scene

router = APIRouter(prefix="/scene", include_in_schema=False)


def newest_session(connection: HTTPConnection) -> Session | None:
    """Return the session that was created last, of those that play if any does."""
    sessions = connection.app.state.sessions.all()
    playing = [session for session in sessions if session.state == "playing"]
    return next(reversed(playing or sessions), None)


async def _scene(connection: HTTPConnection, session_id: str | None) -> Scene:
    sessions = connection.app.state.sessions
    session = newest_session(connection) if session_id is None else sessions.find(session_id)
    return await connection.app.state.scenes.of(session)


# viser's page derives the address of its websocket from its own less the trailing slash.
@router.api_route("", methods=["GET", "HEAD"])
@router.api_route("/", methods=["GET", "HEAD"])
@router.api_route("/{session_id}", methods=["GET", "HEAD"])
@router.api_route("/{session_id}/", methods=["GET", "HEAD"])
@router.api_route("/{session_id}/{viewer}/", methods=["GET", "HEAD"])
async def get_scene(request: Request, session_id: str | None = None) -> Response:
    """Return the page of a scene, started if need be; HEAD only starts it.

    The ETag is that of the process: with another one, a page that is open has lost its own. It has
    to be loaded anew, since viser's page in a frame connects again only once it has the focus.
    """
    scene = await _scene(request, session_id)
    if request.method == "HEAD":
        return Response(media_type="text/html", headers={"ETag": scene.tag})
    encoding = request.headers.get("accept-encoding", "")
    try:
        try:
            page = await proxy.fetch_page(scene, encoding)
        except OSError:  # it hangs, or was killed and is not known to be gone yet
            request.app.state.scenes.drop(scene)
            scene = await _scene(request, session_id)
            page = await proxy.fetch_page(scene, encoding)
    except OSError as error:
        raise HTTPException(503, f"the 3-D view is not available: {error}") from None
    page.headers["ETag"] = scene.tag
    return page


@router.websocket("")
@router.websocket("/")
@router.websocket("/{session_id}")
@router.websocket("/{session_id}/")
@router.websocket("/{session_id}/{viewer}")
async def watch(
    websocket: WebSocket,
    session_id: str | None = None,
    viewer: str = "",
) -> None:
    """Carry a viewer's websocket; one with a name shows what was chosen for it."""
    try:
        scene = await _scene(websocket, session_id)
        scene.enter()
    except HTTPException as error:
        await refuse(websocket, str(error.detail))
        return
    try:
        await proxy.carry(websocket, scene, viewer if re.fullmatch(VIEWER, viewer) else "")
    finally:
        scene.leave()
