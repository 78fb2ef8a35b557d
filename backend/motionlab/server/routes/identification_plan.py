"""Plans of identifications."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.server.http.openapi_input import Described
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import computed
from motionlab.studies.identify.documents import IdentifyRequest, PlanDocument
from motionlab.studies.table import BY_KIND

router = APIRouter(tags=["identify"], route_class=JsonRoute)


@router.post(
    "/identify/plan",
    operation_id="planIdentification",
    response_model=PlanDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def plan_identification(
    request: Request,
    body: Annotated[
        dict[str, Any],
        Described(IdentifyRequest),
        Body(examples=[{"scenario": "circle", "axis": "x", "time_max": 5.0}]),
    ],
) -> Response:
    """Validate an identification; return its motions and times, or what is read of a run."""
    settings: Settings = request.app.state.settings
    return await computed(request, _plan, body, settings.work_max, light=True)


def _plan(body: dict[str, Any], work_max: float) -> PlanDocument:
    from motionlab.studies.identify.experiment import plan_of

    return plan_of(BY_KIND["identify"].plan(body), work_max)
