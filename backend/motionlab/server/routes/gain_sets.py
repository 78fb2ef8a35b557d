"""Named gain sets: saved with what they achieved, listed, exported, deleted."""

from __future__ import annotations

from typing import Annotated, Any

import tomli_w
from fastapi import APIRouter, Body, Path, Request, Response
from pydantic import Field

from motionlab.config.load import load_scenario
from motionlab.library.gain_sets import NAME, VALUES_MAX, GainSet, gain_sets, measured, tables_of
from motionlab.server.http.openapi_input import Paths, examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.named_documents import DocumentRoutes
from motionlab.server.routes.simulate import ChangedScenario
from motionlab.server.worker_answers import ComputedResponse, called
from motionlab.server.workers.pool import indexed
from motionlab.server.workers.worker import Call

router = APIRouter(prefix="/gain-sets", tags=["gain sets"], route_class=JsonRoute)

SetName = Annotated[
    str, Path(pattern=NAME, description="Name of a gain set", examples=["stiffer B"])
]


class GainSetRequest(ChangedScenario):
    """Values of controllers, and the scenario in which they are measured."""

    model_config = examples(
        {"scenario": "circle", "values": {"variants.B.controller.x.k_p": 312000.0}}
    )

    values: Annotated[dict[str, Any], Paths("variants")] = Field(
        min_length=1, max_length=VALUES_MAX, description="Dotted path to value, SI"
    )
    note: str = Field(default="", max_length=2000)


@indexed
def _saved(name: str, body: GainSetRequest) -> GainSet:
    scenario = load_scenario(body.scenario, {**body.set, **body.values})
    return gain_sets().put(measured(name, body.note, scenario, body.values))


indexed(gain_sets)
routes = DocumentRoutes(router, gain_sets, ("GainSet", "GainSets"), SetName, in_worker=True)
routes.list(GainSet, "Return all gain sets, the newest first.")
routes.put(
    Annotated[GainSetRequest, Body()],
    GainSet,
    "Save values of controllers under a name, with the metrics and margins that they have.",
    save=_saved,
    light=False,
)
routes.delete("Delete a gain set.")


@router.get(
    "/{name}/scenario.toml",
    operation_id="getGainSetFile",
    response_class=Response,
    responses={
        200: {
            "description": "Tables of a scenario; docs/scenarios.md",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        },
        **responses(404, 422, 429, 503),
    },
)
async def get_gain_set_file(request: Request, name: SetName) -> Response:
    """Return a gain set as a TOML file; ``motionlab run`` takes it where its scenario ships."""
    answer = await called(request, _as_toml, name, light=True)
    headers = {"Content-Disposition": f'attachment; filename="{name.replace(" ", "-")}.toml"'}
    return ComputedResponse(answer, headers=headers, media_type="text/plain; charset=utf-8")


@indexed
def _as_toml(_: Call, name: str) -> bytes:
    return tomli_w.dumps(tables_of(gain_sets().get(name))).encode()
