"""Files that a request writes and downloads: a few at a time, within the memory budget."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
from collections.abc import Awaitable, Callable
from pathlib import Path

from fastapi import HTTPException, Request
from starlette.datastructures import State

from motionlab.config.named_configs import data_root
from motionlab.errors import StoreFull
from motionlab.library.library import FREE_LEAST
from motionlab.server.http.download import Download, temporary_folder

WRITE_SECONDS = 120.0
"""Time after which writing a file is given up, s."""

_LONG = 8  # part of `memory_max` above which a file is written in the folder of data
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
        Bytes that it has at most. As much memory is held until it has been sent, because the
        temporary folder may lie in memory. A file above an eighth of `memory_max` is written in the
        folder of data instead, one at a time, and holds none.
    """
    state = request.app.state
    long = size > state.settings.memory_max // _LONG
    async with contextlib.AsyncExitStack() as held, contextlib.AsyncExitStack() as turn:
        if long:
            await _acquire(state.writing_long, "another file as long is being written")
            turn.callback(state.writing_long.release)
            _check_room(size)
        await _take_place(state)
        held.callback(state.downloads.release)
        if not long:
            held.enter_context(state.memory.hold(size))
        with temporary_folder(data_root() if long else None) as folder:
            written = folder / "file"
            if not long:
                await turn.enter_async_context(state.writing)
            await write(written)
            file = written.open("rb")
        return Download(
            file,
            media_type=media_type,
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
            held=held.pop_all(),
        )


async def _take_place(state: State) -> None:
    """Take one of the places for downloads."""
    if state.downloads.locked() and state.downloads_waiting >= state.settings.downloads_waiting_max:
        raise _too_many(f"{state.downloads_waiting} files are waited for already")
    state.downloads_waiting += 1
    try:
        most = state.settings.downloads_max
        await _acquire(state.downloads, f"{most} files are being sent, and none has ended since")
    finally:
        state.downloads_waiting -= 1


async def _acquire(places: asyncio.Semaphore | asyncio.Lock, why: str) -> None:
    try:
        async with asyncio.timeout(_WAIT_SECONDS):
            await places.acquire()
    except TimeoutError:
        raise _too_many(why) from None


def _check_room(size: int) -> None:
    """Refuse a file that would leave recordings no room on their disk."""
    free = shutil.disk_usage(data_root()).free
    if free - size < FREE_LEAST:
        raise StoreFull(
            f"the disk of the data has {free} bytes free; the file takes {size}, and {FREE_LEAST} "
            "must be left: choose fewer columns or a shorter range"
        )


def _too_many(detail: str) -> HTTPException:
    return HTTPException(429, detail, {"Retry-After": f"{_RETRY_SECONDS}"})
