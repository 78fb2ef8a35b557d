"""Steps of commissioning that record a run and let a study read it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Coroutine
from typing import Any, TypeVar

from pydantic import BaseModel

from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.run import StepRun, Stopped
from motionlab.drive.plug.drives import Drives
from motionlab.drive.plug.session import create_session
from motionlab.errors import Busy
from motionlab.library.library import library
from motionlab.server.live.sessions import Sessions
from motionlab.server.routes.studies import answer
from motionlab.server.worker_answers import json_of
from motionlab.server.workers.pool import Workers
from motionlab.simulation.prepare import prepare

T = TypeVar("T")
Document = TypeVar("Document", bound=BaseModel)

_POLL = 0.1  # s
_STUDY = 300.0  # s
_WRITTEN = 30.0  # s, for a run to be complete


class RecordedStep:
    """A step, for a server that records runs; its methods are called in a thread."""

    def __init__(self, drives: Drives, sessions: Sessions, workers: Workers) -> None:
        self.drives = drives
        self._sessions = sessions
        self._workers = workers
        self._loop = asyncio.get_running_loop()

    def recorded(self, run: StepRun, scenario: Scenario) -> str:
        """Return the run of a motion of armed drives.

        Raises
        ------
        Stopped
            If it was ended before its end, or not recorded.
        """
        session = self._do(create_session(self._sessions, self.drives, lambda: prepare(scenario)))
        try:
            run.check()
            self._do(session.begin(run.stops))
            while session.state in {"playing", "stopping"}:
                run.report_part(session.tick / (session.status.ends or 1))
                time.sleep(_POLL)
            run.check()
            if session.state != "finished":
                raise Stopped("the torque was switched off")
            until = time.monotonic() + _WRITTEN
            while (identifier := session.status.run) is None:
                if time.monotonic() > until:
                    raise Stopped(f"the motion was not recorded: {session.status.unrecorded}")
                time.sleep(_POLL)
            return identifier
        finally:
            self._loop.call_soon_threadsafe(self._sessions.remove, session)

    def study(
        self, run: StepRun, kind: str, body: dict[str, Any], document: type[Document]
    ) -> Document:
        """Return what a worker finds in a run, which is named in `body`, once that is complete.

        Raises
        ------
        Stopped
            If the step was ended meanwhile.
        """
        until = time.monotonic() + _WRITTEN
        while True:
            try:
                library().complete(body["run"])
                break
            except Busy:
                if time.monotonic() > until:
                    raise
                time.sleep(_POLL)
        called = self._do(self._workers.run(json_of, answer, (kind, body), seconds=_STUDY))
        try:
            run.check()
            assert called.contents is not None
            return document.model_validate_json(called.contents.read())
        finally:
            called.close()

    def _do(self, work: Coroutine[Any, Any, T]) -> T:
        """Do something of the event loop."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()
