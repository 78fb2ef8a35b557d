"""Runs as files: exported to the formats of other tools, and measurements imported from them."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path
from typing import Annotated, Literal

from fastapi import APIRouter, HTTPException, Query, Request, Response
from pydantic import BaseModel, Field

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.column_guess import parse_mapping
from motionlab.exchange.measurements.document import RATE_MAX, VALUES_MAX, Import, ImportOptions
from motionlab.exchange.selection import FORMATS, Selection
from motionlab.library.library import library
from motionlab.library.run import LINE, NAME_MAX, RunDetail
from motionlab.server.file_download import WRITE_SECONDS, file_download
from motionlab.server.http.download import temporary_folder
from motionlab.server.http.openapi_input import links
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.routes.runs import RunId
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import called
from motionlab.server.workers.worker import Call
from motionlab.telemetry.expressions.columns import split_columns

router = APIRouter(prefix="/runs", tags=["runs"], route_class=JsonRoute)

_IMPORT_SECONDS = 120.0
_WRITE_RATE = 1e7  # bytes a second that a long file is written with at least
_EXPANSION = 8  # memory for reading a file, in sizes of it
_NUMBER_BYTES = 24  # at most, for each number that is read
_PACKED_BYTES = 40  # for each number of a packed file, whose size says little
_EXAMPLE = "time [s],x_ref [mm],x_act [mm]\n0.0000,0.000,0.001\n0.0005,0.010,0.009\n"


class ExportQuery(BaseModel):
    """Which part of a run is wanted, and how."""

    format: Literal["csv", "parquet", "mat", "mcap", "mf4"] = Field(
        default="parquet", description="docs/exchange.md describes each"
    )
    columns: str = Field(
        default="",
        max_length=5_000,
        description="Channels, name=expression, or * for all channels, comma between them; or all",
        examples=["A.x.following_error,x.position_reference"],
    )
    start: int = Field(default=0, alias="from", ge=0, description="First sample", examples=[0])
    stop: int | None = Field(
        default=None, alias="to", ge=1, description="Sample after the last", examples=[2000]
    )


class ImportQuery(BaseModel):
    """What is said of a file that is imported; the rest is guessed."""

    preview: bool = Field(default=False, description="Keep nothing, show how it would be read")
    name: str = Field(
        default="", max_length=NAME_MAX, pattern=LINE, description="What the run is called"
    )
    rate: float | None = Field(
        default=None, gt=0, le=RATE_MAX, description="Sample rate of a file without time, Hz"
    )
    resample: float | None = Field(
        default=None, gt=0, le=RATE_MAX, description="Rate to interpolate to, Hz; or as measured"
    )
    delimiter: Literal["", "comma", "semicolon", "tab"] = Field(
        default="", description="Between the fields of CSV; empty to find it out"
    )
    decimal: Literal["", "point", "comma"] = Field(
        default="", description="Decimal sign of CSV; empty to find it out"
    )
    first_bytes: int | None = Field(
        default=None,
        ge=1,
        description="The body is two files of one motion: so many bytes are the first, and the "
        "rest is the second, whose columns are put on the times of the first",
    )
    align: str = Field(
        default="", max_length=300, description="Of two files: COLUMN, A=B, or A=-B, aligned"
    )
    offset: float | None = Field(
        default=None,
        allow_inf_nan=False,
        description="Of two files: added to times of the second, s; left out: estimated",
    )
    map: list[Annotated[str, Field(max_length=300)]] = Field(
        default=[],
        max_length=100,
        description="COLUMN=CHANNEL[UNIT] each: a channel, time, - to leave out, or nothing",
        examples=[["x_act=M.x.position_measured[mm]"]],
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
    request: Request, run_id: RunId, query: Annotated[ExportQuery, Query()]
) -> Response:
    """Return telemetry of a run as a file."""
    settings: Settings = request.app.state.settings
    columns = tuple(split_columns(query.columns)) if query.columns else ()
    selection = Selection(columns, query.start, query.stop)
    most = settings.memory_max
    planned = await called(request, _plan, run_id, selection, query.format, most, light=True)
    selection, size, name = planned.value
    planned.close()
    seconds = WRITE_SECONDS + size / _WRITE_RATE

    async def write(path: Path) -> None:
        arguments = (run_id, selection, str(path), query.format)
        (await called(request, _write, *arguments, seconds=seconds)).close()

    return await file_download(
        request,
        write,
        name=f"{name}.{query.format}",
        media_type=FORMATS[query.format],
        size=size,
    )


@router.post(
    "/import",
    operation_id="importRun",
    status_code=201,
    response_model=Import,
    responses={
        200: {"description": "A preview: nothing is kept", "model": Import},
        201: {
            "description": "The run that was kept",
            "headers": {"Location": {"schema": {"type": "string"}}},
            "links": links("run_id", "getRun", "getRunTelemetry", "deleteRun"),
        },
        **responses(413, 422, 429, 503, 507),
    },
    openapi_extra={
        "requestBody": {
            "content": {
                "application/octet-stream": {
                    "schema": {
                        "type": "string",
                        "format": "binary",
                        "description": "CSV, Parquet, MAT (level 5), NPZ or MCAP; docs/exchange.md",
                        "examples": [_EXAMPLE],
                    }
                }
            },
            "required": True,
        }
    },
)
async def import_run(request: Request, query: Annotated[ImportQuery, Query()]) -> Response:
    """Keep a measurement of a real machine as a run, or show how it would be read."""
    options = ImportOptions(
        name=query.name,
        rate=query.rate,
        resample=query.resample,
        mapping=tuple(query.map),
        delimiter=query.delimiter,
        decimal=query.decimal,
        align=query.align,
        offset=query.offset,
    )
    if query.first_bytes is None:
        for loc, value in (("align", query.align or None), ("offset", query.offset)):
            if value is not None:
                raise ConfigError(FieldError(loc, "is of two files: give first_bytes", value))
    parse_mapping(options.mapping)
    with contextlib.ExitStack() as held:
        path = held.enter_context(temporary_folder()) / "upload"
        size = await _receive(request, path, held, query.first_bytes)
        two = query.first_bytes is not None
        if query.first_bytes is not None and query.first_bytes >= size:
            bounds = {"minimum": 1.0, "exclusive_maximum": float(size)}
            message = "leaves nothing of the body to the second file"
            raise ConfigError(
                FieldError("first_bytes", message, query.first_bytes, "", "bytes", bounds)
            )
        arguments = (str(path), size, options, query.preview, two)
        answer = await called(request, _import, *arguments, seconds=_IMPORT_SECONDS)
    document: Import = answer.value
    answer.close()
    headers = {} if document.run is None else {"Location": f"/api/v1/runs/{document.run}"}
    content = document.model_dump_json()
    status = 200 if document.run is None else 201
    return Response(content, status, headers, "application/json")


def _second(path: Path) -> Path:
    """Return where the second file of an upload is."""
    return path.with_name("second")


async def _receive(
    request: Request, path: Path, held: contextlib.ExitStack, first_bytes: int | None
) -> int:
    """Write the body to one file or two as it comes, and hold as much memory; return its length.

    The temporary folder may lie in memory, and slow clients hold theirs for a minute: uploads
    together leave three quarters of `memory_max` to everything else.
    """
    memory: MemoryBudget = request.app.state.memory
    uploads: MemoryBudget = request.app.state.uploads
    size = 0
    with path.open("wb") as file, _second(path).open("wb") as second:
        async for chunk in request.stream():
            if not uploads.try_to_take(len(chunk)):
                raise HTTPException(429, f"other uploads hold {uploads.taken} bytes already")
            held.callback(uploads.give_back, len(chunk))
            held.enter_context(memory.hold(len(chunk)))
            to_first = len(chunk) if first_bytes is None else max(0, first_bytes - size)
            size += len(chunk)
            await asyncio.to_thread(file.write, chunk[:to_first])
            await asyncio.to_thread(second.write, chunk[to_first:])
    return size


def _import(  # noqa: PLR0913, PLR0917 - by position, as calls of workers are
    call: Call, path: str, size: int, options: ImportOptions, preview: bool, two: bool
) -> Import:
    from motionlab.exchange.measurements.runs import import_file
    from motionlab.exchange.measurements.table_file import numbers_in

    second = _second(Path(path)) if two else None
    numbers = sum(numbers_in(each) for each in (Path(path), second) if each is not None)
    packed = _PACKED_BYTES * min(numbers, VALUES_MAX)
    call.hold(max(min(_EXPANSION * size, _NUMBER_BYTES * VALUES_MAX), packed))
    kept_in = None if preview else library()
    try:
        document, _ = import_file(
            Path(path), options, library=kept_in, name="measurement", second=second
        )
    except MemoryError:
        text = "takes more memory than one import may have: leave columns out, or import a part"
        raise ConfigError(FieldError("file", text)) from None
    if document.problems and not preview:
        raise ConfigError(*(FieldError("file", problem) for problem in document.problems))
    return document


def _plan(
    _: Call, run_id: str, selection: Selection, format: str, most: int
) -> tuple[Selection, int, str]:
    """Return what is exported, its bytes, and the name of the file without its ending."""
    from motionlab.exchange.exports import Source, check_selection, size_of, writing_memory_of

    run = library().complete(run_id)
    with library().files.open(run_id) as file:
        checked = check_selection(Source.of(file, run), selection)
    size = size_of(checked, format)
    if (memory := writing_memory_of(checked, format)) > most:
        raise ConfigError(
            FieldError(
                "columns",
                "is too much for one download of this format, which is written in memory: choose "
                "fewer columns, a shorter range, no math channels, Parquet or CSV, or use "
                f"motionlab export {run_id} FILE.{format}",
                memory,
                unit="bytes",
                bounds={"maximum": most},
            )
        )
    return checked, size, _file_name(run, checked)


def _file_name(run: RunDetail, selection: Selection) -> str:
    """Return the identifier of the run, and of a part the times of its first and last sample."""
    stop = run.ticks if selection.stop is None else min(selection.stop, run.ticks)
    if selection.start == 0 and stop == run.ticks:
        return run.id
    ends = (run.first_tick + sample for sample in (selection.start, stop - 1))
    first, last = (f"{tick * run.period:.8g}" for tick in ends)
    return f"{run.id}_{first}-{last}s"


def _write(call: Call, run_id: str, selection: Selection, path: str, format: str) -> None:
    from motionlab.exchange.exports import Source, export, writing_memory_of

    if memory := writing_memory_of(selection, format):
        call.hold(memory)
    run = library().complete(run_id)
    with library().files.open(run_id) as file:
        export(Source.of(file, run), selection, Path(path), format)
