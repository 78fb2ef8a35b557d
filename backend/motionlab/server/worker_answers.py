"""Answers that worker processes compute."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Callable, Coroutine, Mapping
from typing import Any, TypeVar

from fastapi import HTTPException, Request, Response
from pydantic import TypeAdapter
from starlette.types import Receive, Scope, Send

from motionlab.server.settings import Settings
from motionlab.server.workers.channel import Contents
from motionlab.server.workers.fork_client import CallResult
from motionlab.server.workers.pool import CALL_SECONDS, LIGHT_SECONDS, Workers
from motionlab.server.workers.worker import Call

NUMBERS = "application/octet-stream"
"""Media type of `motionlab.telemetry.packed`."""

_LOG = logging.getLogger(__name__)

_SEND_SECONDS = 300.0
"""Time that a client has to take an answer in, s."""
_WHOLE_MAX = 4_000_000
"""Largest answer that is sent in one piece, and so can be compressed, bytes."""
_ANY: TypeAdapter[Any] = TypeAdapter(Any)

_T = TypeVar("_T")


class ComputedResponse(Response):
    """Bytes that a worker has written, sent as fast as the client takes them."""

    def __init__(
        self,
        answer: CallResult,
        status_code: int = 200,
        headers: Mapping[str, str] | None = None,
        media_type: str = "application/json",
    ) -> None:
        super().__init__(None, status_code, headers, media_type)
        assert answer.contents is not None
        self._answer = answer
        self._contents: Contents = answer.contents
        self.headers["content-length"] = str(self._contents.size)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it."""
        start = {"type": "http.response.start", "status": self.status_code}
        try:
            async with asyncio.timeout(_SEND_SECONDS):
                await send(start | {"headers": self.raw_headers})
                if self._contents.size <= _WHOLE_MAX:
                    await send({"type": "http.response.body", "body": self._contents.read()})
                    return
                for chunk in self._contents.chunks():
                    await send({"type": "http.response.body", "body": chunk, "more_body": True})
                await send({"type": "http.response.body", "body": b""})
        except RuntimeError as error:
            if "closed=True" not in str(error):  # uvloop's error for a transport without a client
                raise
            _LOG.debug("%s: the client has left", scope["path"])
        finally:
            self._answer.close()


async def computed(
    request: Request,
    function: Callable[..., Any],
    *arguments: Any,
    light: bool = False,
    seconds: float | None = None,
) -> ComputedResponse:
    """Answer with the JSON of a function's result, computed by a worker.

    Parameters
    ----------
    request : Request
        The request; a client that disconnects gives up its place.
    function : callable
        Of a module; returns a document.
    arguments
        What it takes; anything that can be pickled.
    light : bool
        Whether it takes milliseconds as a rule.
    seconds : float, optional
        Time after which it is given up, s.
    """
    return ComputedResponse(
        await called(request, json_of, function, arguments, light=light, seconds=seconds)
    )


async def called(
    request: Request,
    function: Callable[..., Any],
    *arguments: Any,
    light: bool = False,
    seconds: float | None = None,
) -> CallResult:
    """Return the result of a function of a `Call` and arguments; see `computed`."""
    workers: Workers = request.app.state.workers
    seconds = seconds or (LIGHT_SECONDS if light else CALL_SECONDS)
    return await _while_connected(
        request, workers.run(function, *arguments, light=light, seconds=seconds)
    )


def json_of(_: Call, function: Callable[..., Any], arguments: tuple[Any, ...]) -> bytes:
    """Return the JSON of a function's result."""
    document = _ANY.dump_python(function(*arguments), mode="json", by_alias=True)
    return json.dumps(document, allow_nan=False, ensure_ascii=False, separators=(",", ":")).encode()


def result_of(
    call: Call, function: Callable[..., Any], request: bytes, settings: Settings
) -> bytes:
    """Return the JSON of a job's result, whose function takes the call, the request and bounds."""
    return _ANY.dump_json(function(call, json.loads(request), settings), by_alias=True)


async def _while_connected(request: Request, work: Coroutine[Any, Any, _T]) -> _T:
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_left(request))
    try:
        await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
        if not working.done():
            raise HTTPException(503, "the client has left")
        return working.result()
    finally:
        working.cancel()
        leaving.cancel()


async def _left(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
