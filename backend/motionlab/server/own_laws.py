"""Files of laws of one's own while a server runs: a changed one is tried, then taken.

Each change is tried in another process, `motionlab.own_laws.standby`; if it can be taken, all
sessions have it from their next slice of time on. One that cannot leaves the former version.
"""

from __future__ import annotations

import asyncio
import logging
from pathlib import Path

from motionlab.declarations import DeclarationError
from motionlab.errors import FieldError
from motionlab.kernel.law_calls import renew_law
from motionlab.laws import FILES, SOURCES
from motionlab.library.run import Event
from motionlab.own_laws.accepted import accept
from motionlab.own_laws.standby import Standby
from motionlab.server.live.sessions import Sessions

_PERIOD = 0.1  # s between looks at the files
_LOG = logging.getLogger(__name__)

_Stamp = tuple[int, int]


class OwnLaws:
    """The laws of one's own of a server.

    Parameters
    ----------
    sessions : Sessions
        Whose controllers have them.
    """

    def __init__(self, sessions: Sessions) -> None:
        self.problems: dict[str, FieldError] = {}
        """Why the present version of a law's file is not the one that runs, by name."""
        self._sessions = sessions
        self._standby = Standby()
        # Those of installed packages are imported once.
        self._watched = {name: file.path for name, file in FILES.items() if not file.module}
        self._seen = {name: _stamp(path) for name, path in self._watched.items()}

    async def keep_watching(self) -> None:
        """Look at the files of laws until cancelled."""
        if not self._watched:
            return
        await asyncio.to_thread(self._standby.start)
        while True:
            await asyncio.sleep(_PERIOD)
            for name, path in self._watched.items():
                stamp = _stamp(path)
                if stamp is not None and stamp != self._seen[name]:
                    self._seen[name] = stamp
                    await self._take(name, path)

    async def _take(self, name: str, path: Path) -> None:
        before = SOURCES[name]
        try:
            problem = await asyncio.to_thread(self._try, name, path)
        except Exception as error:
            _LOG.exception("a law could not be tried")
            problem = FieldError(name, f"could not be tried: {error}", place=str(path))
        if problem is not None:
            self.problems[name] = problem
            _LOG.warning("law not taken: %s", problem)
            self._say(name, str(problem))
            return
        self.problems.pop(name, None)
        if SOURCES[name] != before:
            self._say(name, "")

    def _try(self, name: str, path: Path) -> FieldError | None:
        """Try a changed file, and take it where it can be taken; return why not."""
        try:
            text = FILES[name].text()
            if problems := self._standby.try_version(name, path, text).problems:
                return problems[0]
        except DeclarationError as error:
            return error.error
        former = SOURCES[name]
        accept(name, text)  # before whoever sees the new text asks for what it computes
        try:
            renew_law(name, text)
        except DeclarationError as error:
            accept(name, former)
            return error.error
        return None

    def _say(self, name: str, reason: str) -> None:
        """Note it in all sessions: one whose controllers lack the law may have it staged."""
        for session in self._sessions.all():
            session.law_changed(Event(tick=session.tick, kind="law", law=name, reason=reason))

    def close(self) -> None:
        """End the process that tries laws."""
        self._standby.close()


def _stamp(path: Path) -> _Stamp | None:
    try:
        status = path.stat()
    except OSError:
        return None  # between two versions, or gone: the one that runs stays
    return status.st_mtime_ns, status.st_size
