"""Processes that have laws of one's own: a function of a test module, and a server."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx

from tests.library.served import PATIENCE, SERVE, address

_CALL = "import sys; from importlib import import_module; getattr(import_module({!r}), {!r})()"


def in_process(function: Callable[[], Any], laws: Path, **variables: str) -> None:
    """Call a function of a module, without arguments; what it raises is shown and fails."""
    environment = os.environ | {"MOTIONLAB_LAWS": str(laws)} | variables
    text = _CALL.format(function.__module__, function.__name__)
    line = [sys.executable, "-c", text]
    done = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@contextmanager
def serving(laws: Path, data: Path, *options: str, token: str = "") -> Iterator[httpx.Client]:
    """Yield a client of a server that has the laws of a folder; not forked: others have none."""
    told = data / "stderr.txt"
    environment = os.environ | {"MOTIONLAB_DATA": str(data), "MOTIONLAB_TOKEN": token}
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    with told.open("wb") as stderr:
        command = [sys.executable, *SERVE, "--laws", str(laws), *options]
        process = subprocess.Popen(command, env=environment, stderr=stderr)
    try:
        url = address(process, told)
        options_of: dict[str, Any] = {"timeout": PATIENCE, "headers": headers, "trust_env": False}
        with httpx.Client(base_url=url, **options_of) as client:
            yield client
    finally:
        process.terminate()
        process.wait(60)
