"""Answers that are too long for memory: written to disk, then sent as fast as they are read."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import BinaryIO

from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from motionlab.errors import StoreError, StoreFull
from motionlab.files import failure
from motionlab.server.http.connection_limits import READ_GRACE, READ_RATE, current

_PREFIX = "motionlab-scratch-"
_CHUNK = 256 * 1024  # bytes


@contextlib.contextmanager
def temporary_folder(root: Path | None = None) -> Iterator[Path]:
    """Provide a temporary folder for an answer; files open at its end stay readable.

    Parameters
    ----------
    root : Path, optional
        Where it is made; by default where the system has temporary files, which may be memory.

    Raises
    ------
    StoreError
        If it cannot be written; `StoreFull` where there is no room.
    """
    where = "the server's temporary folder"
    try:
        folder, lock = _locked_folder(root)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            os.close(lock)
    except OSError as error:
        raise failure(where, error) from error
    except StoreError as error:  # which names the path
        full = isinstance(error, StoreFull)
        raise (StoreFull if full else StoreError)(f"{where} cannot be written") from error


def _locked_folder(root: Path | None) -> tuple[Path, int]:
    """Make a temporary folder whose lock says that its server is alive."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=root))
        lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        fcntl.flock(lock, fcntl.LOCK_EX)
        if folder.exists():  # else a server that has just started took it for a leftover
            return folder, lock
        os.close(lock)


def remove_leftovers(root: Path) -> None:
    """Remove temporary folders of servers that were killed, also those in the folder of data."""
    places = (Path(tempfile.gettempdir()), root)
    for folder in (folder for place in places for folder in place.glob(f"{_PREFIX}*")):
        with contextlib.suppress(OSError):
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # or in use
                if os.fstat(lock).st_uid == os.geteuid():
                    shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(lock)


class Download(Response):
    """Sends a file; a client that reads it too slowly is cut off."""

    def __init__(
        self,
        file: BinaryIO,
        *,
        media_type: str,
        headers: dict[str, str],
        held: contextlib.AsyncExitStack,
    ) -> None:
        self._file = file
        self._held = held
        size = os.fstat(file.fileno()).st_size
        super().__init__(None, 200, headers | {"Content-Length": str(size)}, media_type)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it."""
        begun, sent = time.monotonic(), 0
        start = {"type": "http.response.start", "status": 200, "headers": self.raw_headers}
        async with self._held:
            with self._file:
                await send(start)
                async for chunk in self._chunks():
                    allowed = READ_GRACE + sent / READ_RATE - (time.monotonic() - begun)
                    try:
                        async with asyncio.timeout(max(allowed, 0.0)):
                            message = {"type": "http.response.body", "body": chunk}
                            await send({**message, "more_body": bool(chunk)})
                    except TimeoutError:
                        current().transport.abort()
                        return
                    sent += len(chunk)

    async def _chunks(self) -> AsyncIterator[bytes]:
        """Yield the file piece by piece, and then nothing."""
        while True:
            chunk = await asyncio.to_thread(self._file.read, _CHUNK)
            yield chunk
            if not chunk:
                return
