"""Named layouts of scopes: which channels each scope of the page shows."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Path

from motionlab.library.gain_sets import NAME
from motionlab.library.layouts import ScopeLayout, Scopes, layouts
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.named_documents import DocumentRoutes
from motionlab.server.workers.pool import indexed

router = APIRouter(prefix="/layouts", tags=["layouts"], route_class=JsonRoute)

LayoutName = Annotated[str, Path(pattern=NAME, description="Name of a layout", examples=["errors"])]


class LayoutRequest(Scopes):
    """The scopes of a layout."""

    model_config = examples(
        {"scopes": ["A.x.following_error,B.x.following_error", "B.x.thrust,B.x.friction@0.5"]}
    )


@indexed
def _saved(name: str, body: LayoutRequest) -> ScopeLayout:
    return layouts().put(ScopeLayout(name=name, scopes=body.scopes))


indexed(layouts)
routes = DocumentRoutes(router, layouts, ("Layout", "Layouts"), LayoutName, in_worker=True)
routes.list(ScopeLayout, "Return all layouts by name.")
routes.put(
    Annotated[LayoutRequest, Body()],
    ScopeLayout,
    "Save scopes under a name, in the place of the layout that had it.",
    save=_saved,
)
routes.delete("Delete a layout.")
