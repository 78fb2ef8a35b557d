"""Isolate errors of one viewer's websocket from the others."""

from __future__ import annotations

import asyncio
import functools
import logging
from collections.abc import Awaitable, Callable, Coroutine, Generator
from contextvars import ContextVar
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

Handler = Callable[[ServerConnection], Awaitable[None]]

NOT_UNDERSTOOD = 1007
"""Close code after an invalid message."""

_QUOTED = 200  # characters of a viewer's message
_LOG = logging.getLogger(__name__)


class _Visit:
    """A viewer's connection and whether it was closed for an invalid message."""

    def __init__(self, connection: ServerConnection) -> None:
        self.connection = connection
        self.over = False


_visit: ContextVar[_Visit | None] = ContextVar("visit", default=None)


def viewer_name() -> str:
    """Return the name in the address by which the viewer at hand has connected, or none."""
    visit = _visit.get()
    request = None if visit is None else visit.connection.request
    return "" if request is None else request.path.strip("/")


def contained(handler: Handler) -> Handler:
    """Return a handler of connections, any failure of which closes its own with a line in the log.

    viser reads and handles messages in tasks that are never awaited: an invalid one would print a
    traceback, and its viewer might stay. The context of a task identifies its connection.
    """

    @functools.wraps(handler)
    async def contain(connection: ServerConnection) -> None:
        visit = _Visit(connection)
        _visit.set(visit)
        asyncio.get_running_loop().set_task_factory(_task)
        try:
            await handler(connection)
        except ConnectionClosed:
            pass
        except Exception as error:
            await _turn_away(visit, error)

    return contain


def _task(
    loop: asyncio.AbstractEventLoop,
    work: Coroutine[Any, Any, Any] | Generator[Any, None, Any],
    **options: Any,
) -> asyncio.Task[Any]:
    task = asyncio.Task(work, loop=loop, **options)
    visit = _visit.get()
    if visit is not None:
        task.add_done_callback(functools.partial(_look_at, visit))
    return task


def _look_at(visit: _Visit, task: asyncio.Task[Any]) -> None:
    error = None if task.cancelled() else task.exception()
    if isinstance(error, Exception) and not isinstance(error, ConnectionClosed):
        task.get_loop().create_task(_turn_away(visit, error))


async def _turn_away(visit: _Visit, error: Exception) -> None:
    if not visit.over:
        visit.over = True
        _LOG.warning(
            "invalid message from a viewer, connection closed: %s",
            repr(error)[:_QUOTED],
        )
        await visit.connection.close(NOT_UNDERSTOOD, "invalid message")
