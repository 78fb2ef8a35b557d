"""Friction identification, always as a job."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.errors import ConfigError, FieldError
from motionlab.service.http.openapi_input import Described
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import IdentificationJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import computed
from motionlab.service.workers.worker import Call
from motionlab.studies.identify.document import IdentificationDocument, PlanDocument
from motionlab.studies.identify.request import IdentifyRequest, read_request

if TYPE_CHECKING:
    from motionlab.studies.identify.plan import Experiment

router = APIRouter(tags=["identify"], route_class=JsonRoute)


@router.post(
    "/identify",
    operation_id="identify",
    status_code=202,
    response_model=IdentificationJob,
    responses={**accepted(IdentificationJob), **responses(400, 413, 415, 422, 429, 503)},
)
async def identify_friction(
    request: Request,
    body: Annotated[
        dict[str, Any],
        Described(IdentifyRequest),
        Body(examples=[{"scenario": "circle", "set": {"plant": "as-measured"}, "axis": "x"}]),
    ],
) -> Response:
    """Identify friction by uniform motions and force ramps on the simulated motor.

    The job's report carries the points measured so far, and at the end what is fitted to them.
    """
    return await as_job(request, "identify", _identified, _checked, body)


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
    """Check an identification and say what it would do and how long that takes; nothing moves."""
    settings: Settings = request.app.state.settings
    return await computed(request, _plan, body, settings.work_max, light=True)


def _plan(body: dict[str, Any], work_max: float) -> PlanDocument:
    from motionlab.studies.identify.plan import plan, plan_document

    return plan_document(plan(read_request(body)), work_max)


def _checked(_: Call, bounds: Settings, body: dict[str, Any]) -> Asked:
    _planned(body, bounds)
    return Asked.of(body)


def _identified(call: Call, body: dict[str, Any], bounds: Settings) -> IdentificationDocument:
    from motionlab.studies.identify.experiment import identify

    return identify(_planned(body, bounds), call.progress)


def _planned(body: dict[str, Any], settings: Settings) -> Experiment:
    """Return a request's experiment, checked, or raise what is wrong with it."""
    from motionlab.studies.identify.plan import plan

    experiment = plan(read_request(body))
    if experiment.seconds > settings.work_max:
        raise ConfigError(
            FieldError(
                loc="speeds",
                message="simulated time of all of them is too large for one request",
                value=experiment.seconds,
                range=f"<= {settings.work_max:g}",
                unit="s",
            )
        )
    return experiment
