"""What a live session has measured and with what: metrics, telemetry and scenario as files."""

from __future__ import annotations

import pathlib
import tempfile
from typing import Annotated, Literal

import tomli_w
from fastapi import APIRouter, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse

from motionlab.service.bodies import JsonRoute
from motionlab.service.documents import SessionMetrics
from motionlab.service.problems import responses
from motionlab.service.routes.sessions import Found
from motionlab.service.slots import free_slot
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)
_TELEMETRY = {"csv": "text/csv", "parquet": "application/vnd.apache.parquet"}


@router.get(
    "/{session_id}/metrics",
    operation_id="getMetrics",
    response_model=SessionMetrics,
    responses=responses(404),
)
async def get_metrics(session: Found) -> Response:
    """Return metrics over the last two periods, or ten seconds."""
    return JSONResponse(await session.metrics())


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
        **responses(404, 422, 429),
    },
)
async def get_telemetry(
    request: Request,
    session: Found,
    format: Annotated[Literal["csv", "parquet"], Query()] = "parquet",
) -> Response:
    """Return what the ring holds, 30 s at most, as a file."""
    slot = free_slot(request)  # a file takes a few times what the ring holds
    recording = session.recording()
    about = metadata(session.prepared)

    def written() -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / f"telemetry.{format}"
            recorder.write(recording, str(path), metadata=about)
            return path.read_bytes()

    name = f"{session.prepared.scenario.name}-{session.tick}.{format}"
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    async with slot:
        content = await run_in_threadpool(written)
    return Response(content, media_type=_TELEMETRY[format], headers=headers)


@router.get(
    "/{session_id}/scenario.toml",
    operation_id="getScenarioFile",
    response_class=Response,
    responses={
        200: {
            "description": "The scenario; docs/scenarios.md",
            "content": {"application/toml": {"schema": {"type": "string"}}},
        },
        **responses(404),
    },
)
async def get_scenario_file(session: Found) -> Response:
    """Return the scenario in effect as a TOML file that ``motionlab run`` takes."""
    scenario = session.simulation.scenario
    text = tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True))
    headers = {"Content-Disposition": f'attachment; filename="{scenario.name}.toml"'}
    return Response(text, media_type="application/toml", headers=headers)
