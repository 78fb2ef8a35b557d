"""Errors as RFC 9457 problem documents, the same by REST and on the command line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

from motionlab.errors import (
    SHOWN_MAX,
    Busy,
    ConfigError,
    ExperimentFailed,
    FieldError,
    Infeasible,
    MotionLabError,
    NotReplayable,
    Shipped,
    StoreError,
    StoreFull,
    Unknown,
    shown,
)

PREFIX = "urn:motionlab:problem:"
"""What every ``type`` begins with; its name follows."""

Kind = Literal[
    "invalid-body",
    "invalid-host",
    "invalid-message",
    "token-needed",
    "foreign-request",
    "not-editable",
    "not-found",
    "method-not-allowed",
    "wrong-state",
    "shipped",
    "busy",
    "not-replayable",
    "lease-not-held",
    "drive-link",
    "body-too-large",
    "unsupported-media-type",
    "invalid-field",
    "infeasible-trajectory",
    "experiment-failed",
    "limit-reached",
    "internal-error",
    "unavailable",
    "no-room",
]


class ProblemType(NamedTuple):
    """One type of problem."""

    status: int
    title: str
    meaning: str


TYPES: dict[Kind, ProblemType] = {
    "invalid-body": ProblemType(400, "Invalid body", "no JSON, or a key twice in one table"),
    "invalid-host": ProblemType(400, "Invalid host", "not exactly one `Host` header"),
    "invalid-message": ProblemType(
        400, "Invalid message", "of a websocket's client; the stream goes on"
    ),
    "token-needed": ProblemType(401, "Token needed", "missing or wrong token"),
    "foreign-request": ProblemType(
        403, "Foreign request", "`Host` or `Origin` of another server, or a cross-site request"
    ),
    "not-editable": ProblemType(
        403, "Not editable", "the text of a law that this server does not change; `detail` says why"
    ),
    "not-found": ProblemType(404, "Not found", "unknown path, name or identifier"),
    "method-not-allowed": ProblemType(
        405, "Method not allowed", "`Allow` lists those that are supported"
    ),
    "wrong-state": ProblemType(409, "Wrong state", "not possible in the present state"),
    "shipped": ProblemType(
        409, "Shipped", "ships with the project and cannot be changed: take another name"
    ),
    "busy": ProblemType(409, "Busy", "a record is being written; repeat when it is done"),
    "not-replayable": ProblemType(
        409, "Not replayable", "the record of a run is not enough to simulate it again"
    ),
    "lease-not-held": ProblemType(409, "Lease not held", "take the lease of the drives first"),
    "drive-link": ProblemType(
        409, "Drive link", "the bus or a drive does not answer as it must; `GET /drive` tells more"
    ),
    "body-too-large": ProblemType(413, "Body too large", "more than `body_max` or `upload_max`"),
    "unsupported-media-type": ProblemType(
        415, "Unsupported media type", "body not declared as JSON"
    ),
    "invalid-field": ProblemType(
        422,
        "Invalid field",
        "`errors` names the first 20 fields with value, range and unit; `detail` counts the others",
    ),
    "infeasible-trajectory": ProblemType(
        422, "Infeasible trajectory", "a motion that the motor cannot follow; `errors` says where"
    ),
    "experiment-failed": ProblemType(
        422, "Experiment failed", "its data do not tell what was asked for; `detail` says why"
    ),
    "limit-reached": ProblemType(
        429,
        "Limit reached",
        "a [limit](#limits) on running, waiting or live work; repeat after `Retry-After` seconds",
    ),
    "internal-error": ProblemType(500, "Internal error", "a fault of the server, whose log has it"),
    "unavailable": ProblemType(
        503,
        "Unavailable",
        "timeout, or a process or store that failed; `Retry-After` where repeating helps",
    ),
    "no-room": ProblemType(
        507, "No room", "on the disk, or within the quota of [runs](runs.md#quota)"
    ),
}

BY_STATUS: dict[int, Kind] = {
    400: "invalid-body",
    401: "token-needed",
    403: "foreign-request",
    404: "not-found",
    405: "method-not-allowed",
    409: "wrong-state",
    413: "body-too-large",
    415: "unsupported-media-type",
    422: "invalid-field",
    429: "limit-reached",
    500: "internal-error",
    503: "unavailable",
    507: "no-room",
}
"""The type of a failure of which no more is known than its status."""

_KINDS: dict[type[MotionLabError], Kind] = {
    ConfigError: "invalid-field",
    Infeasible: "infeasible-trajectory",
    ExperimentFailed: "experiment-failed",
    StoreFull: "no-room",
    Unknown: "not-found",
    Busy: "busy",
    NotReplayable: "not-replayable",
    Shipped: "shipped",
    StoreError: "unavailable",  # any other one
}
"""Types of failures, the first that fits."""


def kind_of(error: MotionLabError) -> Kind:
    """Return the type of an error."""
    named = getattr(error, "kind", "")  # by a server that has refused
    if named in TYPES:
        return named
    for failure, kind in _KINDS.items():
        if isinstance(error, failure):
            return kind
    return "internal-error"


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
    return problem_document(kind_of(error), str(error), fields_of(error))


def problem_document(
    kind: Kind, detail: str, errors: Sequence[dict[str, Any]] = ()
) -> dict[str, Any]:
    """Return a problem document, bounded in size.

    Parameters
    ----------
    kind : str
        Its type, one of `TYPES`.
    detail : str
        What happened, for people.
    errors : sequence of dict
        Refused fields, each with the attributes of a `FieldError`; the first `SHOWN_MAX` are kept.
    """
    status, title, _ = TYPES[kind]
    return {
        "type": PREFIX + kind,
        "title": title,
        "status": status,
        "detail": plain(detail),
        "errors": [
            plain({**_unplaced(each), "loc": shown(each["loc"]), "value": shown(each["value"])})
            for each in errors[:SHOWN_MAX]
        ],
    }


def _unplaced(field: dict[str, Any]) -> dict[str, Any]:
    """Return the attributes of an error but its file, which the detail names."""
    return {name: value for name, value in field.items() if name != "place"}


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
