"""Force maps: computed as jobs, kept, listed, deleted; a preview and the field at once."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, HTTPException, Path, Query, Request, Response
from starlette.convertors import StringConvertor, register_url_convertor

from motionlab.config.validation_errors import checked
from motionlab.errors import ConfigError
from motionlab.library.maps import ForceMaps
from motionlab.motor_design.computed_maps import too_many_nodes
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.document import MapEntry, MapTables, tables
from motionlab.motor_design.fem.force_map import ForceMapDocument, PresetName
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.picture import FieldPicture, FieldRequest, picture
from motionlab.motor_design.kept_maps import map_names
from motionlab.server.http.openapi_input import DescribedTable
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.named_documents import DocumentRoutes
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import computed
from motionlab.studies.sharing.sharing import FitDocument, fit


class _MapName(StringConvertor):
    """Names of maps; excludes those of operations."""

    regex = "(?!(?:preview|field)$)[^/]+"


register_url_convertor("map", _MapName())

router = APIRouter(prefix="/maps", tags=["maps"], route_class=JsonRoute)

Name = Annotated[
    str,
    Path(pattern="^[a-z0-9-]{1,64}$", description="Name or content hash", examples=["new-design"]),
]
Positions = Annotated[int, Query(ge=5, le=721, description="Rows of the tables, over one pitch")]
Currents = Annotated[int, Query(ge=2, le=201, description="Columns of the tables, from 0")]


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


_NOUNS = ("Map", "Maps")
DocumentRoutes(router, ForceMaps, _NOUNS, Name, in_worker=True).list(
    MapEntry, "List the maps that ship and those that were computed."
)


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


@router.get(
    "/{name:map}/fit",
    operation_id="fitMap",
    tags=["design"],
    response_model=FitDocument,
    responses=responses(404, 422, 429, 503),
)
async def fit_map(request: Request, name: Name) -> Response:
    """Fit the analytic map's F_pk, I_knee, h_2 and h_3 to a table."""
    return await computed(request, _fitted, name)


DocumentRoutes(router, ForceMaps, _NOUNS, Name, "/{name:map}").delete("Delete a computed map.")


def _previewed(
    geometry: dict[str, Any], positions: int, currents: int, bounds: Settings
) -> MapTables:
    checked_geometry = checked(Geometry, geometry, "geometry")
    _check_size(checked_geometry, "preview", bounds)
    force_map = compute(checked_geometry, "preview")
    name = force_map.document.content_hash
    return tables(force_map, name=name, shipped=False, positions=positions, currents=currents)


def _pictured(body: dict[str, Any], bounds: Settings) -> FieldPicture:
    request = checked(FieldRequest, body, "field")
    _check_size(request.geometry, "preview", bounds)
    return picture(request)


def _tabulated(name: str, positions: int, currents: int) -> MapTables:
    shipped, force_map = ForceMaps().get(name)
    return tables(force_map, name=name, shipped=shipped, positions=positions, currents=currents)


def _nodes(name: str) -> ForceMapDocument:
    return ForceMaps().get(name).force_map.document


def _check_size(geometry: Geometry, preset: PresetName, bounds: Settings) -> None:
    too_many = too_many_nodes(geometry, preset, bounds.map_vertices_max)
    if too_many:
        raise ConfigError(*too_many)


def _fitted(name: str) -> FitDocument:
    if name not in map_names():
        raise HTTPException(404, f"no force map is called {name!r}")
    return fit(name)
