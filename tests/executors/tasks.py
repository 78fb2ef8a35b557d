"""Tasks for executors, in a module that a worker imports in no time."""

from __future__ import annotations

import time

from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import Progress


def slow(number: int, progress: Progress) -> int:
    """Return a square after a while."""
    for step in range(10):
        progress(step / 10)
        time.sleep(0.03)
    return number * number


def broken(number: int, progress: Progress) -> int:
    """Fail for every other task, the later the sooner."""
    time.sleep(0.05 * (4 - number))
    if number % 2:
        raise ConfigError(FieldError(f"task {number}", "is odd", number, "even"))
    return number
