"""Spectra: of a run, and of samples in the request."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.loop.linearise import SLIDING
from motionlab.server.http.openapi_input import PATHS_MAX, Paths, ScenarioSource, examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.runs import RunId
from motionlab.server.worker_answers import computed
from motionlab.studies.spectrum import (
    COLUMNS_MAX,
    NO_LOOP,
    OwnLoop,
    Samples,
    SpectrumDocument,
    SpectrumOptions,
    document,
    error_of,
    run_spectra,
    take,
)
from motionlab.telemetry.expressions.columns import TEXT_MAX, split_columns

router = APIRouter(route_class=JsonRoute)

VALUES_MAX = 60_000
"""Most samples of all columns of a request."""

_EXAMPLE: dict[str, Any] = {
    "period": 0.0005,
    "columns": [{"name": "B.x.following_error", "unit": "m", "values": [1e-7, -1e-7] * 100}],
    "averages": 1,
    "scenario": "circle",
    "velocity": 0.02,
}


class SpectrumQuery(SpectrumOptions):
    """Which part of a run is wanted, and how its spectra are taken."""

    columns: str = Field(
        max_length=4000,
        description="Names of channels or name=expression, comma between them; docs/expressions.md",
        examples=["A.x.following_error"],
    )
    start: int = Field(default=0, alias="from", ge=0, description="First sample", examples=[1000])
    stop: int | None = Field(
        default=None, alias="to", ge=1, description="Sample after the last", examples=[5000]
    )


class SampledColumn(BaseModel):
    """Samples of a column."""

    model_config = ConfigDict(extra="forbid")

    name: str = Field(min_length=1, max_length=TEXT_MAX, description="As in a run; any for others")
    unit: str = Field(max_length=40)
    values: list[Annotated[float, Field(allow_inf_nan=False, ge=-1e30, le=1e30)] | None] = Field(
        max_length=VALUES_MAX, description="At equal times; null where one is missing"
    )


class SpectrumRequest(SpectrumOptions):
    """Samples, how their spectra are taken, and the scenario whose loops they are of."""

    model_config = ConfigDict(extra="forbid") | examples(_EXAMPLE)

    period: float = Field(ge=1e-6, le=1e3, description="Time between samples, s")
    columns: list[SampledColumn] = Field(min_length=1, max_length=COLUMNS_MAX)
    scenario: Annotated[str | dict[str, Any], ScenarioSource()] | None = Field(
        default=None,
        description="Whose loops following errors such as B.x.following_error are of; null: none",
    )
    set: Annotated[dict[str, Any], Paths(*Scenario.model_fields)] = Field(
        default_factory=dict, max_length=PATHS_MAX, description="Dotted path to value, SI"
    )
    velocity: float | None = Field(
        default=None,
        ge=0,
        le=10,
        description="About which loops are linearised, m/s; null: four Stribeck velocities",
    )


@router.get(
    "/runs/{run_id}/spectrum",
    tags=["runs"],
    operation_id="getRunSpectrum",
    response_model=SpectrumDocument,
    responses=responses(400, 404, 409, 422, 429, 503),
)
async def get_run_spectrum(
    request: Request, run_id: RunId, query: Annotated[SpectrumQuery, Query()]
) -> Response:
    """Return spectra of columns between two samples; docs/spectrum.md."""
    return await computed(request, _of_run, run_id, query)


@router.post(
    "/spectrum",
    tags=["simulate"],
    operation_id="getSpectrum",
    response_model=SpectrumDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def get_spectrum(request: Request, body: Annotated[SpectrumRequest, Body()]) -> Response:
    """Return spectra of the samples in the request; docs/spectrum.md."""
    return await computed(request, _of_samples, body)


def _of_run(run_id: str, query: SpectrumQuery) -> SpectrumDocument:
    columns = split_columns(query.columns)
    taken, period = run_spectra(run_id, columns, query.start, query.stop, query)
    return document(taken, query, period=period)


def _of_samples(body: SpectrumRequest) -> SpectrumDocument:
    count = sum(len(column.values) for column in body.columns)
    if count > VALUES_MAX:
        bounds: dict[str, float] = {"maximum": VALUES_MAX}
        raise ConfigError(FieldError("columns", "too many samples", count, bounds=bounds))
    scenario = None if body.scenario is None else load_scenario(body.scenario, body.set)
    taken = [
        take(
            Samples(column.name, column.unit, np.array(column.values, dtype=np.float64)),
            body,
            period=body.period,
            loop=_loop(column.name, scenario, body.velocity),
        )
        for column in body.columns
    ]
    return document(taken, body, period=body.period)


def _loop(column: str, scenario: Scenario | None, velocity: float | None) -> OwnLoop | str:
    error = error_of(column)
    if error is None:
        return NO_LOOP
    if scenario is None:
        return "no scenario was given"
    variant, axis = error
    if variant not in scenario.variants:
        return f"the scenario has no variant {variant}"
    v = SLIDING * getattr(scenario.plant, axis).friction.v_s if velocity is None else velocity
    return OwnLoop(scenario, variant, axis, v)
