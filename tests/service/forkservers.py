"""Fork servers for the servers in a test process, forked from one process that is loaded once.

What a fork server imports and warms up takes two seconds of processor time; servers that tests
start in their own process would take them each. A server that is a process has one of its own.
``python -m tests.service.forkservers DESCRIPTOR`` is the loaded process.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import gc
import os
import pickle
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

from motionlab.service import preload
from motionlab.service.workers import fork_client, forkserver
from tests.paths import ROOT

_LENGTH = struct.Struct("<I")
_PID = struct.Struct("<i")
_PR_SET_CHILD_SUBREAPER = 36
_ADOPTION = 10.0  # s until a fork server has its parent
_SHIPPED = fork_client._COMMAND
_start_process = fork_client.start_forkserver


class Forked(subprocess.Popen[bytes]):
    """A child that this process has not started itself."""

    def __init__(self, pid: int) -> None:
        self.args = "a forked fork server"
        self.stdin = self.stdout = self.stderr = None
        self.pid = pid
        self.returncode: Any = None
        self._waitpid_lock = threading.Lock()
        self._child_created = True


class Loaded:
    """The loaded process, started when it is first needed; it ends with this one."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._socket: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def start(self, control: socket.socket, environment: dict[str, str]) -> subprocess.Popen[bytes]:
        """Start a fork server, in place of `fork_client.start_forkserver`."""
        if fork_client._COMMAND is not _SHIPPED:
            return _start_process(control, environment)
        body = pickle.dumps((os.getpid(), os.getcwd(), environment))
        with self._lock:
            if self._socket is None:
                self._socket, self._process = _load(environment)
                atexit.register(self.close)
            with _adopting():
                head = _LENGTH.pack(len(body))
                socket.send_fds(self._socket, [head], [control.fileno(), 2])
                self._socket.sendall(body)
                (pid,) = _PID.unpack(_exactly(self._socket, _PID.size))
        return Forked(pid)

    def close(self) -> None:
        """End the loaded process."""
        if self._socket is not None and self._process is not None:
            self._socket.close()
            self._process.wait()


def install() -> None:
    """Have all servers of this process use forked fork servers."""
    if sys.platform == "linux":
        fork_client.start_forkserver = LOADED.start


def _load(environment: dict[str, str]) -> tuple[socket.socket, subprocess.Popen[bytes]]:
    ours, theirs = socket.socketpair()
    with theirs:
        process = subprocess.Popen(
            (sys.executable, "-m", "tests.service.forkservers", str(theirs.fileno())),
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            env=environment,
            pass_fds=(theirs.fileno(),),
            start_new_session=True,
        )
    return ours, process


@contextlib.contextmanager
def _adopting() -> Iterator[None]:
    """Become the parent of grandchildren whose parents end."""
    libc = ctypes.CDLL(None)
    libc.prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    try:
        yield
    finally:
        libc.prctl(_PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


def _exactly(sock: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        more = sock.recv(size - len(data))
        if not more:
            raise EOFError("the loaded process has ended")
        data += more
    return data


def main(requests: socket.socket) -> None:
    """Load what fork servers load, and fork one for each request."""
    preload.warm_up()
    preload.load_the_rest()
    gc.collect()
    gc.freeze()
    while True:
        head, files, _, _ = socket.recv_fds(requests, _LENGTH.size, 2)
        if not head:
            return
        (size,) = _LENGTH.unpack(head)
        parent, folder, environment = pickle.loads(_exactly(requests, size))
        read, write = os.pipe()
        between = os.fork()
        if between == 0:  # ends at once, so that the server's process adopts the fork server
            pid = os.fork()
            if pid == 0:
                requests.close()
                _be_fork_server(parent, folder, environment, *files)
            os.write(write, _PID.pack(pid))
            os._exit(0)
        os.waitpid(between, 0)
        requests.sendall(os.read(read, _PID.size))
        os.close(read)
        os.close(write)
        for file in files:
            os.close(file)


def _be_fork_server(
    parent: int, folder: str, environment: dict[str, str], control: int, stderr: int
) -> None:
    code = 1
    try:
        end = time.monotonic() + _ADOPTION
        while os.getppid() != parent:
            if time.monotonic() > end:
                return  # the server's process has been killed meanwhile
            time.sleep(0.001)
        os.setsid()
        os.dup2(stderr, 2)
        os.close(stderr)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv[1:] = [str(control), str(parent)]
        forkserver.main()
        code = 0
    finally:
        os._exit(code)


LOADED = Loaded()

if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
