"""Files of a live session: metrics, telemetry, scenario."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tomli_w
from fastapi import APIRouter, HTTPException, Query, Request, Response

from motionlab.service.http.download import Download, temporary_folder
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.live.document import SessionMetrics
from motionlab.service.live.history import as_recording
from motionlab.service.memory_budget import MemoryBudget
from motionlab.service.routes.sessions import FoundSession
from motionlab.service.worker_answers import called
from motionlab.service.workers.worker import Call
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)
_RETRY_SECONDS = 5
_WAIT_SECONDS = 60.0
_WRITE_SECONDS = 120.0
_SAMPLES = "samples.npy"
_FILE_SHARE = {"csv": 4, "parquet": 3}
"""Memory for writing a file, in sizes of the ring: a copy of it, a row group, and the file. The
temporary folder may lie in memory.
"""

_TELEMETRY = {"csv": "text/csv", "parquet": "application/vnd.apache.parquet"}


@router.get(
    "/{session_id}/metrics",
    operation_id="getMetrics",
    response_model=SessionMetrics,
    responses=responses(404),
)
async def get_metrics(session: FoundSession) -> Response:
    """Return metrics over the last two periods, or ten seconds; they end where a stop began."""
    return Response(await session.metrics(), media_type="application/json")


@router.get(
    "/{session_id}/telemetry",
    operation_id="getTelemetry",
    response_class=Response,
    responses={
        200: {
            "description": "A row for each tick, a column for each channel; docs/recording.md",
            "content": {
                "text/csv": {"schema": {"type": "string"}},
                "application/vnd.apache.parquet": {
                    "schema": {"type": "string", "format": "binary"}
                },
            },
        },
        **responses(404, 422, 429, 503, 507),
    },
)
async def get_telemetry(
    request: Request,
    session: FoundSession,
    format: Annotated[Literal["csv", "parquet"], Query()] = "parquet",
) -> Response:
    """Return the contents of the ring, 30 s at most, as a file."""
    state = request.app.state
    memory: MemoryBudget = state.memory
    slots: asyncio.Semaphore = state.downloads
    if slots.locked() and state.downloads_waiting >= state.settings.downloads_waiting_max:
        raise _too_many(f"{state.downloads_waiting} files are waited for already")
    state.downloads_waiting += 1
    try:
        async with asyncio.timeout(_WAIT_SECONDS):
            await slots.acquire()
    except TimeoutError:
        most = state.settings.downloads_max
        raise _too_many(f"{most} files are being sent, and none has ended since") from None
    finally:
        state.downloads_waiting -= 1
    about = metadata(session.prepared)
    name = f"{session.prepared.scenario.name}-{session.tick}.{format}"
    async with contextlib.AsyncExitStack() as held:
        held.callback(slots.release)
        held.enter_context(memory.hold(_FILE_SHARE[format] * session.history.ring.size))
        with temporary_folder() as folder:
            async with state.writing:
                start, failed = await session.save(folder / _SAMPLES)
                written = folder / f"telemetry.{format}"
                arguments = (str(written), start, failed, about)
                (await called(request, _write, *arguments, seconds=_WRITE_SECONDS)).close()
            file = written.open("rb")
        return Download(
            file,
            media_type=_TELEMETRY[format],
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
            held=held.pop_all(),
        )


def _too_many(detail: str) -> HTTPException:
    return HTTPException(429, detail, {"Retry-After": f"{_RETRY_SECONDS}"})


def _write(
    _: Call, path: str, start: int, failed: dict[str, int | None], about: dict[str, str]
) -> None:
    """Write a file of the samples in its folder; runs in a worker."""
    data = np.load(Path(path).parent / _SAMPLES, mmap_mode="r")
    recorder.write(as_recording(start, data, failed), path, metadata=about)


@router.get(
    "/{session_id}/scenario.toml",
    operation_id="getScenarioFile",
    response_class=Response,
    responses={
        200: {
            "description": "The scenario; docs/scenarios.md",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        },
        **responses(404),
    },
)
async def get_scenario_file(session: FoundSession) -> Response:
    """Return the scenario in effect as a TOML file that ``motionlab run`` takes."""
    scenario = session.simulation.scenario
    text = tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
    headers = {"Content-Disposition": f'attachment; filename="{scenario.name}.toml"'}
    return Response(text, media_type="text/plain; charset=utf-8", headers=headers)
