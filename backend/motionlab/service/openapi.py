"""What the OpenAPI document says beyond what FastAPI can tell of the routes."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI

from motionlab.service import messages, problems


def install(app: FastAPI) -> None:
    """Let the document of `app` hold problems and stream messages, and nothing of FastAPI's own."""
    of_the_routes = app.openapi

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            _complete(of_the_routes())
        return app.openapi_schema or {}

    app.openapi = openapi


def _complete(document: dict[str, Any]) -> None:
    schemas = document["components"]["schemas"]
    for model in (problems.Problem, problems.ProblemField):
        schemas[model.__name__] = model.model_json_schema(
            ref_template="#/components/schemas/{model}"
        )
        schemas[model.__name__].pop("$defs", None)
    schemas.update(messages.schemas())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    for operations in document["paths"].values():
        for operation in operations.values():
            refused = operation["responses"].get("422", {})
            if "application/json" in refused.get("content", {}):  # where FastAPI has put its own
                operation["responses"]["422"] = problems.responses(422)[422]
