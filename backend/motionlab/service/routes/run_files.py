"""Runs as files: exported to the formats of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, Field

from motionlab.errors import ConfigError, FieldError
from motionlab.runs.library import library
from motionlab.runs.selection import FORMATS, Selection
from motionlab.service.file_download import WRITE_SECONDS, file_download
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.routes.runs import RunId
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import called
from motionlab.service.workers.worker import Call

router = APIRouter(prefix="/runs", tags=["runs"], route_class=JsonRoute)


class ExportQuery(BaseModel):
    """Which part of a run is wanted, and how."""

    format: Literal["csv", "parquet", "mat", "mcap"] = Field(
        default="parquet", description="docs/exchange.md describes each"
    )
    columns: str = Field(
        default="",
        max_length=5_000,
        description="Names of channels, comma between them; or all",
        examples=["A.x.following_error,x.position_reference"],
    )
    start: int = Field(default=0, alias="from", ge=0, description="First sample", examples=[0])
    stop: int | None = Field(
        default=None, alias="to", ge=1, description="Sample after the last", examples=[2000]
    )


@router.get(
    "/{run_id}/telemetry",
    operation_id="getRunTelemetry",
    response_class=Response,
    responses={
        200: {
            "description": "A row for each sample, a column for each channel; docs/exchange.md",
            "content": {
                "text/csv": {"schema": {"type": "string"}},
                **{
                    media: {"schema": {"type": "string", "format": "binary"}}
                    for media in FORMATS.values()
                    if media != "text/csv"
                },
            },
        },
        **responses(404, 409, 422, 429, 503, 507),
    },
)
async def get_run_telemetry(
    request: Request, run_id: RunId, wanted: Annotated[ExportQuery, Query()]
) -> Response:
    """Return telemetry of a run as a file."""
    settings: Settings = request.app.state.settings
    columns = tuple(wanted.columns.split(",")) if wanted.columns else ()
    selection = Selection(columns, wanted.start, wanted.stop)
    planned = await called(request, _plan, run_id, selection, wanted.format, light=True)
    selection, size = planned.value
    planned.close()
    if size > settings.memory_max:
        raise ConfigError(
            FieldError(
                "columns",
                "is too much for one download: choose fewer columns or a shorter range, or use "
                "motionlab export",
                size,
                unit="bytes",
                bounds={"maximum": settings.memory_max},
            )
        )

    async def write(path: Path) -> None:
        arguments = (run_id, selection, str(path), wanted.format)
        (await called(request, _write, *arguments, seconds=WRITE_SECONDS)).close()

    return await file_download(
        request,
        write,
        name=f"{run_id}.{wanted.format}",
        media_type=FORMATS[wanted.format],
        size=size,
    )


def _plan(_: Call, run_id: str, selection: Selection, format: str) -> tuple[Selection, int]:
    from motionlab.runs.exports import Source, check_selection, size_of

    run = library().complete(run_id)
    with library().files.open(run_id) as file:
        checked = check_selection(Source.of(file, run), selection)
    return checked, size_of(checked, format)


def _write(call: Call, run_id: str, selection: Selection, path: str, format: str) -> None:
    from motionlab.runs.exports import Source, export, memory_of

    if format == "mat":  # written as a whole, the others by row groups
        call.hold(2 * memory_of(selection))
    run = library().complete(run_id)
    with library().files.open(run_id) as file:
        export(Source.of(file, run), selection, Path(path), format)
