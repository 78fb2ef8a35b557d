"""Motor sizing, from requirements to dimensions and back, and the platforms' bending."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from motionlab.design.design import design
from motionlab.design.document import DesignDocument
from motionlab.design.inputs import DesignRequest
from motionlab.design.plate.document import PlatformDocument, platform
from motionlab.design.plate.inputs import PlatformRequest, read_platform_request
from motionlab.service.http.openapi_input import DescribedTable
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.worker_answers import computed
from motionlab.store.maps import named_map

router = APIRouter(tags=["design"], route_class=JsonRoute)


class _AsPlatformRequest:
    """Describes a table as a request; its parser fills in what the axis' defaults give."""

    def __get_pydantic_json_schema__(
        self, _: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        schema = handler.resolve_ref_schema(handler(PlatformRequest.__pydantic_core_schema__))
        return schema | {"title": "PlatformRequest", "required": []}


@router.post(
    "/design",
    operation_id="design",
    response_model=DesignDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def size_motor(
    request: Request,
    body: Annotated[
        dict[str, Any],
        DescribedTable(DesignRequest),
        Body(examples=[{"requirements": {"f_max": 50.0}}, {"preset": "previous"}]),
    ],
) -> Response:
    """Size a motor by the paper's equations (1) to (14), as printed beside corrected.

    An empty table is the paper's example.
    """
    return await computed(request, design, body, light=True)


@router.post(
    "/design/platform",
    operation_id="bendPlatform",
    response_model=PlatformDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def bend_platform(
    request: Request,
    body: Annotated[
        dict[str, Any],
        _AsPlatformRequest(),
        Body(examples=[{"axis": "x"}, {"axis": "y", "new": {"rib_height": 0.04}}]),
    ],
) -> Response:
    """Bend two designs of a moving platform under four movers' normal forces.

    An empty table is the y platform with this project's shapes; the paper prints none.
    """
    return await computed(request, _bent, body)


def _bent(body: dict[str, Any]) -> PlatformDocument:
    wanted = read_platform_request(body)
    force_map = None if wanted.map is None else named_map(wanted.map.name, "map")
    return platform(wanted, force_map)
