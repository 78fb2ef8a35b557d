"""Force maps: computed as jobs, kept, listed, deleted; a preview and the field at once."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, HTTPException, Path, Query, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from starlette.convertors import StringConvertor, register_url_convertor

from motionlab.design.fem.compute import PRESETS, compute
from motionlab.design.fem.document import (
    MapEntry,
    MapRequest,
    MapTables,
    entry,
    read_map_request,
    tables,
)
from motionlab.design.fem.force_map import ForceMapDocument
from motionlab.design.fem.geometry import Geometry
from motionlab.design.fem.mesh import Resolution, vertices
from motionlab.design.fem.picture import (
    RESOLUTION,
    FieldPicture,
    FieldRequest,
    picture,
    read_field_request,
)
from motionlab.errors import ConfigError, FieldError
from motionlab.service.bodies import JsonRoute
from motionlab.service.described import DescribedTable
from motionlab.service.jobs import Progress
from motionlab.service.problems import responses
from motionlab.service.routes.jobs import ACCEPTED, as_job
from motionlab.service.settings import Settings
from motionlab.service.slots import free_slot
from motionlab.store.files import data_root
from motionlab.store.map_library import Found, delete_computed, find_map, map_entries
from motionlab.store.maps import MapStore, computed_or_kept, map_file


class _NameConvertor(StringConvertor):
    """Leaves the names of calls to the calls."""

    regex = "(?!(?:preview|field)$)[^/]+"


register_url_convertor("map", _NameConvertor())

router = APIRouter(prefix="/maps", tags=["maps"], route_class=JsonRoute)

Name = Annotated[str, Path(pattern="^[a-z0-9-]{1,64}$", description="Name or content hash")]
Positions = Annotated[int, Query(ge=5, le=721, description="Rows of the tables, over one pitch")]
Currents = Annotated[int, Query(ge=2, le=201, description="Columns of the tables, from 0")]


@router.post(
    "",
    operation_id="computeMap",
    response_model=MapEntry,
    responses={**ACCEPTED, **responses(400, 413, 415, 422, 429, 503, 507)},
)
async def compute_map(
    request: Request,
    body: Annotated[
        dict[str, Any],
        DescribedTable(MapRequest),
        Body(examples=[{"preset": "default", "geometry": {"g": 0.4e-3}}]),
    ],
) -> Response:
    """Compute a force map as a job; one that was computed before is answered at once."""
    wanted = await run_in_threadpool(_wanted, body, request.app.state.settings)
    store = _store()
    kept = await run_in_threadpool(store.find, wanted.geometry, wanted.preset)
    if kept is not None:
        name = kept.document.content_hash
        return JSONResponse(entry(kept, name=name, shipped=False).model_dump(mode="json"))
    await run_in_threadpool(store.check_room)

    def work(progress: Progress) -> MapEntry:
        made, _ = computed_or_kept(store, wanted.geometry, wanted.preset, progress=progress)
        return entry(made, name=made.document.content_hash, shipped=False)

    return as_job(request, "map", body, work)


@router.post("/preview", operation_id="previewMap", responses=responses(400, 413, 415, 422, 429))
async def preview_map(
    request: Request,
    body: Annotated[dict[str, Any], DescribedTable(Geometry), Body(examples=[{"g": 0.4e-3}])],
    positions: Positions = 49,
    currents: Currents = 11,
) -> MapTables:
    """Return a map by a magnetic circuit, at once and kept nowhere; fields of the geometry."""
    table = {"preset": "preview", "geometry": body}
    try:
        wanted = await run_in_threadpool(_wanted, table, request.app.state.settings)
    except ConfigError as error:
        raise ConfigError(*(_of_the_geometry(e) for e in error.errors)) from None
    async with free_slot(request):
        found = await run_in_threadpool(compute, wanted.geometry, "preview")
        return tables(
            found,
            name=found.document.content_hash,
            shipped=False,
            positions=positions,
            currents=currents,
        )


@router.post("/field", operation_id="mapField", responses=responses(400, 413, 415, 422, 429))
async def map_field(
    request: Request,
    body: Annotated[
        dict[str, Any],
        DescribedTable(FieldRequest),
        Body(examples=[{"position": -2.1e-3, "current": 10.0, "columns": 96}]),
    ],
) -> FieldPicture:
    """Return flux density on a grid, flux lines, and outlines of iron and coils."""
    wanted = read_field_request(body)
    _check_size(wanted.geometry, RESOLUTION, request.app.state.settings)
    async with free_slot(request):
        return await run_in_threadpool(picture, wanted)


@router.get("", operation_id="listMaps")
def list_maps() -> list[MapEntry]:
    """List the maps that ship and those that were computed."""
    return map_entries()


@router.get("/{name:map}", operation_id="getMap", responses=responses(404, 422))
def get_map(name: Name, positions: Positions = 49, currents: Currents = 11) -> MapTables:
    """Return thrust and normal force over position and current, from the map's splines."""
    found = _found(name)
    return tables(
        found.force_map,
        name=name,
        shipped=found.shipped,
        positions=positions,
        currents=currents,
    )


@router.get("/{name:map}/file", operation_id="getMapFile", responses=responses(404, 422))
def get_map_file(name: Name) -> ForceMapDocument:
    """Return a map's file: its nodes, as ``motionlab map --json`` prints them."""
    return _found(name).force_map.document


@router.delete(
    "/{name:map}",
    operation_id="deleteMap",
    status_code=204,
    responses=responses(404, 409, 422, 503),
)
def delete_map(name: Name) -> Response:
    """Delete a computed map."""
    file = map_file(name)
    if file is not None and file.shipped:
        raise HTTPException(409, f"{name!r} ships with the project and cannot be deleted")
    if not delete_computed(name):
        raise HTTPException(404, f"no map {name!r}")
    return Response(status_code=204)


def _wanted(body: dict[str, Any], settings: Settings) -> MapRequest:
    """Return a request, checked, that is not too large for a server."""
    wanted = read_map_request(body)
    _check_size(wanted.geometry, PRESETS[wanted.preset].resolution or RESOLUTION, settings)
    return wanted


def _check_size(geometry: Geometry, resolution: Resolution, settings: Settings) -> None:
    """Refuse a geometry whose long thin parts take too many nodes."""
    count = vertices(geometry, resolution)
    if count > settings.map_vertices_max:
        raise ConfigError(
            FieldError(
                "geometry",
                "takes too many nodes of a mesh; its heights are large against tau",
                count,
                f"<= {settings.map_vertices_max}",
            )
        )


def _of_the_geometry(error: FieldError) -> FieldError:
    loc = error.loc.removeprefix("geometry.")
    return FieldError(loc, error.message, error.value, error.range, error.unit)


def _found(name: str) -> Found:
    found = find_map(name)
    if found is None:
        raise HTTPException(404, f"no map {name!r}")
    return found


def _store() -> MapStore:
    return MapStore(data_root() / "maps")
