"""The process that workers are forked from: single-threaded, fully loaded, without secrets.

``python -m motionlab.server.workers.forkserver DESCRIPTOR``: a fork takes some milliseconds where
a new interpreter takes seconds, and the compiled code is in memory once for all.
"""

from __future__ import annotations

import contextlib
import gc
import logging
import os
import select
import signal
import socket
import sys
from collections.abc import Callable

from motionlab.server import preload
from motionlab.server.workers import worker
from motionlab.server.workers.channel import (
    COMPLETE,
    ENDED,
    FORK,
    NOTICE,
    REQUEST,
    WARM,
    WARMER,
)

_PRIORITY = 10
_REST_AFTER = 3.0
"""Time without a request after which what only some calls need is loaded, s."""

_LOG = logging.getLogger(__name__)


class ForkServer:
    """Forks workers, ends them, and reports how they ended."""

    def __init__(self, control: socket.socket) -> None:
        self._control = control
        self._woken, self._wake = socket.socketpair()
        self._wake.setblocking(False)
        self._workers: dict[int, int] = {}  # process id to number

    def run(self) -> None:
        """Serve until the server is gone."""
        signal.set_wakeup_fd(self._wake.fileno(), warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        patience: float | None = _REST_AFTER
        while True:
            ready = select.select([self._control, self._woken], [], [], patience)[0]
            if not ready:
                patience = None
                _tried(preload.load_the_rest)
                self._say(COMPLETE, 0, 0)
            if self._woken in ready:
                self._woken.recv(4096)
                self._reap()
            if self._control in ready and not self._serve():
                return

    def _serve(self) -> bool:
        """Carry out one request; return False where the server is gone."""
        data, files, _, _ = socket.recv_fds(self._control, REQUEST.size, 1)
        while data and len(data) < REQUEST.size:
            data += self._control.recv(REQUEST.size - len(data))
        if not data:
            return False
        kind, number = REQUEST.unpack(data)
        if kind == FORK:
            self._fork(number, files[0])
        else:
            for pid in [pid for pid, known in self._workers.items() if known == number]:
                _kill(pid)
        return True

    def _fork(self, number: int, descriptor: int) -> None:
        parent = os.getpid()
        try:
            pid = os.fork()
        except OSError as error:
            os.close(descriptor)
            self._say(ENDED, number, -(error.errno or 0))
            return
        if pid == 0:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            for ours in (self._control, self._woken, self._wake):
                ours.close()
            worker.run(socket.socket(fileno=descriptor), parent, _PRIORITY)
        os.close(descriptor)
        with contextlib.suppress(OSError):  # both do it, so that neither has to wait
            os.setpgid(pid, pid)
        self._workers[pid] = number

    def _reap(self) -> None:
        while self._workers:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            number = self._workers.pop(pid)
            _kill(pid)  # what it has started
            self._say(ENDED, number, os.waitstatus_to_exitcode(status))

    def _say(self, kind: bytes, number: int, status: int) -> None:
        self._control.sendall(NOTICE.pack(kind, number, status))


def _kill(pid: int) -> None:
    """Kill a worker's process group."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)


def _tried(load: Callable[[], None]) -> bool:
    """Load a module, deferring a failure to the calls that need it."""
    loaded = True
    try:
        load()
    except Exception:
        _LOG.exception("not everything could be loaded beforehand")
        loaded = False
    gc.collect()
    gc.freeze()  # else the collector copies what all workers share
    return loaded


def main() -> None:
    """Load everything, then fork."""
    worker.end_with(int(sys.argv[2]))
    worker.settle_in(0)
    control = socket.socket(fileno=int(sys.argv[1]))
    server = ForkServer(control)

    def warmer(share: float) -> None:
        control.sendall(NOTICE.pack(WARMER, 0, round(100.0 * share)))

    loaded = _tried(lambda: preload.warm_up(warmer))
    control.sendall(NOTICE.pack(WARM, 0, not loaded))
    server.run()


if __name__ == "__main__":
    main()
