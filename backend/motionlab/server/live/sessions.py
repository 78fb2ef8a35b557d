"""The sessions of a server: found by id, bounded in number, evicted when idle."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import TypeVar

from fastapi import HTTPException

from motionlab.server.live.clock import Clock
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session import Session
from motionlab.server.memory_budget import MemoryBudget
from motionlab.simulation.prepare import Prepared

IDLE_SECONDS = 1800.0
"""Time after which an idle session is evicted: no request, no viewer."""
SPARE_SECONDS = 60.0
"""The same, when its place is wanted."""
_EVICTION_PERIOD = 30.0
_THREADS = 2
"""Threads for the slow work of sessions; more would only compete for the interpreter's lock."""
S = TypeVar("S", bound=Session)


class Sessions:
    """All live sessions."""

    def __init__(
        self, *, most: int, memory: MemoryBudget, recorder: RunRecorder | None = None
    ) -> None:
        self._most = most
        self._memory = memory
        self._recorder = recorder
        self._sessions: dict[str, Session] = {}
        self._clock = Clock()
        self.threads = ThreadPoolExecutor(_THREADS, thread_name_prefix="session")

    async def create(self, prepare: Callable[[], Prepared]) -> Session:
        """Create a session, in the place of one long idle if need be, or answer 429.

        Raises
        ------
        ConfigError
            If it holds more than there is memory for at all.
        """
        return await self.add(lambda *parts: Session(prepare(), *parts))

    async def add(self, make: Callable[[Clock, Executor, RunRecorder | None], S]) -> S:
        """Create a session of any kind, as `create`; `make` is called in a thread."""
        session = await asyncio.get_running_loop().run_in_executor(
            self.threads, make, self._clock, self.threads, self._recorder
        )
        idlest = self._replaceable()
        self._memory.check(session.size)
        # No session is evicted unless the new session has its place and its memory.
        self._memory.take(session.size - (0 if idlest is None else idlest.size))
        if idlest is not None:
            del self._sessions[idlest.id]
            idlest.close()
        self._sessions[session.id] = session
        return session

    def _replaceable(self) -> Session | None:
        """Return the session whose place a new one takes, None if there is a free place, or 429."""
        if len(self._sessions) < self._most:
            return None
        now = time.monotonic()
        idlest = max(self.all(), key=lambda session: _idle(session, now))
        if _idle(idlest, now) <= SPARE_SECONDS:
            raise HTTPException(
                429,
                f"{self._most} sessions live already; delete one",
                {"Retry-After": f"{SPARE_SECONDS:.0f}"},
            )
        return idlest

    def find(self, session_id: str) -> Session:
        """Return a session, or answer 404."""
        session = self._sessions.get(session_id)
        if session is None:
            raise HTTPException(404, f"no session {session_id!r}")
        session.touched = time.monotonic()
        return session

    def all(self) -> list[Session]:
        """Return the sessions, oldest first."""
        return list(self._sessions.values())

    def remove(self, session: Session) -> None:
        """End a session."""
        if self._sessions.pop(session.id, None) is not None:
            self._memory.give_back(session.size)
        session.close()

    async def keep_evicting(self) -> None:
        """End idle sessions now and then; runs for ever."""
        while True:
            await asyncio.sleep(_EVICTION_PERIOD)
            self.expire(time.monotonic())

    def expire(self, now: float) -> None:
        """Evict idle sessions.

        Parameters
        ----------
        now : float
            Time of the monotonic clock, s.
        """
        for session in self.all():
            if _idle(session, now) > IDLE_SECONDS:
                self.remove(session)

    def close(self) -> None:
        """End every session."""
        for session in self.all():
            self.remove(session)
        self._clock.close()
        self.threads.shutdown(wait=False, cancel_futures=True)


def _idle(session: Session, now: float) -> float:
    """Return the time since a session's last request or viewer, s; none while it moves drives."""
    in_use = session.listeners or (session.drive and session.runs)
    return 0.0 if in_use else now - session.touched
