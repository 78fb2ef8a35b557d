"""Strict parsing of JSON bodies."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.routing import APIRoute

from motionlab.config.bounds import check_depth, check_text
from motionlab.errors import ConfigError

MEMBERS_MAX = 100_000
"""Members of tables and items of lists of a body; a drawn path of 6000 points has 18,000."""

_SEPARATORS = (b",", b"[", b"{")
_IN_THREAD = 32 * 1024
"""Bytes from which reading a body takes a thread, so that it does not delay streams."""


class JsonRoute(APIRoute):
    """A route that refuses a body in which a key comes twice: which value is meant is a guess."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler with strict JSON parsing of its requests."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(_JsonRequest(request.scope, request.receive))

        return handle


class _JsonRequest(Request):
    async def json(self) -> Any:
        body = await self.body()
        return _read(body) if len(body) < _IN_THREAD else await run_in_threadpool(_read, body)


def _read(body: bytes) -> Any:
    if sum(map(body.count, _SEPARATORS)) > MEMBERS_MAX:
        raise HTTPException(422, f"the body has more than {MEMBERS_MAX} members and items")
    try:
        content = json.loads(body, object_pairs_hook=_table)
        check_depth(content, loc="body")
        if not body.isascii() or b"\\u" in body or b"\0" in body:  # of UTF-16
            check_text(content, loc="body")
    except ConfigError as error:  # which FastAPI takes for broken JSON
        raise HTTPException(422, str(error)) from None
    except RecursionError:
        raise HTTPException(422, "the body is nested too deeply") from None
    except json.JSONDecodeError:
        raise
    except ValueError as error:  # no Unicode, or a whole number of too many digits
        raise HTTPException(400, f"the body cannot be read: {error}") from None
    return content


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise HTTPException(400, f"the key {key!r} comes twice in one table")
        table[key] = value
    return table
