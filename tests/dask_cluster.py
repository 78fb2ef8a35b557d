"""A Dask scheduler with workers on loopback, each a process."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from tests.paths import ROOT

CLOSED = ("--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0")
"""Options that keep scheduler and workers on loopback."""
_PATIENCE = 60.0  # s
_IDLE = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
"""Without it a worker looks a hundred times a second at what it does."""


class Lab(NamedTuple):
    """What runs: its address and the processes of scheduler and workers."""

    address: str
    scheduler: subprocess.Popen[str]
    workers: list[subprocess.Popen[str]]


@contextmanager
def cluster(
    workers: int = 2, *options: str, folder: Path, protocol: tuple[str, ...] = ()
) -> Iterator[Lab]:
    """Run a scheduler and single-threaded workers until the block ends.

    Parameters
    ----------
    workers : int
        How many.
    *options : str
        Further ones of the workers.
    folder : Path
        Where workers keep their files.
    protocol : tuple of str
        Options of both, such as ``--protocol tls``.
    """
    began: list[subprocess.Popen[str]] = []

    def start(command: str, *options: str, ready: str) -> str:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{command}", *CLOSED, *options],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(ROOT)} | _IDLE,
        )
        began.append(process)
        assert process.stderr is not None
        said = []
        for line in process.stderr:
            said.append(line)
            if found := re.search(ready, line):
                return found[0]
        raise AssertionError("".join(said))

    try:
        address = start(
            "scheduler", *protocol, "--port", "0", ready=r"t(?:cp|ls)://127\.0\.0\.1:\d+"
        )
        for number in range(workers):
            place = ("--local-directory", str(folder / f"{number}"))
            alone = ("--no-nanny", "--nthreads", "1", "--no-dashboard")
            start(
                "worker",
                address,
                *place,
                *alone,
                *options,
                ready="Starting established|Registered to",
            )
        yield Lab(address, began[0], began[1:])
    finally:
        for process in reversed(began):
            process.kill()
            process.communicate(timeout=_PATIENCE)
