"""JSON bodies, read as strictly as they are answered for."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute


class JsonRoute(APIRoute):
    """A route that refuses a body in which a key comes twice: which value is meant is a guess."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler, given requests that read their JSON this way."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            return await handler(_JsonRequest(request.scope, request.receive))

        return handle


class _JsonRequest(Request):
    async def json(self) -> Any:
        try:
            return json.loads(await self.body(), object_pairs_hook=_table)
        except json.JSONDecodeError:
            raise
        except ValueError as error:  # no Unicode, or a whole number of too many digits
            raise HTTPException(400, f"the body cannot be read: {error}") from None


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise HTTPException(400, f"the key {key!r} comes twice in one table")
        table[key] = value
    return table


def whole(value: Any) -> Any:
    """Return a number without fraction, such as 5.0, as the integer that it is to JSON."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
