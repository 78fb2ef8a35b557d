"""Additions to FastAPI's OpenAPI document."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from typing import Any

from fastapi import FastAPI, Response
from fastapi.concurrency import run_in_threadpool

from motionlab.laws import LAWS, Law
from motionlab.server.http import problems
from motionlab.server.http.security import OPEN_PATHS
from motionlab.server.live import messages
from motionlab.server.settings import Settings

_SCHEMES = {
    "bearer": {
        "type": "http",
        "scheme": "bearer",
        "description": "`Authorization: Bearer TOKEN`, on websockets too",
    },
    "cookie": {
        "type": "apiKey",
        "in": "cookie",
        "name": "motionlab_8000",
        "description": "What a browser gets for the token at /api/v1/login, for websockets too; "
        "the number is the port of the Host header, `motionlab` without one",
    },
}


def install(app: FastAPI, settings: Settings, of_the_routes: Callable[[], dict[str, Any]]) -> None:
    """Add this server's authentication, problems and stream messages to the document of its routes.

    FastAPI's own entries for them are removed.
    """

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = of_the_routes()
            _complete(app.openapi_schema, settings)
        return app.openapi_schema

    app.openapi = openapi

    @functools.lru_cache(1)
    def text(_: tuple[Law, ...]) -> bytes:
        app.openapi_schema = None
        return json.dumps(openapi(), ensure_ascii=False, separators=(",", ":")).encode()

    @app.get("/openapi.json", include_in_schema=False)
    async def get_openapi() -> Response:
        """Answer with the document, made once for the laws: a stream may not wait so long."""
        document = await run_in_threadpool(text, tuple(LAWS.values()))
        return Response(document, media_type="application/json")


def _complete(document: dict[str, Any], settings: Settings) -> None:
    document["components"]["securitySchemes"] = _SCHEMES
    document["security"] = [{name: []} for name in _SCHEMES]
    if settings.token is None:
        document["security"].append({})  # no authentication on loopback
    for path in OPEN_PATHS:
        for operation in document["paths"][path].values():
            operation["security"] = []
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
