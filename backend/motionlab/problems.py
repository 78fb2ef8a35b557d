"""Errors as RFC 9457 problem documents, the same by REST and on the command line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

from motionlab.errors import (
    SHOWN_MAX,
    Busy,
    ConfigError,
    FieldError,
    Infeasible,
    MotionLabError,
    NotReplayable,
    StoreError,
    StoreFull,
    Unknown,
    shown,
)

_OF_STORES = {
    StoreFull: HTTPStatus.INSUFFICIENT_STORAGE,
    Unknown: HTTPStatus.NOT_FOUND,
    Busy: HTTPStatus.CONFLICT,
    NotReplayable: HTTPStatus.CONFLICT,
}


def status_of(error: MotionLabError) -> HTTPStatus:
    """Return the HTTP status of an error."""
    if isinstance(error, ConfigError | Infeasible):
        return HTTPStatus.UNPROCESSABLE_ENTITY
    if isinstance(error, StoreError):
        return _OF_STORES.get(type(error), HTTPStatus.SERVICE_UNAVAILABLE)
    return HTTPStatus.INTERNAL_SERVER_ERROR


def fields_of(error: MotionLabError) -> list[dict[str, Any]]:
    """Return the fields that an error refuses, each with the attributes of a `FieldError`."""
    if isinstance(error, ConfigError):
        return [vars(field) for field in error.errors]
    if not isinstance(error, Infeasible):
        return []
    field = FieldError(
        loc="trajectory",
        message=f"{error.quantity} on {error.axis} at t = {error.time:.4f} s, "
        f"x = {error.place[0]:.6g} m, y = {error.place[1]:.6g} m",
        value=error.value,
        unit=error.unit,
        bounds={"minimum": error.limit[0], "maximum": error.limit[1]},
    )
    return [vars(field)]


def problem_of(error: MotionLabError) -> dict[str, Any]:
    """Return the problem document of an error."""
    return problem_document(status_of(error), str(error), fields_of(error))


def problem_document(
    status: int, detail: str, errors: Sequence[dict[str, Any]] = ()
) -> dict[str, Any]:
    """Return a problem document, bounded in size.

    Parameters
    ----------
    status : int
        HTTP status.
    detail : str
        What happened, for people.
    errors : sequence of dict
        Refused fields, each with the attributes of a `FieldError`; the first `SHOWN_MAX` are kept.
    """
    return {
        "type": "about:blank",
        "title": HTTPStatus(status).phrase,
        "status": int(status),
        "detail": plain(detail),
        "errors": [
            plain({**each, "loc": shown(each["loc"]), "value": shown(each["value"])})
            for each in errors[:SHOWN_MAX]
        ],
    }


def plain(value: Any) -> Any:
    """Return a value that JSON can hold: non-finite numbers as text, anything odd as its repr.

    Half of a surrogate pair, which JSON can spell and UTF-8 cannot, comes back as its escape.
    """
    match value:
        case float() if not math.isfinite(value):
            return str(value)
        case str():
            return value.encode("utf-8", "backslashreplace").decode()
        case None | bool() | int() | float():
            return value
        case dict():
            return {plain(str(key)): plain(item) for key, item in value.items()}
        case list() | tuple():
            return [plain(item) for item in value]
        case _:
            return repr(value)
