"""Health, log-in and log-out of browsers."""

from __future__ import annotations

import hmac
import logging
import math
from typing import Literal

from fastapi import APIRouter, HTTPException, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab import __version__
from motionlab.server.http.logins import cookie_name, set_cookie
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.security import find_login
from motionlab.server.http.strict_json import JsonRoute
from motionlab.simulation.precompile import batches_compiled

_LOG = logging.getLogger(__name__)

router = APIRouter(route_class=JsonRoute)


class Health(BaseModel):
    """That the server answers, and which version it is."""

    status: Literal["ok"]
    version: str = Field(description="Version of the project")
    login: bool = Field(description="Whether browsers have to log in")
    drive: bool = Field(description="Whether there is a drive link")
    help: bool = Field(description="Whether the documentation is served at /help")
    compiling: bool = Field(
        description="Whether simulations wait until they are compiled, once on a machine"
    )
    compiled_share: float = Field(description="Share of that which is compiled, 0 to 1")


class LoginRequest(BaseModel):
    """The token that the server was started with."""

    model_config = ConfigDict(extra="forbid") | examples({"token": "value of MOTIONLAB_TOKEN"})

    token: str = Field(description="Value of MOTIONLAB_TOKEN", max_length=1000)


@router.get("/health", operation_id="getHealth", tags=["server"])
async def get_health(request: Request) -> Health:
    """Answer that the server is up; needs no token."""
    settings, workers = request.app.state.settings, request.app.state.workers
    compiling = not (workers.ready or batches_compiled())
    return Health(
        status="ok",
        version=__version__,
        login=settings.token is not None,
        drive=settings.drive is not None,
        help=request.app.state.documented,
        compiling=compiling,
        compiled_share=workers.forks.warmth if compiling else 1.0,
    )


@router.post(
    "/login",
    operation_id="login",
    tags=["server"],
    status_code=204,
    responses=responses(400, 401, 413, 415, 422, 429),
)
async def log_in(request: Request, body: LoginRequest) -> Response:
    """Exchange the token for a cookie that scripts in the page cannot read."""
    address = "unknown" if request.client is None else request.client.host
    token = request.app.state.settings.token
    if token is None or not hmac.compare_digest(body.token.encode(), token.encode()):
        # Only wrong ones are counted, so others cannot lock out who has the token.
        wait = request.app.state.logins.attempts.take(address)
        if wait > 0:
            seconds = str(math.ceil(wait))
            detail = f"too many log-ins with a wrong token; wait {seconds} s"
            raise HTTPException(429, detail, {"Retry-After": seconds})
        _LOG.warning("log-in from %.60r failed: wrong token", address)
        raise HTTPException(401, "that is not this server's token")
    _LOG.info("log-in from %.60r", address)
    return _with_cookie(request, request.app.state.logins.issue())


@router.post(
    "/logout",
    operation_id="logout",
    tags=["server"],
    status_code=204,
    responses=responses(401),
)
async def log_out(request: Request) -> Response:
    """End a browser's log-in: its cookie is no longer accepted."""
    logins = request.app.state.logins
    login = find_login(request.headers, logins)
    if login is not None:
        logins.end(login)
    return _with_cookie(request, "")


def _with_cookie(request: Request, value: str) -> Response:
    name = cookie_name(request.headers.get("host", ""))
    header = set_cookie(name, value, secure=request.url.scheme == "https")
    return Response(status_code=204, headers={"Set-Cookie": header})
