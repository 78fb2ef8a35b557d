"""Files of a live session: metrics, telemetry, scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import tomli_w
from fastapi import APIRouter, Query, Request, Response

from motionlab.exchange.selection import ALL, Selection
from motionlab.server.file_download import WRITE_SECONDS, file_download
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.live.document import SessionMetrics
from motionlab.server.routes.sessions import FoundSession
from motionlab.server.worker_answers import called
from motionlab.server.workers.worker import Call
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.expressions.columns import compile_columns, split_columns
from motionlab.telemetry.recording import Recording, as_recording
from motionlab.timing import CONTROL_PERIOD

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)
_SAMPLES = "samples.npy"
_WHOLE = "whole.parquet"
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
    columns: Annotated[
        str,
        Query(
            max_length=5000,
            description="Channels, name=expression, * for all channels, comma between; or all",
            examples=["A.x.following_error"],
        ),
    ] = "",
) -> Response:
    """Return the contents of the ring, 30 s at most, as a file."""
    about = metadata(session.prepared.scenario)
    names = tuple(split_columns(columns)) if columns else ()
    units = {name: each.unit for name, each in session.history.columns}
    compile_columns([name for name in names if name != ALL], units, CONTROL_PERIOD)

    async def write(path: Path) -> None:
        start, failed = await session.save(path.with_name(_SAMPLES))
        taken = (start, failed, session.history.states)
        arguments = (str(path), format, taken, about, names)
        (await called(request, _write, *arguments, seconds=WRITE_SECONDS)).close()

    return await file_download(
        request,
        write,
        name=f"{session.prepared.scenario.name}-{session.tick}.{format}",
        media_type=_TELEMETRY[format],
        size=_FILE_SHARE[format] * session.history.ring.size,
    )


def _write(
    _: Call,
    path: str,
    format: str,
    taken: tuple[int, dict[str, int | None], list[tuple[str, Channel]]],
    about: dict[str, str],
    columns: tuple[str, ...],
) -> None:
    """Write a file of the samples in its folder; runs in a worker."""
    data = np.load(Path(path).parent / _SAMPLES, mmap_mode="r")
    written = Path(path).with_suffix(f".{format}")
    start, failed, states = taken
    recording = as_recording(start, data, failed, states=states)
    if columns:
        _write_columns(recording, written, about, columns)
    else:
        recorder.write(recording, str(written), metadata=about)
    written.rename(path)


def _write_columns(
    recording: Recording, path: Path, about: dict[str, str], columns: tuple[str, ...]
) -> None:
    from motionlab.exchange.exports import (  # noqa: PLC0415 - a server starts without it
        Source,
        check_selection,
        export,
    )

    whole = path.with_name(_WHOLE)
    recorder.write(recording, str(whole), metadata=about)
    source = Source.of_file(whole)
    with source.file:
        selection = check_selection(source, Selection(columns))
        export(source, selection, path, path.suffix[1:])


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
