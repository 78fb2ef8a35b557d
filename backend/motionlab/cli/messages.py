"""Messages on stderr, which may be closed, full or a broken pipe: that never ends a command."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

from motionlab.progress import is_told


class _Messages:
    """A stream that is discarded after a failed write."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        try:
            self._stream.write(text)
        except OSError:
            discard(self._stream)
        return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError:
            discard(self._stream)


@contextlib.contextmanager
def unbreakable_stderr() -> Iterator[None]:
    """Have failures of stderr ignored until the block ends."""
    closed = sys.stderr is None  # then print would write to stdout
    stream = open(os.devnull, "w", encoding="utf-8") if closed else sys.stderr
    messages = _Messages(stream)
    with contextlib.redirect_stderr(messages):
        try:
            yield
        finally:
            messages.flush()  # here, not at exit, where a failure would set the exit code


def say(text: str) -> None:
    """Print a note on stderr, unless ``--quiet`` is given."""
    if is_told():
        for line in text.splitlines():
            print(f"motionlab: {line}", file=sys.stderr)


def discard(stream: TextIO) -> None:
    """Discard output of a stream, also what is still buffered."""
    with contextlib.suppress(OSError):  # a stream without a descriptor has nothing to break
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
