"""Health, and the cookie that spares a browser from sending the token each time."""

from __future__ import annotations

import hmac
from typing import Literal

from fastapi import APIRouter, HTTPException, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab import __version__
from motionlab.service.bodies import JsonRoute
from motionlab.service.problems import responses
from motionlab.service.security import COOKIE

router = APIRouter(route_class=JsonRoute)


class Health(BaseModel):
    """That the server answers, and which version it is."""

    status: Literal["ok"]
    version: str = Field(description="Version of the project")


class LoginRequest(BaseModel):
    """The token that the server was started with."""

    model_config = ConfigDict(extra="forbid")

    token: str = Field(description="Value of MOTIONLAB_TOKEN", max_length=1000)


@router.get("/health", operation_id="getHealth", tags=["server"])
def get_health() -> Health:
    """Answer that the server is up; needs no token."""
    return Health(status="ok", version=__version__)


@router.post(
    "/login",
    operation_id="login",
    tags=["server"],
    status_code=204,
    responses=responses(400, 401, 413, 415, 422),
)
def login(request: Request, body: LoginRequest) -> Response:
    """Exchange the token for a cookie that scripts in the page cannot read."""
    token = request.app.state.settings.token
    if token is None or not hmac.compare_digest(body.token.encode(), token.encode()):
        raise HTTPException(401, "that is not this server's token")
    response = Response(status_code=204)
    response.set_cookie(COOKIE, token, httponly=True, samesite="strict", path="/")
    return response
