"""Monte Carlo studies, always as a job."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.errors import ConfigError, FieldError
from motionlab.service.http.openapi_input import Described
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import MonteCarloJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.workers.worker import Call
from motionlab.studies.montecarlo.document import MonteCarloDocument
from motionlab.studies.montecarlo.request import MonteCarloRequest, read_request

if TYPE_CHECKING:
    from motionlab.studies.montecarlo.study import Study

router = APIRouter(tags=["montecarlo"], route_class=JsonRoute)

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s: a few minutes of four cores."""


@router.post(
    "/montecarlo",
    operation_id="monteCarlo",
    status_code=202,
    response_model=MonteCarloJob,
    responses={**accepted(MonteCarloJob), **responses(400, 413, 415, 422, 429, 503)},
)
async def monte_carlo(
    request: Request,
    body: Annotated[
        dict[str, Any],
        Described(MonteCarloRequest),
        Body(examples=[{"scenario": "circle", "cases": 300, "spec": {"x": 12e-6, "y": 15e-6}}]),
    ],
) -> Response:
    """Run every controller of a scenario on many plausible plants.

    The job ends with quantiles of every metric, bands of the following error over time, how likely
    the spec is met, and the worst cases with what makes them.
    """
    return await as_job(request, "monte-carlo", _studied, _checked, body, batches=True)


def _checked(_: Call, _bounds: Settings, body: dict[str, Any]) -> Asked:
    _planned(body)
    return Asked.of(body)


def _studied(call: Call, body: dict[str, Any], _: Settings) -> MonteCarloDocument:
    from motionlab.studies.montecarlo.study import study

    return study(_planned(body), call.progress)


def _planned(body: dict[str, Any]) -> Study:
    """Return a request's study, checked, or raise what is wrong with it."""
    from motionlab.studies.montecarlo.study import plan

    planned = plan(read_request(body))
    if planned.seconds > WORK_MAX:
        raise ConfigError(
            FieldError(
                loc="cases",
                message="simulated time of all cases and variants is too large for one request",
                value=planned.seconds,
                range=f"<= {WORK_MAX:g}",
                unit="s",
            )
        )
    return planned
