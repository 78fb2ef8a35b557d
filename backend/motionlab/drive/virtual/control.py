"""Switches and status of a virtual drive that runs, by a line of JSON over UDP on loopback."""

from __future__ import annotations

import json
import socket
from typing import Any

from motionlab.errors import ConfigError, FieldError, MotionLabError

LOOPBACK = "127.0.0.1"


class DriveFailed(MotionLabError):
    """A virtual drive that could not be started or reached."""


def ask(port: int, document: dict[str, Any], timeout: float = 2.0) -> dict[str, Any]:
    """Send switches, or nothing, to a running virtual drive and return its status.

    Raises
    ------
    DriveFailed
        If none answers.
    ConfigError
        If it refuses.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(timeout)
        asking.connect((LOOPBACK, port))
        try:
            asking.send(json.dumps(document).encode())
            reply = json.loads(asking.recv(65_536))
        except (OSError, ValueError):
            raise DriveFailed(f"no virtual drive answers at UDP port {port}") from None
    if "error" in reply:
        raise ConfigError(FieldError("switches", reply["error"]))
    return reply
