"""What workers are asked to do in tests."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from motionlab.errors import ConfigError, ExperimentFailed, FieldError, Infeasible, StoreFull
from motionlab.server.settings import Settings
from motionlab.server.workers.worker import Call

FIELD = FieldError("plant.x.mass", "is out of range", -1.0, ">= 0", "kg")
PLACE = {"time": 0.5, "place": (1.0, 2.0), "value": 3.0, "limit": (-1.0, 1.0)}


def identity(_: Call) -> int:
    """Return the process that carries the call out."""
    return os.getpid()


def environment(_: Call) -> list[str]:
    """Return the names of the variables that a worker sees."""
    return list(os.environ)


def priority(_: Call) -> int:
    """Return how nice it is."""
    return os.getpriority(os.PRIO_PROCESS, 0)


def text(_: Call, size: int) -> bytes:
    """Return so many bytes."""
    return bytes(range(256)) * (size // 256)


def hold(call: Call, size: int) -> bytes:
    """Hold memory for an answer."""
    call.hold(size)
    return b"held"


def hold_and_die(call: Call, size: int) -> None:
    """Hold memory and end without a word."""
    call.hold(size)
    os.kill(os.getpid(), signal.SIGKILL)


def sleep(_: Call, seconds: float) -> None:
    """Take time, deaf to everything."""
    time.sleep(seconds)


def work(call: Call, seconds: float) -> str:
    """Take time and report it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        call.progress(0.5)
        time.sleep(0.005)
    return "done"


def leave(_: Call) -> None:
    """End with a status."""
    os._exit(3)


def refuse(_: Call) -> None:
    """Raise what names a field."""
    raise ConfigError(FIELD)


def fail_to_follow(_: Call) -> None:
    """Raise what takes keywords only."""
    raise Infeasible(quantity="thrust", axis="x", unit="N", **PLACE)  # pyright: ignore


def fill(_: Call) -> None:
    """Raise a failure of the store."""
    raise StoreFull("no room")


def divide(_: Call) -> float:
    """Raise what nobody has foreseen."""
    return 1 / 0


def allocate(_: Call, size: int) -> int:
    """Take memory that was not asked for."""
    return len(np.ones(size, dtype=np.uint8))


def grow(_: Call, size: int) -> int:
    """Keep memory beyond the call."""
    KEPT.append(np.ones(size, dtype=np.uint8))
    return os.getpid()


KEPT: list[object] = []


# What jobs are asked to do: a call, the request, settings.


def job(call: Call, request: dict[str, Any], _: Settings) -> dict[str, Any]:
    """Report progress twice in a row, with a partial result, and return the request."""
    call.progress(0.1, Partial(said="nothing"))
    call.progress(0.5, Partial(said=request["say"]))
    return request


def job_fails(_: Call, request: dict[str, Any], __: Settings) -> None:
    """Raise what nobody has foreseen, or what is said."""
    if "say" in request:
        raise ExperimentFailed(request["say"])
    raise RuntimeError("something of /home/secret")


def job_takes_memory(_: Call, request: dict[str, Any], __: Settings) -> int:
    """Take memory that was not asked for."""
    return len(np.ones(request["bytes"], dtype=np.uint8))


def job_is_deaf(_: Call, request: dict[str, Any], __: Settings) -> None:
    """Tell its process, then hear nothing."""
    Path(request["file"]).write_text(f"{os.getpid()}", encoding="ascii")
    time.sleep(60.0)


def job_in_its_place(_: Call, __: dict[str, Any], ___: Settings) -> dict[str, Any]:
    """Return what it sees."""
    return {"names": list(os.environ), "nice": os.getpriority(os.PRIO_PROCESS, 0)}


class Partial(BaseModel):
    """What is there so far."""

    said: str
