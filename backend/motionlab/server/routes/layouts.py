"""Named layouts of scopes: which channels each scope of the page shows."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Path, Request, Response

from motionlab.library.gain_set import NAME
from motionlab.library.layout import ScopeLayout, Scopes
from motionlab.library.library import library
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.worker_answers import called, computed
from motionlab.server.workers.pool import indexed
from motionlab.server.workers.worker import Call

router = APIRouter(prefix="/layouts", tags=["layouts"], route_class=JsonRoute)

LayoutName = Annotated[str, Path(pattern=NAME, description="Name of a layout", examples=["errors"])]


class LayoutRequest(Scopes):
    """The scopes of a layout."""

    model_config = examples(
        {"scopes": ["A.x.following_error,B.x.following_error", "B.x.thrust,B.x.friction@0.5"]}
    )


@router.get(
    "", operation_id="listLayouts", response_model=list[ScopeLayout], responses=responses(429, 503)
)
async def list_layouts(request: Request) -> Response:
    """Return all layouts by name."""
    return await computed(request, _listed, light=True)


@router.put(
    "/{name}",
    operation_id="putLayout",
    response_model=ScopeLayout,
    responses=responses(400, 413, 415, 422, 429, 503, 507),
)
async def put_layout(
    request: Request, name: LayoutName, body: Annotated[LayoutRequest, Body()]
) -> Response:
    """Save scopes under a name, in the place of the layout that had it."""
    return await computed(request, _saved, name, body, light=True)


@router.delete(
    "/{name}",
    operation_id="deleteLayout",
    status_code=204,
    responses=responses(404, 422, 429, 503),
)
async def delete_one(request: Request, name: LayoutName) -> Response:
    """Delete a layout."""
    (await called(request, _deleted, name, light=True)).close()
    return Response(status_code=204)


@indexed
def _listed() -> list[ScopeLayout]:
    from motionlab.library.layouts import all_layouts

    return all_layouts(library().index)


@indexed
def _saved(name: str, body: LayoutRequest) -> ScopeLayout:
    from motionlab.library.layouts import save_layout

    layout = ScopeLayout(name=name, scopes=body.scopes)
    save_layout(library().index, layout)
    return layout


@indexed
def _deleted(_: Call, name: str) -> None:
    from motionlab.library.layouts import delete_layout

    delete_layout(library().index, name)
