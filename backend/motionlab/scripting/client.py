"""A lab on a server: the same calls as here, and live sessions."""

from __future__ import annotations

import contextlib
import time
import urllib.parse
from pathlib import Path
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError, FieldError, MotionLabError
from motionlab.scripting.arguments import (
    Changes,
    Source,
    changes_of,
    present,
    readable,
    tables,
)
from motionlab.scripting.channels import Record
from motionlab.scripting.http_client import ADDRESS, LabServer, ServerRefused
from motionlab.scripting.kept import KeptRun
from motionlab.scripting.lab import Lab, shown_share
from motionlab.scripting.run import Run
from motionlab.scripting.session import Session, parquet_of
from motionlab.scripting.study_result import StudyResult
from motionlab.studies.table import BY_KIND

_PATIENCE = 130.0  # s; a server gives a call 120
_POLL, _POLL_MOST = 0.05, 1.0  # s between looks at a job


class Client(Lab):
    """A lab on a server.

    Parameters
    ----------
    url : str
        Its address.
    token : str, optional
        Its token; that of MOTIONLAB_TOKEN or MOTIONLAB_TOKEN_FILE when left out.

    Raises
    ------
    ServerRefused
        By every call: if the server does not answer, or refuses; the message says why.
    """

    def __init__(self, url: str = ADDRESS, token: str | None = None) -> None:
        self._server = LabServer(url, token, loc="url", timeout=_PATIENCE)

    def _run(self, scenario: Source, changes: dict[str, Any], *, keep: bool, name: str) -> Run:
        body = {"scenario": _sendable(scenario), "set": changes}
        document = self._answer("/simulate", body | {"keep": keep, "name": name}, "run")
        return Run(document, lambda: self._record(document.get("run"), body))

    def session(self, scenario: Source = "circle", set: Changes = None) -> Session:
        """Return a new live session, paused at its first tick; a ``with`` block ends it.

        Parameters
        ----------
        scenario, set
            As for `run`.
        """
        body = {"scenario": _sendable(scenario), "set": changes_of(set)}
        return Session(self._server, self._server.call("POST", "/sessions", body))

    def runs(self, **query: Any) -> list[dict[str, Any]]:
        """Return the kept runs, the newest first; `query` as of ``GET /runs`` (docs/runs.md)."""
        parameters = urllib.parse.urlencode(query)
        return self._server.call("GET", f"/runs?{parameters}")["runs"]

    def kept(self, run: str) -> KeptRun:
        """Return a kept run; a session's about a second after it has ended.

        Parameters
        ----------
        run : str
            Its identifier.
        """
        path = f"/runs/{urllib.parse.quote(run, safe='')}"
        return KeptRun(
            self._server.call("GET", path),
            lambda: parquet_of(self._server.fetch("GET", f"{path}/telemetry?format=parquet")),
        )

    def _study(
        self,
        kind: str,
        scenario: Source | None,
        set: Changes,
        scheduler: str | None,
        **request: Any,
    ) -> Any:
        if scheduler is not None:
            message = "belongs to the server: motionlab serve --scheduler"
            raise ConfigError(FieldError("scheduler", message, scheduler))
        study = BY_KIND[kind]
        if scenario is not None:
            request["scenario"] = _sendable(scenario)
        if scenario is not None or set is not None:
            request["set"] = changes_of(set)
        document = self._answer(study.path, tables(present(request), kind), kind)
        return StudyResult(study, study.document_model.model_validate(document))

    def _answer(self, path: str, body: dict[str, Any], title: str) -> dict[str, Any]:
        """Return what a call answers, at once or by a job; interrupted, the job is cancelled."""
        answer = self._server.call("POST", path, body)
        if not {"kind", "state", "progress"} <= set(answer):
            return answer
        job = f"/jobs/{answer['id']}"
        pause = _POLL
        try:
            with shown_share(title) as progress:
                while answer["state"] in ("queued", "running"):
                    time.sleep(pause)
                    pause = min(2.0 * pause, _POLL_MOST)
                    answer = self._server.call("GET", job)
                    progress(answer["progress"])
        except BaseException:
            with contextlib.suppress(MotionLabError):
                self._server.call("DELETE", job)
            raise
        if answer["state"] != "done":
            raise ServerRefused(f"{title} {answer['state']}: {answer['error']}")
        return answer["result"]

    def _record(self, run_id: str | None, body: dict[str, Any]) -> Record:
        """Return every channel of a run; one that is not kept is simulated again for that."""
        if run_id is not None:
            return self.kept(run_id).record
        again = self._answer("/simulate", body | {"keep": True}, "run")["run"]
        try:
            return self.kept(again).record
        finally:
            self._server.call("DELETE", f"/runs/{again}")


def _sendable(scenario: Source) -> str | dict[str, Any]:
    """Return a scenario as a request has it; a file is read here, its names are resolved."""
    source = readable(scenario)
    if isinstance(source, Path):
        return load_scenario(source).model_dump(mode="json")
    return source
