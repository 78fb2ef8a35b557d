"""Force sharing over a pole pitch, and the analytic map fitted to a table."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, HTTPException, Path, Request, Response

from motionlab.service.http.openapi_input import DescribedTable
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.worker_answers import computed
from motionlab.store.maps import map_names
from motionlab.studies.sharing.sharing import (
    FitDocument,
    SharingDocument,
    SharingRequest,
    fit,
    read_sharing_request,
    sharing,
)

router = APIRouter(tags=["design"], route_class=JsonRoute)


@router.post(
    "/design/sharing",
    operation_id="shareForce",
    response_model=SharingDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def share_force(
    request: Request,
    body: Annotated[
        dict[str, Any],
        DescribedTable(SharingRequest),
        Body(
            examples=[
                {"force": 20.0},
                {"controller": "nominal", "plant": "new-design", "law": "force-per-ampere"},
            ]
        ),
    ],
) -> Response:
    """Share a force among the phases over one pole pitch: currents, forces, ripple, copper loss.

    An empty table is 20 N on the nominal motor.
    """
    return await computed(request, _shared, body, light=True)


@router.get(
    "/maps/{name}/fit",
    operation_id="fitMap",
    response_model=FitDocument,
    responses=responses(404, 422, 429, 503),
)
async def fit_map(
    request: Request,
    name: Annotated[str, Path(pattern="^[a-z0-9-]{1,64}$", description="Name or content hash")],
) -> Response:
    """Fit the analytic map's F_pk, I_knee, h_2 and h_3 to a table."""
    return await computed(request, _fitted, name)


def _shared(body: dict[str, Any]) -> SharingDocument:
    return sharing(read_sharing_request(body))


def _fitted(name: str) -> FitDocument:
    if name not in map_names():
        raise HTTPException(404, f"no force map is called {name!r}")
    return fit(name)
