"""OpenAPI descriptions of input that only the scenario parser validates."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, GetJsonSchemaHandler, TypeAdapter, create_model
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from motionlab.config.named_configs import names
from motionlab.config.scenario import Scenario
from motionlab.config.schema import scenario_schema
from motionlab.config.trajectory import TrajectoryConfig

ID = "^[A-Za-z0-9_-]{12}$"
"""Form of the identifiers of sessions and jobs; any other is unknown."""

PATHS_MAX = 4096
"""Changes in one request."""

EXAMPLE_PATH: dict[str, Any] = {
    "kind": "path",
    "points": [[0.0, 0.0], [0.01, 0.02], [0.03, 0.02]],
    "v_max": 0.1,
    "a_max": 1.0,
}
"""A trajectory, as examples of requests give it."""

_PARTS = ("plant", "variants", "trajectory", "load", "schedule", "window", "learnt")


def examples(*bodies: dict[str, Any]) -> ConfigDict:
    """Return the configuration of a request model that OpenAPI shows with these examples."""
    return ConfigDict(json_schema_extra={"examples": list(bodies)})


class Paths:
    """Describes the keys of a mapping of dotted paths to values."""

    def __init__(self, *roots: str) -> None:
        self.pattern = rf"^({'|'.join(roots)})(\.[A-Za-z0-9_-]+)*$"

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of the mapping, with that of its keys."""
        return handler(core) | {"propertyNames": {"pattern": self.pattern}}


@cache
def _fields() -> dict[str, Any]:
    """Return the schema of each field of a scenario that is no part of it."""
    fields = scenario_schema()["properties"]
    return {key: field for key, field in fields.items() if key not in _PARTS}


class ScenarioSource:
    """Describes a scenario as a request gives it: by name, or as tables that may build on names."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of both forms."""
        name = {"type": "string", "enum": names("scenarios")}
        table: dict[str, Any] = {"type": "object"}
        tables = {
            "type": "object",
            "properties": {
                "base": name,
                **deepcopy(_fields()),
                "plant": {"anyOf": [{"type": "string", "pattern": "^[a-z0-9-]{1,64}$"}, table]},
                "trajectory": {"anyOf": [{"type": "string", "enum": names("trajectories")}, table]},
                "variants": {
                    "type": "object",
                    "patternProperties": {"^[A-Z]$": table},
                    "additionalProperties": False,
                },
                "load": table,
                "schedule": {"type": "array", "items": table, "maxItems": 100},
                "window": {"anyOf": [table, {"type": "null"}]},
                "learnt": {"anyOf": [table, {"type": "null"}]},
            },
            "additionalProperties": False,
            "anyOf": [
                {"required": ["base"]},
                {"required": ["plant", "variants", "trajectory"]},
            ],
        }
        return {"anyOf": [name, tables]}


class DescribedTable:
    """Describes a table as a model whose own parser checks it, naming field, unit and range."""

    def __init__(self, model: type[BaseModel]) -> None:
        self._model = model

    def __get_pydantic_json_schema__(
        self, _: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of the model."""
        return handler(self._model.__pydantic_core_schema__)


class Described(DescribedTable):
    """Describes a table as a request that begins with a scenario; its own parser checks it.

    Parameters
    ----------
    model : type
        The request, with fields ``scenario`` and ``set``.
    """

    def __init__(self, model: type[BaseModel]) -> None:
        paths = Field(
            default_factory=dict, max_length=PATHS_MAX, description="Dotted path to value, SI"
        )
        fields: dict[str, Any] = {
            "scenario": (Annotated[str | dict[str, Any], ScenarioSource()], "circle"),
            "set": (Annotated[dict[str, Any], Paths(*Scenario.model_fields)], paths),
        }
        super().__init__(
            create_model(model.__name__, __doc__=model.__doc__, __base__=model, **fields)
        )


class TrajectoryTable:
    """Describes a trajectory as its models do, while the parser of scenarios reads it."""

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Return the schema of every kind of motion."""
        return handler(TypeAdapter(TrajectoryConfig).core_schema)


def links(parameter: str, *operations: str) -> dict[str, Any]:
    """Return OpenAPI links from a created resource to its operations.

    Parameters
    ----------
    parameter : str
        The operations' name for the ``id`` of the answer.
    *operations : str
        Their operation ids.
    """
    return {
        operation: {"operationId": operation, "parameters": {parameter: "$response.body#/id"}}
        for operation in operations
    }
