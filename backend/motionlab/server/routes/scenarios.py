"""Shipped scenarios and parts, and the schema of scenarios."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Path, Request, Response
from pydantic import BaseModel, Field

from motionlab.config.bounds import TEXT_MAX
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import Kind, names, own_motors, parse_text, read
from motionlab.config.scenario import Scenario
from motionlab.config.schema import scenario_schema
from motionlab.library.motors import description_of
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.worker_answers import computed

router = APIRouter(tags=["scenarios"], route_class=JsonRoute)

_PARTS: tuple[Kind, ...] = ("motors", "controllers", "trajectories")

Name = Annotated[
    str,
    Path(
        pattern="^[a-z0-9-]{1,64}$",
        description="Name of a shipped scenario",
        examples=["circle"],
    ),
]


class ScenarioEntry(BaseModel):
    """One shipped scenario."""

    name: str = Field(description="Name, as simulate takes it")
    title: str = Field(description="One line for people")
    description: str = Field(description="What it shows and whose choice its numbers are")


@router.get("/scenarios", operation_id="listScenarios")
def list_scenarios() -> list[ScenarioEntry]:
    """List the shipped scenarios."""
    return [
        ScenarioEntry(name=name, title=scenario.title, description=scenario.description.strip())
        for name in names("scenarios")
        for scenario in [load_scenario(name)]
    ]


@router.get("/scenarios/{name}", operation_id="getScenario", responses=responses(404, 422))
def get_scenario(name: Name) -> Scenario:
    """Return a shipped scenario with every name in it resolved; simulate takes it as it is."""
    if name not in names("scenarios"):
        raise HTTPException(404, f"no shipped scenario {name!r}")
    return load_scenario(name)


class Part(BaseModel):
    """One part of a scenario."""

    name: str
    description: str


class Parts(BaseModel):
    """Parts that a scenario can name."""

    motors: list[Part]
    controllers: list[Part]
    trajectories: list[Part]


@router.get("/parts", operation_id="listParts")
def list_parts() -> Parts:
    """List the motors, one's own too, controllers and trajectories that a scenario can name."""
    parts = {
        kind: [Part(name=name, description=_about(kind, name)) for name in names(kind)]
        for kind in _PARTS
    }
    parts["motors"] += [Part(name=name, description=description_of(name)) for name in own_motors()]
    return Parts(**parts)


def _about(kind: Kind, name: str) -> str:
    return str(read(kind, name, loc=kind).get("description", ""))


@router.post(
    "/scenarios/parse",
    operation_id="parseScenario",
    response_model=Scenario,
    responses=responses(413, 422, 429, 503),
    openapi_extra={
        "requestBody": {
            "content": {
                "application/octet-stream": {
                    "schema": {
                        "type": "string",
                        "format": "binary",
                        "description": "TOML, a scenario as in docs/scenarios.md",
                        "examples": ['base = "circle"'],
                    }
                }
            },
            "required": True,
        }
    },
)
async def parse_scenario(request: Request) -> Response:
    """Return the scenario that a TOML text describes, with every name in it resolved."""
    return await computed(request, _parsed, await request.body(), light=True)


def _parsed(text: bytes) -> Scenario:
    return load_scenario(parse_text(text, loc="body", size_max=TEXT_MAX))


@router.get("/schema", operation_id="getSchema")
def get_schema() -> dict[str, Any]:
    """Return the JSON schema of a resolved scenario, with unit, range and source of every field."""
    return scenario_schema()
