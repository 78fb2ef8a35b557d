"""Files that a request writes and downloads: a few at a time, within the memory budget."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from pathlib import Path

from fastapi import HTTPException, Request

from motionlab.service.http.download import Download, temporary_folder
from motionlab.service.memory_budget import MemoryBudget

WRITE_SECONDS = 120.0
"""Time after which writing a file is given up, s."""

_RETRY_SECONDS = 5
_WAIT_SECONDS = 60.0


async def file_download(
    request: Request,
    write: Callable[[Path], Awaitable[None]],
    *,
    name: str,
    media_type: str,
    size: int,
) -> Download:
    """Answer with a file, once one of the places for downloads is free.

    Parameters
    ----------
    request : Request
        The request.
    write : callable
        Writes the file; what it writes beside it is removed.
    name : str
        What the client calls the file.
    media_type : str
        Its content type.
    size : int
        Memory that is held until it has been sent, bytes; the temporary folder may lie in memory.
    """
    state = request.app.state
    memory: MemoryBudget = state.memory
    slots: asyncio.Semaphore = state.downloads
    if slots.locked() and state.downloads_waiting >= state.settings.downloads_waiting_max:
        raise _too_many(f"{state.downloads_waiting} files are waited for already")
    state.downloads_waiting += 1
    try:
        async with asyncio.timeout(_WAIT_SECONDS):
            await slots.acquire()
    except TimeoutError:
        most = state.settings.downloads_max
        raise _too_many(f"{most} files are being sent, and none has ended since") from None
    finally:
        state.downloads_waiting -= 1
    async with contextlib.AsyncExitStack() as held:
        held.callback(slots.release)
        held.enter_context(memory.hold(size))
        with temporary_folder() as folder:
            written = folder / "file"
            async with state.writing:
                await write(written)
            file = written.open("rb")
        return Download(
            file,
            media_type=media_type,
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
            held=held.pop_all(),
        )


def _too_many(detail: str) -> HTTPException:
    return HTTPException(429, detail, {"Retry-After": f"{_RETRY_SECONDS}"})
