"""The kernels of batches, compiled by a process of their own when the first server starts.

Compiling them takes many seconds and holds the interpreter's lock: done in the server it would
stop every session. The process leaves what it has compiled in the cache, where the server finds it.
"""

from __future__ import annotations

import subprocess
import sys

from motionlab.simulation.precompile import batches_compiled

COMMAND = (sys.executable, "-m", "motionlab.simulation.precompile")


class Kernels:
    """The process that compiles, while there is one; with NUMBA_DISABLE_JIT there is none."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._settled = batches_compiled()

    def start(self) -> None:
        """Start compiling, unless that was done before."""
        if not self._settled:
            nothing = subprocess.DEVNULL
            self._process = subprocess.Popen(COMMAND, stdin=nothing, stdout=nothing)

    @property
    def settled(self) -> bool:
        """Whether they are compiled, or compiling them has failed: their user then reports that."""
        ended = self._process is not None and self._process.poll() is not None
        self._settled = self._settled or ended or batches_compiled()
        return self._settled

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
