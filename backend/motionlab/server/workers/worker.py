"""A worker process: it carries out one call at a time and ends with the server."""

from __future__ import annotations

import ctypes
import gc
import os
import pickle
import resource
import select
import signal
import socket
import sys
import time
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any

from fastapi import HTTPException
from pydantic import BaseModel

from motionlab.errors import MotionLabError
from motionlab.lanes.bank import TABLES
from motionlab.own_laws.accepted import renew_accepted
from motionlab.server.workers.channel import Failure, Inbox, Received, send

SPARE = 1_000_000_000
"""Allocations of a call beyond its reserved memory, bytes."""

_PR_SET_PDEATHSIG = 1
_PAUSE = 0.05  # s between reports of progress, at least
_SHARE = 20  # times as long as a report took, at least
_PARTIAL_MAX = 4_000_000  # bytes of a partial result; a larger one is not sent
_IGNORED = (signal.SIGINT, signal.SIGTERM)  # the server ends its workers


class Cancelled(BaseException):
    """Raised inside a call that was cancelled."""


class Call:
    """A call, as the function that carries it out sees it.

    Parameters
    ----------
    sock : socket.socket
        Leads to the server.
    inbox : Inbox
        Messages of the server.
    held : int
        Memory already reserved by the server, bytes.
    """

    def __init__(self, sock: socket.socket, inbox: Inbox, held: int) -> None:
        self._socket = sock
        self._inbox = inbox
        self._held = held
        self._next = 0.0
        self._share = 0.0
        self._partial: BaseModel | None = None
        _allow(held)

    def hold(self, size: int) -> None:
        """Reserve memory until the call's answer has been sent.

        Raises
        ------
        ConfigError
            If it is larger than the whole budget.
        HTTPException
            429 if it is in use.
        """
        send(self._socket, ("hold", size))
        _, refusal = self._answer()
        if refusal is not None:
            raise refusal.error()
        self._held += size
        _allow(self._held)

    def progress(self, share: float, partial: BaseModel | None = None) -> None:
        """Report progress and partial results; end the call if cancelled."""
        if select.select([self._socket], [], [], 0)[0]:
            self._answer()
        self._share, self._partial = share, partial or self._partial
        if time.monotonic() >= self._next:
            self._tell()

    def finish(self) -> None:
        """Send the pending partial result."""
        if self._partial is not None:
            self._tell()

    def _tell(self) -> None:
        now = time.monotonic()
        content = None if self._partial is None else self._partial.model_dump_json().encode()
        if content is not None and len(content) > _PARTIAL_MAX:
            content = None
        send(self._socket, ("progress", self._share), content)
        self._partial = None
        self._next = now + max(_PAUSE, _SHARE * (time.monotonic() - now))

    def _answer(self) -> tuple[str, Failure | None]:
        message = _next(self._socket, self._inbox).load()
        if message[0] == "cancel":
            raise Cancelled
        return message


def main(sock: socket.socket) -> None:
    """Carry out calls until the server is gone."""
    inbox = Inbox(sock)
    send(sock, ("ready", os.getpid()))
    while True:
        received = _next(sock, inbox)
        content = None
        try:
            message = received.load()
            if message[0] != "call":
                continue  # cancelled just when it was done
            _, function, arguments, environment, held = message
            _adopt(environment)
            renew_accepted()
            call = Call(sock, inbox, held)
            with TABLES.lease():
                content, value = _result(function(call, *arguments))
            call.finish()
        except Cancelled:
            answer: tuple[Any, ...] = ("cancelled",)
        except BaseException as error:
            answer = ("failed", _described(error))
        else:
            answer = ("done", value)
        received = message = arguments = value = None  # pyright: ignore[reportAssignmentType]
        _allow(0)
        send(sock, (*answer, resident()), content)
        del content


def end_with(parent: int) -> None:
    """Have the kernel end this process with its parent."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(0)


def settle_in(priority: int) -> None:
    """Lower the priority of this process and reset its signals."""
    for name in _IGNORED:
        signal.signal(name, signal.SIG_IGN)
    os.nice(priority)


def resident() -> int:
    """Return this process's resident memory, bytes."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def _allow(held: int) -> None:
    """Limit further allocation: present size, reservation and a margin."""
    if sys.platform != "linux":
        return
    status = Path("/proc/self/status").read_text(encoding="ascii")
    now = int(status.partition("VmData:")[2].split()[0]) * 1024
    most = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (now + held + SPARE, most))


def _next(sock: socket.socket, inbox: Inbox) -> Received:
    """Return the next message; at the end of them the process ends."""
    while True:
        for received in inbox.messages():
            return received
        try:
            if not inbox.fill():
                os._exit(0)
        except OSError:
            os._exit(0)


def _adopt(environment: dict[str, str | None]) -> None:
    for name, value in environment.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _result(value: object) -> tuple[bytes | None, object]:
    if isinstance(value, bytes):
        return value, None
    pickle.dumps(value)
    return None, value


def _described(error: BaseException) -> Failure:
    """Return an exception for the server, which logs where it came from if it is no answer."""
    if not isinstance(error, MotionLabError | HTTPException | MemoryError):
        text = "".join(traceback.format_exception(error))
        error.add_note(f"in a worker process:\n{text}")
    return Failure.of(error)


def run(sock: socket.socket, parent: int, priority: int) -> None:
    """Be a worker, right after the fork; never returns."""
    code = 1
    try:
        os.setpgid(0, 0)
        end_with(parent)
        sys.modules["__main__"] = ModuleType("__main__")  # what it starts need not load it
        settle_in(priority)
        gc.enable()
        _allow(0)
        main(sock)
        code = 0
    except BrokenPipeError:
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)
