"""The server's side of the fork server and its workers."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from fastapi import HTTPException

from motionlab.errors import MotionLabError
from motionlab.own_files import ACCEPTED
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.workers.channel import (
    COMPLETE,
    ENDED,
    FORK,
    KILL,
    NOTICE,
    REQUEST,
    WARM,
    WARMER,
    Contents,
    Failure,
    Inbox,
    Received,
    framed,
    too_deep,
)

_LOG = logging.getLogger(__name__)

_COMMAND = (sys.executable, "-m", "motionlab.server.workers.forkserver")
_SECRETS = ("MOTIONLAB_TOKEN", "MOTIONLAB_TOKEN_FILE", "MOTIONLAB_HOSTS")
_ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    # Its other pools reserve 1 GiB of addresses at once, which the limit of a worker counts.
    "ARROW_DEFAULT_MEMORY_POOL": "system",
}
_ADOPTED = ("MOTIONLAB_DATA", "MOTIONLAB_CONFIGS", ACCEPTED)
_AGAIN_AFTER = 1.0  # s until a fork server that has ended is started again
_ENDING = 0.02  # s from its last message to its status
_NEVER_WARM = "the processes that compute cannot be started: {}; the server's log has more"

OnProgress = Callable[[float, bytes | None], None]


class ForkLost(MotionLabError):
    """A worker process that ended before its call."""


class CallResult:
    """The result of a call, with the memory reserved until it is forwarded.

    Attributes
    ----------
    value : object
        What the function returned, if that were not bytes.
    contents : Contents or None
        The bytes that it returned.
    """

    def __init__(
        self, value: Any, contents: Contents | None, held: int, memory: MemoryBudget
    ) -> None:
        self.value = value
        self.contents = contents
        self._held = held
        self._memory = memory

    def read(self) -> bytes:
        """Return the bytes and release the reserved memory."""
        assert self.contents is not None
        content = self.contents.read()
        self.close()
        return content

    def close(self) -> None:
        """Release the reserved memory."""
        if self.contents is not None:
            self.contents.close()
        self._memory.give_back(self._held)
        self._held = 0


class Worker:
    """One worker process.

    Parameters
    ----------
    sock : socket.socket
        Leads to it.
    kill : callable
        Has the fork server end it.
    memory : MemoryBudget
        Memory for its calls.
    held : int
        Memory already reserved for its first call, bytes.
    """

    def __init__(
        self, sock: socket.socket, kill: Callable[[], None], memory: MemoryBudget, held: int
    ) -> None:
        loop = asyncio.get_running_loop()
        sock.setblocking(False)
        self.pid = 0
        self.resident = 0
        self.started: asyncio.Future[None] = loop.create_future()
        self.ended: asyncio.Future[str] = loop.create_future()
        self.kill = kill
        self._loop = loop
        self._socket = sock
        self._inbox = Inbox(sock)
        self._memory = memory
        self._held = held
        self._call: asyncio.Future[CallResult] | None = None
        self._on_progress: OnProgress | None = None
        loop.add_reader(sock, self._read)

    @property
    def alive(self) -> bool:
        """Whether it can take a call."""
        return not self.ended.done()

    @property
    def busy(self) -> bool:
        """Whether it carries out a call, wanted or not."""
        return self.alive and self._call is not None

    async def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        on_progress: OnProgress | None = None,
    ) -> CallResult:
        """Call a function in the worker; return its result or raise its exception.

        Parameters
        ----------
        function : callable
            Of a module; takes a `Call` before the arguments.
        arguments
            Anything that can be pickled.
        on_progress : callable, optional
            Takes the share done and the JSON of a new partial result.

        Raises
        ------
        WorkerLost
            If the process ends first.
        ConfigError
            If the arguments are nested too deeply to be sent.
        """
        if not self.alive:
            raise ForkLost(self.ended.result())
        environment = {name: os.environ.get(name) for name in _ADOPTED}
        try:
            data = framed(("call", function, arguments, environment, self._held))
        except RecursionError:
            raise too_deep() from None
        call = self._call = self._loop.create_future()
        self._on_progress = on_progress
        try:
            await self._loop.sock_sendall(self._socket, data)
        except asyncio.CancelledError:
            self.kill()  # half a message is none
            raise
        except OSError:  # it has ended; its status is on its way
            pass
        try:
            return await call
        except asyncio.CancelledError:
            if call.done() and not call.cancelled():  # answered just when it was given up
                call.result().close()
            raise

    async def cancel(self, patience: float) -> None:
        """Have it end its call; it ends altogether where that takes too long."""
        if not self.busy:
            return
        self._call = self._loop.create_future()
        with contextlib.suppress(OSError):
            self._socket.send(framed(("cancel",)))
        try:
            async with asyncio.timeout(patience):
                (await self._call).close()
        except TimeoutError:
            self.kill()
            await asyncio.wait([self.ended])
        except Exception:  # however it ended, it has
            return

    def end(self, reason: str) -> None:
        """Record the end of the process, after its remaining messages."""
        if self.ended.done():
            return
        with contextlib.suppress(OSError):
            while self._fill():
                pass
        self._loop.remove_reader(self._socket)
        self._socket.close()
        self._inbox.close()
        self._memory.give_back(self._held)
        self._held = 0
        self.ended.set_result(reason)
        if not self.started.done():
            self.started.set_exception(ForkLost(reason))
            self.started.exception()
        self._finish(ForkLost(reason))

    def _read(self) -> None:
        try:
            if not self._fill():
                self._loop.remove_reader(self._socket)
        except BlockingIOError:
            return
        except OSError:
            self._loop.remove_reader(self._socket)

    def _fill(self) -> bool:
        more = self._inbox.fill()
        for received in self._inbox.messages():
            self._take(received)
        return more

    def _take(self, received: Received) -> None:
        match received.load():
            case ("ready", pid):
                self.pid = pid
                self.started.set_result(None)
            case ("hold", size):
                self._hold(size)
            case ("progress", share):
                partial = None
                if received.contents is not None:
                    partial = received.contents.read()
                    received.contents.close()
                if self._on_progress is not None:
                    self._on_progress(share, partial)
            case (kind, *rest, resident):
                self.resident = resident
                held, self._held = self._held, 0
                if kind == "done":
                    self._finish(CallResult(rest[0], received.contents, held, self._memory))
                    return
                self._memory.give_back(held)
                error = rest[0].error() if kind == "failed" else ForkLost("it was cancelled")
                self._finish(error)
            case _:
                raise ValueError("a message of an unknown form")

    def _hold(self, size: int) -> None:
        refusal = None
        try:
            self._memory.check(size)
            self._memory.take(size)
            self._held += size
        except (MotionLabError, HTTPException) as error:
            refusal = Failure.of(error)
        with contextlib.suppress(OSError):
            self._socket.send(framed(("hold", refusal)))

    def _finish(self, result: CallResult | BaseException) -> None:
        call, self._call, self._on_progress = self._call, None, None
        if call is None or call.done():  # given up meanwhile
            if isinstance(result, CallResult):
                result.close()
        elif isinstance(result, CallResult):
            call.set_result(result)
        else:
            call.set_exception(result)


def start_forkserver(
    control: socket.socket, environment: dict[str, str]
) -> subprocess.Popen[bytes]:
    """Start a fork server that ends with this thread."""
    return subprocess.Popen(
        (*_COMMAND, str(control.fileno()), str(os.getpid())),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env=environment,
        pass_fds=(control.fileno(),),
        start_new_session=True,
    )


class Forks:
    """The fork server, started again when it ends."""

    def __init__(self, memory: MemoryBudget) -> None:
        self.settled = asyncio.Event()
        """Set once all that simulations need is loaded, or is known not to be."""
        self.warmth = 0.0
        """Share of it that is loaded or compiled, 0 to 1."""
        self.failure: str | None = None
        """Why no process can be started."""
        self.incomplete = False
        """Whether something could not be loaded or compiled."""
        self.complete = asyncio.Event()
        """Set once everything else is."""
        self._memory = memory
        self._loop = asyncio.get_running_loop()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._notices = bytearray()
        self._workers: dict[int, Worker] = {}
        self._numbers = 0
        self._warm = False
        self._closed = False

    @property
    def pid(self) -> int:
        """Process id of the fork server."""
        return 0 if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the fork server, from the event loop's thread: it ends with that."""
        if self._closed:
            return
        ours, theirs = socket.socketpair()
        environment = {k: v for k, v in os.environ.items() if k not in _SECRETS} | _ENVIRONMENT
        with theirs:
            self._process = start_forkserver(theirs, environment)
        ours.setblocking(False)
        self._control = ours
        self._warm = False
        self._notices.clear()
        self._loop.add_reader(ours, self._listen)

    def fork(self, held: int = 0) -> Worker:
        """Return a new worker, which starts once the fork server is warm.

        Parameters
        ----------
        held : int
            Memory already reserved for its first call, bytes; the worker releases it.

        Raises
        ------
        WorkerLost
            If the fork server cannot be reached.
        """
        ours, theirs = socket.socketpair()
        number = self._numbers = (self._numbers + 1) % 2**32
        with theirs:
            try:
                assert self._control is not None
                request = REQUEST.pack(FORK, number)
                socket.send_fds(self._control, [request], [theirs.fileno()])
            except (OSError, AssertionError):
                ours.close()
                self._memory.give_back(held)
                raise ForkLost("the fork server cannot be reached") from None
        worker = Worker(ours, lambda: self._kill(number), self._memory, held)
        self._workers[number] = worker
        return worker

    def close(self) -> None:
        """End the fork server and every worker."""
        self._closed = True
        for number in list(self._workers):
            self._kill(number)
        self._disconnect("the server ends")

    def _kill(self, number: int) -> None:
        if number in self._workers and self._control is not None:
            with contextlib.suppress(OSError):
                self._control.send(REQUEST.pack(KILL, number))

    def _listen(self) -> None:
        assert self._control is not None
        try:
            data = self._control.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self._notices += data
        size = NOTICE.size
        while len(self._notices) >= size:
            kind, number, status = NOTICE.unpack_from(self._notices)
            del self._notices[:size]
            if kind == WARMER:
                self.warmth = status / 100.0
            elif kind == WARM:
                self._warm, self.failure, self.incomplete = True, None, bool(status)
                self.settled.set()
            elif kind == COMPLETE:
                self.complete.set()
            elif kind == ENDED and (worker := self._workers.pop(number, None)) is not None:
                worker.end(_reason(status))
        if not data:
            assert self._process is not None
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_ENDING)
            self._disconnect("the fork server has ended")
            reason = _reason(self._process.returncode)
            _LOG.error("the fork server has ended: %s; it is started again", reason)
            if not self._warm:
                self.failure = _NEVER_WARM.format(reason)
                self.settled.set()
            self._loop.call_later(_AGAIN_AFTER, self.start)

    def _disconnect(self, reason: str) -> None:
        """End the fork server, whose end ends its workers."""
        control, self._control = self._control, None
        if control is None or self._process is None:
            return
        self._loop.remove_reader(control)
        control.close()
        self._process.kill()
        self._process.wait()
        for worker in list(self._workers.values()):
            worker.end(reason)
        self._workers.clear()


def _reason(status: int) -> str:
    """Return in words how a process ended."""
    if status >= 0:
        return f"its process ended with status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    more = "; is there enough memory?" if name == "SIGKILL" else ""
    return f"its process was ended by {name}{more}"
