"""A virtual drive in a process of its own, for tests and demonstrations."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from types import TracebackType
from typing import Any

from motionlab.drive.virtual.control import DriveFailed, ask

_END_TIME = 10.0  # s


class VirtualDrive:
    """A virtual drive that runs in a child process while a block lasts.

    It answers once the block begins: compiled code it does not find it compiles first. Its settings
    are the options of ``motionlab vdrive``; port 0 takes a free one, as `port` and `control_port`
    have it then.
    """

    def __init__(  # noqa: PLR0913 - the options of the command
        self,
        motor: str = "nominal",
        *,
        address: str = "127.0.0.1",
        port: int = 0,
        start: tuple[float, float] = (0.0, 0.0),
        seed: int = 0,
        drift: float = 0.0,
        priority: int = 0,
        slow: int = 1,
        interface: str = "",
        options: Sequence[str] = (),
    ) -> None:
        self.address = address
        self.port = port
        self.control_port = 0
        self.pid = 0
        self._command = [
            sys.executable,
            "-m",
            "motionlab",
            "vdrive",
            "--json",
            "--until-eof",
            f"--motor={motor}",
            f"--start={start[0]!r},{start[1]!r}",
            f"--seed={seed}",
            f"--drift={drift * 1e6!r}",  # ppm
            f"--priority={priority}",
            f"--slow={slow}",
            *options,
            *(
                [f"--interface={interface}", "--control=0"]
                if interface
                else [f"--address={address}:{port}"]
            ),
        ]
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> VirtualDrive:
        """Start it and wait until it answers.

        Raises
        ------
        DriveFailed
            If it ends instead.
        """
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(self._command, stdin=pipe, stdout=pipe)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            self._close()
            raise DriveFailed(f"the virtual drive ended with exit code {code}")
        ports = json.loads(line)
        self.port, self.control_port = ports["port"], ports["control_port"]
        self.pid = self._process.pid
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End it."""
        self._close()

    def switch(self, **changes: Any) -> dict[str, Any]:
        """Set fault switches; return what `status` returns.

        Raises
        ------
        ConfigError
            If a switch has another name or range.
        """
        return ask(self.control_port, changes)

    def status(self) -> dict[str, Any]:
        """Return switches in effect, counters, and the state of every node."""
        return ask(self.control_port, {})

    def _close(self) -> None:
        if self._process is None:
            return
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()  # at its end the process ends
        try:
            self._process.wait(_END_TIME)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._process = None
