"""Programs for shells of tests that take no second to start: each is forked, with all imported.

What is run are ``python`` and ``motionlab`` of a folder ``bin``. They hand their arguments, their
folder, their variables and their files to a thread of this process, and end as their forks do.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

from tests.server.forkservers import LOADED

_LENGTH = struct.Struct("<I")
_FAILED = 70

_PROGRAM = """\
#!{python} -IS
import json, os, socket, struct, sys
asked = json.dumps([{first!r} + sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
with socket.socket(socket.AF_UNIX) as to:
    to.connect({address!r})
    socket.send_fds(to, [struct.pack("<I", len(asked))], [0, 1, 2])
    to.sendall(asked)
    code = to.recv(1)
sys.exit(code[0] if code else {failed})
"""


@contextlib.contextmanager
def programs(folder: Path) -> Iterator[Path]:
    """Yield a folder that has ``bin/python`` and ``bin/motionlab`` until the block ends."""
    (folder / "bin").mkdir()
    address = folder / "socket"
    for name, first in {"python": [], "motionlab": ["-m", "motionlab"]}.items():
        program = folder / "bin" / name
        program.write_text(
            _PROGRAM.format(
                python=sys.executable, first=first, address=str(address), failed=_FAILED
            )
        )
        program.chmod(0o755)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(address))
        listener.listen()
        thread = threading.Thread(target=_accept, args=(listener,))
        thread.start()
        try:
            yield folder
        finally:
            listener.shutdown(socket.SHUT_RDWR)
            thread.join()


def _accept(listener: socket.socket) -> None:
    while True:
        try:
            connection, _ = listener.accept()
        except OSError:  # the end
            return
        threading.Thread(target=_run, args=(connection,)).start()


def _run(connection: socket.socket) -> None:
    with connection, connection.makefile("rb") as file:
        head, files, _, _ = socket.recv_fds(connection, _LENGTH.size, 3)
        arguments, folder, environment = json.loads(file.read(*_LENGTH.unpack(head)))
        try:
            process = LOADED.run(arguments, environment, folder, files)
        finally:
            for each in files:
                os.close(each)
        connection.sendall(bytes([_code(process)]))


def _code(process: subprocess.Popen[bytes]) -> int:
    """Return what a shell has for the end of a process."""
    code = process.wait()
    return code if code >= 0 else 128 - code
