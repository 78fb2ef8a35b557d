"""Force maps: computed as jobs, kept, listed, deleted; a preview and the field at once."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, HTTPException, Path, Query, Request, Response
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
from motionlab.design.fem.force_map import ForceMap, ForceMapDocument
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
from motionlab.service.http.openapi_input import DescribedTable
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import MapJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import computed, json_of
from motionlab.service.workers.worker import Call
from motionlab.store.files import data_root
from motionlab.store.map_library import Found, delete_computed, find_map, map_entries
from motionlab.store.maps import MapStore, map_file
from motionlab.studies.maps.compute import computed_or_kept


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
    responses={**accepted(MapJob), **responses(400, 413, 415, 422, 429, 503, 507)},
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
    return await as_job(request, "map", _made, _kept, body)


@router.post(
    "/preview",
    operation_id="previewMap",
    response_model=MapTables,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def preview_map(
    request: Request,
    body: Annotated[dict[str, Any], DescribedTable(Geometry), Body(examples=[{"g": 0.4e-3}])],
    positions: Positions = 49,
    currents: Currents = 11,
) -> Response:
    """Return a map by a magnetic circuit, at once and kept nowhere; fields of the geometry."""
    bounds = request.app.state.settings.bounds
    return await computed(request, _previewed, body, positions, currents, bounds)


@router.post(
    "/field",
    operation_id="mapField",
    response_model=FieldPicture,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def map_field(
    request: Request,
    body: Annotated[
        dict[str, Any],
        DescribedTable(FieldRequest),
        Body(examples=[{"position": -2.1e-3, "current": 10.0, "columns": 96}]),
    ],
) -> Response:
    """Return flux density on a grid, flux lines, and outlines of iron and coils."""
    return await computed(request, _pictured, body, request.app.state.settings.bounds)


@router.get(
    "",
    operation_id="listMaps",
    response_model=list[MapEntry],
    responses=responses(429, 503),
)
async def list_maps(request: Request) -> Response:
    """List the maps that ship and those that were computed."""
    return await computed(request, map_entries, light=True)


@router.get(
    "/{name:map}",
    operation_id="getMap",
    response_model=MapTables,
    responses=responses(404, 422, 429, 503),
)
async def get_map(
    request: Request, name: Name, positions: Positions = 49, currents: Currents = 11
) -> Response:
    """Return thrust and normal force over position and current, from the map's splines."""
    return await computed(request, _tabulated, name, positions, currents, light=True)


@router.get(
    "/{name:map}/file",
    operation_id="getMapFile",
    response_model=ForceMapDocument,
    responses=responses(404, 422, 429, 503),
)
async def get_map_file(request: Request, name: Name) -> Response:
    """Return a map's file: its nodes, as ``motionlab map --json`` prints them."""
    return await computed(request, _nodes, name, light=True)


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


def _kept(call: Call, bounds: Settings, body: dict[str, Any]) -> bytes | Asked:
    """Return a map that was computed before, or the request where it takes a job."""
    wanted, store = _wanted(body, bounds), _store()
    kept = store.find(wanted.geometry, wanted.preset)
    if kept is not None:
        return json_of(call, _entry, (kept,))
    store.check_room()
    return Asked.of(body)


def _made(call: Call, body: dict[str, Any], bounds: Settings) -> MapEntry:
    wanted = _wanted(body, bounds)
    made, _ = computed_or_kept(_store(), wanted.geometry, wanted.preset, progress=call.progress)
    return _entry(made)


def _entry(force_map: ForceMap) -> MapEntry:
    return entry(force_map, name=force_map.document.content_hash, shipped=False)


def _previewed(
    geometry: dict[str, Any], positions: int, currents: int, bounds: Settings
) -> MapTables:
    try:
        wanted = _wanted({"preset": "preview", "geometry": geometry}, bounds)
    except ConfigError as error:
        raise ConfigError(*(_of_the_geometry(e) for e in error.errors)) from None
    found = compute(wanted.geometry, "preview")
    name = found.document.content_hash
    return tables(found, name=name, shipped=False, positions=positions, currents=currents)


def _pictured(body: dict[str, Any], bounds: Settings) -> FieldPicture:
    wanted = read_field_request(body)
    _check_size(wanted.geometry, RESOLUTION, bounds)
    return picture(wanted)


def _tabulated(name: str, positions: int, currents: int) -> MapTables:
    shipped, force_map = _found(name)
    return tables(force_map, name=name, shipped=shipped, positions=positions, currents=currents)


def _nodes(name: str) -> ForceMapDocument:
    return _found(name).force_map.document


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
