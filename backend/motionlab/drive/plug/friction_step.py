"""Step of commissioning: friction, identified from a recorded run of slow motions."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Coroutine
from typing import Any, TypeVar

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.field import SCENARIO, VARIANT
from motionlab.drive.commissioning.hold import low_gain_changes
from motionlab.drive.commissioning.record import Finding, FoundFigure
from motionlab.drive.commissioning.run import StepRun, Stopped
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.plug.drives import Drives
from motionlab.drive.plug.session import create_session
from motionlab.errors import Busy
from motionlab.library.library import library
from motionlab.server.live.sessions import Sessions
from motionlab.server.routes.studies import answer
from motionlab.server.worker_answers import json_of
from motionlab.server.workers.pool import Workers
from motionlab.simulation.prepare import prepare
from motionlab.studies.identify.documents import (
    AxisIdentification,
    IdentificationDocument,
    Parameter,
)

T = TypeVar("T")

SPEEDS = (0.001, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08)
"""Of each axis, m/s."""

DISTANCES = (0.003, 0.005, 0.008, 0.012, 0.02, 0.03, 0.03)
"""Of each axis at each speed, there and back, m."""

_ACCELERATION, _DWELL = 0.4, 0.2  # m/s^2, s
_POLL = 0.1  # s
_IDENTIFYING = 300.0  # s
_WRITTEN = 30.0  # s, for a run to be complete
_DIFFERS = 0.1


class FrictionStep:
    """The step, for a server that records runs."""

    def __init__(self, drives: Drives, sessions: Sessions, workers: Workers) -> None:
        self._drives = drives
        self._sessions = sessions
        self._workers = workers
        self._loop = asyncio.get_running_loop()

    def __call__(self, run: StepRun) -> Finding:
        """Move slowly, record, identify; called in a thread.

        Raises
        ------
        Stopped
            If it was ended before.
        """
        with run.part(0.0, 0.02, "low gains"):
            scenario = slow_motions(run)
            parameters = held_parameters(scenario)
        with run.holding(parameters):
            with run.part(0.02, 0.8, "slow motions of both axes, recorded"):
                identifier = self._recorded(run, scenario)
        with run.part(0.8, 1.0, f"identification from {identifier}"):
            document = self._identified(run, identifier)
        return finding_of(document, identifier)

    def _recorded(self, run: StepRun, scenario: Scenario) -> str:
        """Return the run of a motion of armed drives."""
        session = self._do(create_session(self._sessions, self._drives, lambda: prepare(scenario)))
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

    def _identified(self, run: StepRun, identifier: str) -> IdentificationDocument:
        """Return what a worker identifies from a run, once that is complete."""
        until = time.monotonic() + _WRITTEN
        while True:
            try:
                library().complete(identifier)
                break
            except Busy:
                if time.monotonic() > until:
                    raise
                time.sleep(_POLL)
        body = {"run": identifier, "axis": "both"}
        called = self._do(
            self._workers.run(json_of, answer, ("identify", body), seconds=_IDENTIFYING)
        )
        try:
            run.check()
            assert called.contents is not None
            return IdentificationDocument.model_validate_json(called.contents.read())
        finally:
            called.close()

    def _do(self, work: Coroutine[Any, Any, T]) -> T:
        """Do something of the event loop."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()


def slow_motions(run: StepRun) -> Scenario:
    """Return both axes moving there and back at constant speeds, with low gains."""
    start = {
        axis: (config.position_min + config.position_max) / 2
        for axis in AXES
        for config in (getattr(run.config, axis),)
    }
    room = min(
        0.4 * (config.position_max - config.position_min)
        for config in (getattr(run.config, axis) for axis in AXES)
    )
    parts = [
        {
            "kind": "trapezoid",
            "start": start,
            "end": {axis: start[axis] + min(distance, room) for axis in AXES},
            "v_max": 2**0.5 * speed,  # along the diagonal: each axis has its share
            "a_max": 2**0.5 * _ACCELERATION,
            "dwell": _DWELL,
        }
        for speed, distance in zip(SPEEDS, DISTANCES, strict=True)
    ]
    changes = low_gain_changes() | {
        "name": "commissioning",
        "trajectory": {"kind": "sequence", "parts": parts},
    }
    return on_drives(load_scenario(SCENARIO, changes), VARIANT)


def finding_of(document: IdentificationDocument, run: str) -> Finding:
    """Return what was identified beside the model of the controllers."""
    rows, different = [], []
    for axis in AXES:
        identified = document.axes.get(axis)
        if identified is None:
            rows.append(FoundFigure(name=axis, found="nothing", expected="", holds=False))
            continue
        for name, parameter in _parameters(identified):
            rows.append(_row(f"{axis} {name}", parameter))
            believed = parameter.believed
            if believed and abs(parameter.value - believed) > _DIFFERS * believed:
                different.append(f"{axis} {name}")
    unknown = [row.name for row in rows if not row.holds]
    text = f"identified from {run}"
    if unknown:
        text = f"not determined by {run}: {', '.join(unknown)}"
    elif different:
        text += f"; other than in the model of {SCENARIO} by more than 10 %: {', '.join(different)}"
    return Finding(at=time.time(), holds=not unknown, text=text, rows=rows, run=run)


def _parameters(identified: AxisIdentification) -> list[tuple[str, Parameter]]:
    return [
        (name, identified.sliding.parameters[name]) for name in ("F_c", "F_s", "v_s", "sigma_2")
    ]


def _row(name: str, parameter: Parameter) -> FoundFigure:
    known = parameter.low is not None and parameter.high is not None
    span = f"{parameter.low:.4g} to {parameter.high:.4g}" if known else "not determined"
    believed = "" if parameter.believed is None else f"{parameter.believed:.4g} {parameter.unit}"
    return FoundFigure(
        name=name,
        found=f"{parameter.value:.4g} {parameter.unit} ({span})",
        expected=believed,
        holds=known,
    )
