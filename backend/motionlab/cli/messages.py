"""What commands print: no control characters, and no failure of stderr ends a command."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

from motionlab.executors.progress import shows_progress
from motionlab.reports.plain_text import PlainStream
from motionlab.reports.tables import on_terminal


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
    messages = PlainStream(_Messages(stream), styled=False)
    with contextlib.redirect_stderr(messages):
        try:
            yield
        finally:
            messages.flush()  # here, not at exit, where a failure would set the exit code


@contextlib.contextmanager
def plain_stdout() -> Iterator[None]:
    """Keep control characters of files, servers and other people off the terminal."""
    if sys.stdout is None:
        yield
        return
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # no letter stops a result
    with contextlib.redirect_stdout(PlainStream(sys.stdout, styled=on_terminal())):
        yield


def say(text: str) -> None:
    """Print a note on stderr, unless ``--quiet`` is given."""
    if shows_progress():
        for line in text.splitlines():
            print(f"motionlab: {line}", file=sys.stderr)


def discard(stream: TextIO) -> None:
    """Discard output of a stream, also what is still buffered."""
    with contextlib.suppress(OSError):  # a stream without a descriptor has nothing to break
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
