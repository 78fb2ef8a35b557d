"""Strict parsing of JSON bodies."""

from __future__ import annotations

import asyncio
import json
import typing
from collections.abc import Callable, Coroutine, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pydantic_core
from fastapi import HTTPException, Request, Response
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute
from pydantic import BaseModel
from starlette.exceptions import HTTPException as AnyHTTPException

from motionlab.config.bounds import DEPTH_MAX, check_depth, check_text
from motionlab.errors import ConfigError, FieldError
from motionlab.server.http.problems import responses

MEMBERS_MAX = 100_000
"""Members of tables and items of lists of a body; a drawn path of 6000 points has 18,000."""

_SEPARATORS = (b",", b"[", b"{")
_NESTED = (dict, list)
_IN_THREAD = 32 * 1024
"""Bytes from which reading a body takes a thread, so that it does not delay streams."""

_READER = ThreadPoolExecutor(1, thread_name_prefix="json")
"""A single thread: each further one would take as much of the interpreter's lock from STOP."""


class JsonRoute(APIRoute):
    """A route that refuses keys of a query that it does not know, and keys that come twice."""

    def __init__(self, path: str, endpoint: Callable[..., Any], **options: Any) -> None:
        declared = {**responses(422), **(options.pop("responses", None) or {})}
        super().__init__(path, endpoint, responses=declared, **options)

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler with strict JSON parsing of its requests."""
        handler = super().get_route_handler()
        keys_of = _query_keys(self.dependant)
        known, lists = sorted(keys_of), {key for key, several in keys_of.items() if several}
        stops = self.path.endswith("/stop")  # which nothing odd beside it may keep from stopping

        async def handle(request: Request) -> Response:
            if not stops:
                refuse_unknown(request.query_params, known)
            keys = [key for key, _ in request.query_params.multi_items() if key not in lists]
            if len(keys) > len(set(keys)) and not stops:
                twice = next(key for key in keys if keys.count(key) > 1)
                raise ConfigError(FieldError(twice, "comes twice in the query"))
            try:
                return await handler(_JsonRequest(request.scope, request.receive))
            except AnyHTTPException as error:
                if isinstance(error.__cause__, ConfigError):  # FastAPI took it for broken JSON
                    raise error.__cause__ from None
                raise

        return handle


def refuse_unknown(query: Iterable[str], known: Sequence[str] = ()) -> None:
    """Refuse keys of a query that are not known.

    Raises
    ------
    ConfigError
        Naming each of them.
    """
    unknown = [key for key in query if key not in known]
    if unknown:
        allowed = f"one of {', '.join(known)}" if known else "no query"
        raise ConfigError(
            *(FieldError(key, "is no key of this query", range=allowed) for key in unknown)
        )


def _query_keys(dependant: Dependant) -> dict[str, bool]:
    """Return the keys of a query that a route and its dependencies read; whether they are lists."""
    keys: dict[str, bool] = {}
    for below in dependant.dependencies:
        keys |= _query_keys(below)
    for field in dependant.query_params:
        kind = field.field_info.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            fields = kind.model_fields.items()
            keys |= {one.alias or name: _is_list(one.annotation) for name, one in fields}
        else:
            keys[field.alias] = _is_list(kind)
    return keys


def _is_list(annotation: Any) -> bool:
    """Return whether a key may come several times: a list, or one among alternatives."""
    origin = typing.get_origin(annotation)
    if origin in {list, tuple, set, frozenset} or annotation in {list, tuple, set}:
        return True
    return any(_is_list(each) for each in typing.get_args(annotation))


class _JsonRequest(Request):
    async def json(self) -> Any:
        body = await self.body()
        if len(body) < _IN_THREAD:
            return _read(body)
        return await asyncio.get_running_loop().run_in_executor(_READER, _read, body)


def _read(body: bytes) -> Any:
    if sum(map(body.count, _SEPARATORS)) > MEMBERS_MAX:
        raise HTTPException(422, f"the body has more than {MEMBERS_MAX} members and items")
    try:
        content = _parsed(body)
        check_depth(content, loc="body")
        if not body.isascii() or b"\\u" in body or b"\0" in body:  # of UTF-16
            check_text(content, loc="body")
    except RecursionError:
        raise HTTPException(422, "the body is nested too deeply") from None
    except json.JSONDecodeError:
        raise
    except ValueError as error:  # no Unicode, or a whole number of too many digits
        raise HTTPException(400, f"the body cannot be read: {error}") from None
    return content


def _parsed(body: bytes) -> Any:
    """Return the content of a body; the slower parser names what the fast one cannot take."""
    try:
        # Ten times as fast, and so long at most does STOP wait for the lock.
        content = pydantic_core.from_json(body)
    except ValueError:
        return json.loads(body, object_pairs_hook=_table)
    if _members(content) < _written_members(body):
        return json.loads(body, object_pairs_hook=_table)
    return content


def _members(content: Any) -> int:
    """Return the members of all tables; not those of tables below `DEPTH_MAX`."""
    count, level = 0, [content]
    for _ in range(DEPTH_MAX + 1):
        tables = [each for each in level if isinstance(each, dict)]
        count += sum(map(len, tables))
        lists = [each for each in level if isinstance(each, list)]
        level = [item for some in tables for item in some.values() if isinstance(item, _NESTED)]
        level += [item for some in lists for item in some if isinstance(item, _NESTED)]
    return count


def _written_members(body: bytes) -> int:
    """Return the members of all tables of valid JSON as it is written: its colons in no text."""
    plain = body.replace(rb"\\", b"").replace(rb"\"", b"")
    return sum(part.count(b":") for part in plain.split(b'"')[::2])


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise HTTPException(400, f"the key {key!r} comes twice in one table")
        table[key] = value
    return table
