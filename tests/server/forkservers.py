"""Fork servers and programs of a test process, forked from one process that is loaded once.

What a fork server imports and warms up takes two seconds of processor time, what a command or a
server imports as much again; tests that start many would take them each.
``python -m tests.server.forkservers DESCRIPTOR`` is the loaded process.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import gc
import importlib
import os
import pickle
import runpy
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from motionlab.server import preload
from motionlab.server.workers import fork_client, forkserver
from tests.paths import ROOT

_LENGTH = struct.Struct("<I")
_PID = struct.Struct("<i")
_PR_SET_CHILD_SUBREAPER = 36
_ADOPTION = 10.0  # s until a fork server has its parent
_SHIPPED = fork_client._COMMAND
_start_process = fork_client.start_forkserver


class Forked(subprocess.Popen[bytes]):
    """A child that this process has not started itself."""

    def __init__(self, pid: int, name: str = "a forked fork server") -> None:
        self.args = name
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
        return Forked(self._fork(None, environment, os.getcwd(), [control.fileno(), 2]))

    def run(
        self,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        folder: Path | str,
        files: Sequence[int],
    ) -> subprocess.Popen[bytes]:
        """Start a program, in place of a Python that would import everything again.

        Parameters
        ----------
        arguments : sequence of str
            What would follow the name of the interpreter: ``-m MODULE``, ``-c CODE`` or a file,
            and arguments.
        environment : mapping
            All variables of it.
        folder : Path or str
            Where it runs.
        files : sequence of int
            Descriptors of its stdin, stdout and stderr.
        """
        pid = self._fork(list(arguments), dict(environment), str(folder), list(files))
        return Forked(pid, " ".join(arguments))

    def take(self, ready: socket.socket, process: subprocess.Popen[bytes]) -> None:
        """Use a process that is loaded already."""
        self._socket, self._process = ready, process
        atexit.register(self.close)

    def _fork(
        self,
        arguments: list[str] | None,
        environment: dict[str, str],
        folder: str,
        files: list[int],
    ) -> int:
        body = pickle.dumps((os.getpid(), folder, environment, arguments))
        with self._lock:
            if self._socket is None:
                self.take(*_load())
                assert self._socket is not None
            with _adopting():
                head = _LENGTH.pack(len(body))
                socket.send_fds(self._socket, [head], files)
                self._socket.sendall(body)
                (pid,) = _PID.unpack(_exactly(self._socket, _PID.size))
        return pid

    def close(self) -> None:
        """End the loaded process."""
        if self._socket is not None and self._process is not None:
            self._socket.close()
            self._process.wait()


def install() -> None:
    """Have all servers of this process use forked fork servers."""
    if sys.platform == "linux":
        fork_client.start_forkserver = LOADED.start


def _load() -> tuple[socket.socket, subprocess.Popen[bytes]]:
    secret, more = fork_client._SECRETS, fork_client._ENVIRONMENT
    environment = {k: v for k, v in os.environ.items() if k not in secret} | more
    ours, theirs = socket.socketpair()
    with theirs:
        process = subprocess.Popen(
            (sys.executable, "-m", "tests.server.forkservers", str(theirs.fileno())),
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
    """Load what fork servers and programs load, and fork one for each request."""
    preload.warm_up()
    preload.load_the_rest()
    for module in ("motionlab.cli", "motionlab.server.app", "motionlab.server.serve"):
        importlib.import_module(module)
    gc.collect()
    gc.freeze()
    _serve(requests)


def _serve(requests: socket.socket) -> None:
    """Fork what is requested; return in the process of a program once that has ended."""
    while True:
        head, files, _, _ = socket.recv_fds(requests, _LENGTH.size, 3)
        if not head:
            return
        (size,) = _LENGTH.unpack(head)
        parent, folder, environment, arguments = pickle.loads(_exactly(requests, size))
        read, write = os.pipe()
        between = os.fork()
        if between == 0:  # ends at once, so that the server's process adopts the fork server
            pid = os.fork()
            if pid == 0:
                os.close(read)
                os.close(write)
                requests.close()
                if arguments is None:
                    _be_fork_server(parent, folder, environment, *files)
                _be_program(parent, folder, environment, files, arguments)
                return
            os.write(write, _PID.pack(pid))
            os._exit(0)
        os.waitpid(between, 0)
        requests.sendall(os.read(read, _PID.size))
        os.close(read)
        os.close(write)
        for file in files:
            os.close(file)


def _adopted(parent: int) -> bool:
    """Wait until this process has its parent, unless that has been killed meanwhile."""
    end = time.monotonic() + _ADOPTION
    while os.getppid() != parent:
        if time.monotonic() > end:
            return False
        time.sleep(0.001)
    return True


def _be_fork_server(
    parent: int, folder: str, environment: dict[str, str], control: int, stderr: int
) -> NoReturn:
    code = 1
    try:
        if not _adopted(parent):
            os._exit(code)
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


def _be_program(
    parent: int, folder: str, environment: dict[str, str], files: list[int], arguments: list[str]
) -> None:
    """Do what an interpreter with these arguments does; its exceptions and exits are not caught."""
    if not _adopted(parent):
        os._exit(1)
    for descriptor, file in enumerate(files):
        os.dup2(file, descriptor)
        os.close(file)
    _open_streams()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    kind, *rest = arguments
    if kind == "-c" or "serve" in rest:
        _be_loaded()
    if kind == "-m":
        sys.argv[:] = rest
        sys.path.insert(0, folder)
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif kind == "-c":
        sys.argv[:] = ["-c", *rest[1:]]
        sys.path.insert(0, "")
        exec(rest[0], {"__name__": "__main__"})
    else:
        sys.argv[:] = arguments
        sys.path.insert(0, str(Path(kind).resolve().parent))
        runpy.run_path(kind, run_name="__main__")


def _open_streams() -> None:
    """Open stdin, stdout and stderr: what Python has opened at its start was another file."""
    sys.stdin = open(0, encoding="utf-8", closefd=False)
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = open(
        2, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False
    )


def _be_loaded() -> None:
    """Fork a loaded process for the fork servers of this program, while it has one thread."""
    ours, theirs = socket.socketpair()
    pid = os.fork()
    if pid == 0:
        ours.close()
        os.setsid()
        _serve(theirs)
        os._exit(0)
    theirs.close()
    LOADED.take(ours, Forked(pid, "a loaded process"))
    install()


LOADED = Loaded()

if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
