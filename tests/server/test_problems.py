"""Types of problems: each failure has its own, with its status, and says when to come back."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest
from fastapi import FastAPI, HTTPException

from motionlab import errors
from motionlab.drive.lease import NotHeld
from motionlab.drive.link.carrier import LinkError
from motionlab.reports.problems import BY_STATUS, PREFIX, TYPES
from motionlab.server.http import problems
from motionlab.server.live.session_info import WrongState

INFEASIBLE = errors.Infeasible(
    quantity="thrust",
    axis="x",
    time=1.0,
    place=(0.0, 0.0),
    value=50.0,
    limit=(-40.0, 40.0),
    unit="N",
)
FAILURES: list[tuple[Exception, str]] = [
    (errors.ConfigError(errors.FieldError("plant", "is missing")), "invalid-field"),
    (INFEASIBLE, "infeasible-trajectory"),
    (WrongState("it plays"), "wrong-state"),
    (NotHeld("somebody else holds it"), "lease-not-held"),
    (LinkError("no answer"), "drive-link"),
    (errors.StoreFull("no room"), "no-room"),
    (errors.Unknown("no such run"), "not-found"),
    (errors.Busy("is written"), "busy"),
    (errors.NotReplayable("no scenario"), "not-replayable"),
    (errors.Shipped("ships"), "shipped"),
    (errors.StoreError("the index cannot be reached"), "unavailable"),
    (errors.ExperimentFailed("no data"), "experiment-failed"),
    *((HTTPException(status, "why"), kind) for status, kind in BY_STATUS.items()),
]


def answer(failure: Exception) -> httpx.Response:
    """Return how an application answers a call that fails."""
    app = FastAPI()
    problems.install(app)

    @app.get("/")
    async def fail() -> None:
        raise failure

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app=app)
        async with httpx.AsyncClient(transport=transport, base_url="http://lab") as client:
            return await client.get("/")

    return asyncio.run(ask())


@pytest.mark.parametrize(("failure", "kind"), FAILURES, ids=lambda value: str(value)[:30])
def test_every_failure_has_its_type(failure: Exception, kind: Any) -> None:
    response = answer(failure)
    told = response.json()
    status, title, _ = TYPES[kind]
    assert (told["type"], told["title"]) == (PREFIX + kind, title)
    assert response.status_code == told["status"] == status
    assert ("retry-after" in response.headers) == (status == 429)


def test_a_wait_that_a_failure_states_stays() -> None:
    response = answer(HTTPException(429, "sessions", {"Retry-After": "60"}))
    assert response.headers.get_list("retry-after") == ["60"]
    response = answer(HTTPException(503, "the process has ended", {"Retry-After": "1"}))
    assert response.headers["retry-after"] == "1"


def test_the_types_of_those_that_the_guard_refuses(client: httpx.Client) -> None:
    for headers in ({"host": "evil.example"}, {"origin": "http://evil.example"}):
        told = client.get("/api/v1/scenarios", headers=headers).json()
        assert told["type"] == f"{PREFIX}foreign-request"
