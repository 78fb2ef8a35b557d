"""The search for gains and the gain landscape, always as jobs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.errors import ConfigError, FieldError
from motionlab.service.http.openapi_input import Described
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import LandscapeJob, TuningJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.workers.worker import Call
from motionlab.studies.tune.document import LandscapeDocument, TuneDocument
from motionlab.studies.tune.request import LandscapeRequest, TuneRequest, read_request

if TYPE_CHECKING:
    from motionlab.studies.tune.problem import Problem

router = APIRouter(tags=["tune"], route_class=JsonRoute)

_REFUSED = responses(400, 413, 415, 422, 429, 503)


@router.post(
    "/tune",
    operation_id="tune",
    status_code=202,
    response_model=TuningJob,
    responses={**accepted(TuningJob), **_REFUSED},
)
async def tune_gains(
    request: Request,
    body: Annotated[
        dict[str, Any],
        Described(TuneRequest),
        Body(examples=[{"scenario": "circle", "axis": "x", "objective": {"rms": 1.0}}]),
    ],
) -> Response:
    """Search gains by the simplex of Nelder and Mead, from several starts.

    The job's report carries what each start has evaluated, and at the end the candidates.
    """
    return await as_job(request, "tune", _tuned, _checked, TuneRequest, body, batches=True)


@router.post(
    "/landscape",
    operation_id="landscape",
    status_code=202,
    response_model=LandscapeJob,
    responses={**accepted(LandscapeJob), **_REFUSED},
)
async def gain_landscape(
    request: Request,
    body: Annotated[
        dict[str, Any],
        Described(LandscapeRequest),
        Body(examples=[{"scenario": "circle", "points": 32}]),
    ],
) -> Response:
    """Map the cost over k_p and k_d, with the edge of stability of the linearised loop.

    The job's report carries a coarse map first, then finer ones.
    """
    return await as_job(
        request, "landscape", _mapped, _checked, LandscapeRequest, body, batches=True
    )


def _checked(
    _: Call,
    bounds: Settings,
    model: type[TuneRequest | LandscapeRequest],
    body: dict[str, Any],
) -> Asked:
    _planned(model, body, bounds)
    return Asked.of(body)


def _tuned(call: Call, body: dict[str, Any], bounds: Settings) -> TuneDocument:
    from motionlab.studies.tune.search import tune

    return tune(_planned(TuneRequest, body, bounds), call.progress)


def _mapped(call: Call, body: dict[str, Any], bounds: Settings) -> LandscapeDocument:
    from motionlab.studies.tune.landscape import landscape

    return landscape(_planned(LandscapeRequest, body, bounds), call.progress)


def _planned(
    model: type[TuneRequest | LandscapeRequest], body: dict[str, Any], settings: Settings
) -> Problem:
    """Return a request's problem, checked, or raise what is wrong with it."""
    from motionlab.studies.tune.problem import plan

    problem = plan(read_request(model, body))
    too_much = [
        FieldError(loc=loc, message=message, value=round(value), range=f"<= {limit:g}", unit="s")
        for loc, message, value, limit in (
            (
                "window",
                "one trial takes too long a simulated time",
                problem.own.seconds,
                settings.direct_max,
            ),
            (
                "scenario",
                "simulated time of all trials is too large for one request",
                problem.seconds,
                settings.trials_max,
            ),
        )
        if value > limit
    ]
    if too_much:
        raise ConfigError(*too_much)
    return problem
