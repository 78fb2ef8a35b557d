"""A process that stands by to try a changed law at once, with everything but the law imported.

It forks for each trial: the law runs in a process that may loop or end without harm.
"""

from __future__ import annotations

import contextlib
import faulthandler
import functools
import importlib
import json
import os
import resource
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from motionlab.own_files import ACCEPTED
from motionlab.own_laws.check import MEMORY, Checked, as_json, from_json, no_answer

SECONDS = 10.0
"""Time that a trial may take, s; a compilation takes less than one where nothing else runs."""


class Standby:
    """Tries changed laws one after the other; begins a process where there is none."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Begin the process, so that it is ready when a law changes."""
        with self._lock:
            self._begun()

    def try_version(self, name: str, path: Path, text: str) -> Checked:
        """Try a version of the file of a law that runs, or of a new law: no name, by its text."""
        with self._lock:
            process = self._begun()
            accepted = os.environ.get(ACCEPTED, "{}")
            assert process.stdin is not None and process.stdout is not None
            try:
                process.stdin.write(json.dumps([name, str(path), text, accepted]).encode() + b"\n")
                process.stdin.flush()
                ready, _, _ = select.select([process.stdout], [], [], 2 * SECONDS + 60.0)
                line = process.stdout.readline() if ready else b""
                return from_json(line)
            except (OSError, ValueError):
                self._end()
                return no_answer(path, SECONDS, "")

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._end()

    def _begun(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self._process = subprocess.Popen(
                [sys.executable, "-m", __spec__.name],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        return self._process

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    with contextlib.suppress(OSError):
                        pipe.close()
            self._process = None


# -- in the process -------------------------------------------------------------------------------


def _main() -> None:
    # Not above: `Standby` is for processes that need none of it.
    trial: Any = importlib.import_module("motionlab.own_laws.trial")
    stdout = os.dup(1)
    os.dup2(2, 1)  # what a file prints is no answer
    trial.problem_of("off")  # loads the kernel
    for line in sys.stdin:
        name, path, text, os.environ[ACCEPTED] = json.loads(line)
        answer = _forked(functools.partial(trial.try_version, name, text, Path(path)), Path(path))
        with open(stdout, "wb", closefd=False) as answers:
            answers.write(answer + b"\n")


def _forked(trial: Callable[[], Checked], path: Path) -> bytes:
    """Return the answer of a trial in a forked process, or why there is none."""
    (read, write), (read_errors, write_errors) = os.pipe(), os.pipe()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.dup2(write_errors, 2)
            resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
            faulthandler.dump_traceback_later(SECONDS, exit=True)
            os.write(write, as_json(trial()).encode())
            code = 0
        finally:
            os._exit(code)
    os.close(write)
    os.close(write_errors)
    with open(read, "rb") as answers, open(read_errors, "rb") as errors:
        ready, _, _ = select.select([answers], [], [], 2 * SECONDS)
        if not ready:  # in compiled code, which no traceback ends
            os.kill(child, signal.SIGKILL)
        answer, text = answers.read(), errors.read()
    os.waitpid(child, 0)
    return answer or as_json(no_answer(path, SECONDS, text.decode("utf-8", "replace"))).encode()


if __name__ == "__main__":
    _main()
