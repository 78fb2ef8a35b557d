"""The types of problems: what a client can rely on, whatever the words of the detail are."""

from __future__ import annotations

from typing import Literal, NamedTuple

PREFIX = "urn:motionlab:problem:"
"""What every ``type`` begins with; its name follows."""

Kind = Literal[
    "invalid-body",
    "invalid-host",
    "invalid-message",
    "token-needed",
    "foreign-request",
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
    "limit-reached",
    "internal-error",
    "unavailable",
    "no-room",
]


class ProblemType(NamedTuple):
    """One type of problem.

    Attributes
    ----------
    status : int
        HTTP status.
    title : str
        The same for every problem of the type.
    meaning : str
        What has happened, and what helps.
    """

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
