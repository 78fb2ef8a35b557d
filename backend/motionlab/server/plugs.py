"""Routes that a server has only where it is configured for them.

A *plug* is a router. Its lifespan starts what its routes need, once the server has sessions and
workers, and ends it before these. Of the server it uses

- `Sessions.add`, for sessions of its own kind;
- `app.state.activities`, a list of functions without arguments: whether something moves, so that
  no collection of garbage delays its stop;
- `MotionLabError.kind`, for the problem documents of its own errors.
"""

from __future__ import annotations

from fastapi import APIRouter, HTTPException

_METHODS = ["GET", "POST", "PUT", "PATCH", "DELETE"]


def drive_plug() -> APIRouter:
    """Import the routes of drives, which starts no link."""
    from motionlab.drive.plug.router import router  # noqa: PLC0415 - not without --drive

    return router


without_drives = APIRouter()
"""Answers in place of the plug, without importing it."""


@without_drives.api_route("/drive", methods=_METHODS, include_in_schema=False)
@without_drives.api_route("/drive/{call:path}", methods=_METHODS, include_in_schema=False)
async def refuse() -> None:
    """Say what the routes of drives need."""
    raise HTTPException(404, "this server has no drive link: start it with --drive FILE")
