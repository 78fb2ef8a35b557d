"""Messages between the server and a worker: pickled, by length, with a file where one is large."""

from __future__ import annotations

import contextlib
import os
import pickle
import socket
import struct
import tempfile
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

from motionlab.errors import ConfigError, FieldError

REQUEST = struct.Struct("<cI")
"""Requests to the fork server: to fork or to kill, and the number of the worker."""
NOTICE = struct.Struct("<cIi")
"""Messages of the fork server: how much of it is warm, in percent, that it is, that it is complete,
or which worker ended with what status."""
FORK, KILL, WARMER, WARM, COMPLETE, ENDED = b"f", b"k", b"p", b"w", b"c", b"e"

_HEAD = struct.Struct("<I?")  # length; whether a file comes with it
_READ = 1 << 16
_CHUNK = 1 << 18


class Contents:
    """Bytes that a worker has written, in a file that only lives in memory."""

    def __init__(self, descriptor: int) -> None:
        self._file = os.fdopen(descriptor, "rb", buffering=0)
        self.size = os.fstat(descriptor).st_size

    def read(self) -> bytes:
        """Return all of it."""
        return b"".join(self.chunks())

    def chunks(self) -> Iterator[bytes]:
        """Yield it piece by piece."""
        for start in range(0, self.size, _CHUNK):
            yield os.pread(self._file.fileno(), min(_CHUNK, self.size - start), start)

    def close(self) -> None:
        """Free it; data already read stay valid."""
        self._file.close()


class Received(NamedTuple):
    """One message."""

    body: bytes
    contents: Contents | None

    def load(self) -> Any:
        """Return the message's content."""
        return pickle.loads(self.body)


class Failure(NamedTuple):
    """A pickled exception, independent of the arguments of its class."""

    kind: type[BaseException]
    args: tuple[Any, ...]
    attributes: dict[str, Any]

    @classmethod
    def of(cls, error: BaseException) -> Failure:
        """Return a picklable form of an exception, its description if necessary.

        One that would end a process, such as SystemExit, ends no more than the call.
        """
        described = cls(RuntimeError, (f"{type(error).__name__}: {error}",), {})
        if not isinstance(error, Exception):
            return described
        failure = cls(type(error), error.args, error.__dict__)
        try:
            pickle.loads(pickle.dumps(failure)).error()
        except RecursionError:
            return cls.of(too_deep())
        except Exception:
            return described
        return failure

    def error(self) -> BaseException:
        """Return the exception."""
        error = self.kind.__new__(self.kind, *self.args)
        error.args = self.args
        error.__dict__.update(self.attributes)
        return error


def too_deep() -> ConfigError:
    """Return an error if a body is nested too deeply."""
    return ConfigError(FieldError("body", "is nested too deeply"))


def framed(message: object, *, with_file: bool = False) -> bytes:
    """Return a message as it is sent."""
    body = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    return _HEAD.pack(len(body), with_file) + body


class Inbox:
    """Messages that come out of a socket's bytes.

    Parameters
    ----------
    sock : socket.socket
        Read by `fill`; blocking or not.
    """

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._bytes = bytearray()
        self._files: deque[int] = deque()

    def fill(self) -> bool:
        """Read once from the socket; return False at end of file."""
        data, files, _, _ = socket.recv_fds(self._socket, _READ, 16)
        self._files.extend(files)
        self._bytes += data
        return bool(data)

    def messages(self) -> Iterator[Received]:
        """Yield the messages that are there in full."""
        while len(self._bytes) >= _HEAD.size:
            length, with_file = _HEAD.unpack_from(self._bytes)
            end = _HEAD.size + length
            if len(self._bytes) < end:
                return
            body = bytes(memoryview(self._bytes)[_HEAD.size : end])
            del self._bytes[:end]
            contents = Contents(self._files.popleft()) if with_file else None
            yield Received(body, contents)

    def close(self) -> None:
        """Close files that no message has claimed."""
        while self._files:
            os.close(self._files.popleft())


def send(sock: socket.socket, message: object, content: bytes | None = None) -> None:
    """Send a message, and a large payload beside it, through a blocking socket."""
    data = framed(message, with_file=content is not None)
    if content is None:
        sock.sendall(data)
        return
    descriptor = _memory_file()
    try:
        rest = memoryview(content)
        while rest:
            rest = rest[os.write(descriptor, rest) :]
        sent = socket.send_fds(sock, [data], [descriptor])
    finally:
        os.close(descriptor)
    sock.sendall(data[sent:])


def _memory_file() -> int:
    if hasattr(os, "memfd_create"):
        return os.memfd_create("motionlab")
    with contextlib.ExitStack() as closed:  # elsewhere a file without a name
        file = closed.enter_context(tempfile.TemporaryFile())
        return os.dup(file.fileno())
