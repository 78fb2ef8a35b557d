"""Errors as RFC 9457 problem documents: every failure of the API has this one shape."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import iter_route_contexts
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from motionlab.config.validation_errors import ends_of, in_words
from motionlab.errors import SHOWN_MAX, SIGNS, FieldError, MotionLabError
from motionlab.reports.problems import (
    BY_STATUS,
    PREFIX,
    TYPES,
    Kind,
    fields_of,
    kind_of,
    problem_document,
)
from motionlab.server.live.session_info import WrongState

MEDIA_TYPE = "application/problem+json"
RETRY_SECONDS = 2
"""``Retry-After`` of a 429 that says nothing else."""

_RETRY_AFTER = {
    "Retry-After": {
        "description": "Seconds after which the request may be repeated",
        "required": True,
        "schema": {"type": "integer", "minimum": 0},
    }
}


class ProblemField(BaseModel):
    """One input field that was refused."""

    loc: str = Field(description="Dotted path of the field")
    message: str = Field(description="What is wrong, in words")
    value: Any = Field(default=None, description="What was given; non-finite numbers as text")
    range: str = Field(default="", description="What is allowed")
    unit: str = Field(default="", description="Unit of value, range and bounds")
    bounds: dict[str, float] = Field(
        default={}, description="Ends of a numeric range: " + ", ".join(SIGNS)
    )


class Problem(BaseModel):
    """RFC 9457 problem document."""

    type: str = Field(
        description="What a program can tell problems apart by",
        json_schema_extra={"enum": [PREFIX + kind for kind in TYPES]},
    )
    title: str = Field(description="Name of the type")
    status: int = Field(description="HTTP status")
    detail: str = Field(description="What happened, for people")
    errors: list[ProblemField] = Field(
        description=f"Fields that were refused, the first {SHOWN_MAX}; empty otherwise"
    )


def problem(
    kind: Kind,
    detail: str,
    *,
    errors: list[dict[str, Any]] | None = None,
    headers: dict[str, str] | None = None,
) -> JSONResponse:
    """Return a problem response.

    Parameters
    ----------
    kind : str
        Its type, one of `TYPES`.
    detail : str
        What happened, for people.
    errors : list of dict, optional
        Refused fields, each with the fields of `ProblemField`.
    headers : dict, optional
        Further headers; of a 429, ``Retry-After`` is added where it is missing.
    """
    status = TYPES[kind].status
    if status == HTTPStatus.TOO_MANY_REQUESTS:
        headers = {"Retry-After": str(RETRY_SECONDS), **(headers or {})}
    content = problem_document(kind, detail, errors or [])
    return JSONResponse(content, status, headers, MEDIA_TYPE)


def responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entries of the problems a route may answer with."""
    return {
        status: {
            "description": HTTPStatus(status).phrase,
            "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
            **({"headers": _RETRY_AFTER} if status == HTTPStatus.TOO_MANY_REQUESTS else {}),
        }
        for status in statuses
    }


def install(app: FastAPI) -> None:
    """Answer every failure of `app` with a problem document."""

    @app.exception_handler(MotionLabError)
    async def fail(_: Request, error: MotionLabError) -> JSONResponse:
        return problem(kind_of(error), str(error), errors=fields_of(error))

    @app.exception_handler(RequestValidationError)
    async def refuse_request(request: Request, error: RequestValidationError) -> JSONResponse:
        failures = error.errors()
        fields = [vars(_field(each)) for each in failures[:SHOWN_MAX]]
        if any(e["type"] == "json_invalid" for e in failures):
            return problem("invalid-body", "the body is not JSON")
        if isinstance(error.body, bytes):  # FastAPI has parsed it if it was declared as JSON
            return problem(
                "unsupported-media-type",
                f"a body of {request.headers.get('content-type', '')!r} cannot be read; "
                "send Content-Type: application/json",
            )
        detail = "the request is not of the documented form"
        if len(failures) > SHOWN_MAX:
            detail += f": {SHOWN_MAX} errors and {len(failures) - SHOWN_MAX} more"
        return problem("invalid-field", detail, errors=fields)

    @app.exception_handler(HTTPException)
    async def answer(request: Request, error: HTTPException) -> JSONResponse:
        headers = dict(error.headers) if error.headers else None
        kind = BY_STATUS.get(error.status_code, "internal-error")
        if kind not in {"not-found", "method-not-allowed"}:
            return problem(kind, str(error.detail), headers=headers)
        # The page's files are mounted at the root: they answer where no route has path and method.
        allowed = _methods(request)
        if allowed and request.method not in allowed:
            detail = f"{request.method} is not among {', '.join(allowed)}"
            headers = {"Allow": ", ".join(allowed)}
            return problem("method-not-allowed", detail, headers=headers)
        if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED:
            if request.url.path.startswith("/api/"):
                return problem("not-found", "Not Found")
            headers = {"Allow": "GET, HEAD"}
        return problem(kind, str(error.detail), headers=headers)

    @app.exception_handler(WrongState)
    async def refuse_state(_: Request, error: WrongState) -> JSONResponse:
        return problem("wrong-state", str(error))


def _field(item: dict[str, Any]) -> FieldError:
    """Return an error of a request's form; of a key, at the key itself."""
    steps = [str(step) for step in item["loc"] if step != "[key]"]
    message, allowed = in_words(item)
    return FieldError(
        loc=".".join(steps[1:]) or steps[0],
        message=message,
        value=item.get("input"),
        range=allowed,
        bounds=ends_of(item.get("ctx", {})),
    )


def _methods(request: Request) -> list[str]:
    """Return the methods that routes know at a request's path; a path without parameters wins."""
    known: dict[str, set[str]] = {}
    for route in iter_route_contexts(request.app.routes):
        path, methods = getattr(route, "path", None), getattr(route, "methods", None)
        if path and methods and compile_path(path)[0].match(request.url.path):
            known.setdefault(path, set()).update(methods)
    methods = known.get(request.url.path) or set().union(*known.values())
    return sorted(methods | {"HEAD"} if "GET" in methods else methods)
