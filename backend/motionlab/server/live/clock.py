"""The thread that advances every playing session, sixty times a second."""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections import deque
from typing import Protocol

FRAME_SECONDS = 1.0 / 60.0
"""Time between two frames of a stream, s."""

_REST_SECONDS = 0.001
"""Least pause between two rounds, s: a machine that cannot keep up still answers."""

_LOG = logging.getLogger(__name__)


class Clocked(Protocol):
    """An object advanced by a clock."""

    @property
    def runs(self) -> bool:
        """Whether it is running."""
        ...

    def keep_up(self, now: float) -> None:
        """Advance to a time of the monotonic clock, s."""
        ...

    def publish(self) -> None:
        """Send what is new; runs on the event loop."""
        ...


class Clock:
    """Advances sessions in a thread of its own and publishes from the event loop.

    The kernel releases the interpreter's lock, so the event loop answers while sessions advance.
    """

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._playing: dict[Clocked, None] = {}
        self._advanced: deque[Clocked] = deque()
        self._called = False
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="clock", daemon=True)
        self._thread.start()

    def start(self, session: Clocked) -> None:
        """Advance a session from now on."""
        with self._changed:
            self._playing[session] = None
            self._changed.notify()

    def stop(self, session: Clocked) -> None:
        """Stop advancing a session; a slice that has begun is finished."""
        with self._changed:
            self._playing.pop(session, None)

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._closed = True
            self._playing.clear()
            self._changed.notify()

    def _run(self) -> None:
        due = time.monotonic()
        while playing := self._wait_for_sessions():
            for session in playing:
                try:
                    session.keep_up(time.monotonic())
                except Exception:  # of this session alone: the others go on
                    _LOG.exception("a session cannot be advanced and is no longer played")
                    self.stop(session)
                    continue
                self._drop_if_ended(session)
                self._advanced.append(session)
                self._call_loop()
            now = time.monotonic()
            due = max(due + FRAME_SECONDS, now + _REST_SECONDS)
            time.sleep(due - now)

    def _wait_for_sessions(self) -> list[Clocked]:
        """Return the playing sessions as soon as there are any; none when the clock is closed."""
        with self._changed:
            while not self._playing and not self._closed:
                self._changed.wait()
            return list(self._playing)

    def _drop_if_ended(self, session: Clocked) -> None:
        with self._changed:  # it may have been started anew since
            if not session.runs:
                self._playing.pop(session, None)

    def _call_loop(self) -> None:
        if self._called or self._closed:
            return
        self._called = True
        try:
            self._loop.call_soon_threadsafe(self._publish)
        except RuntimeError:  # the loop has ended
            self._closed = True

    def _publish(self) -> None:
        self._called = False
        sessions: dict[Clocked, None] = {}
        while self._advanced:
            sessions[self._advanced.popleft()] = None
        for session in sessions:
            try:
                session.publish()
            except Exception:  # of this session alone
                _LOG.exception("what is new of a session cannot be sent")
