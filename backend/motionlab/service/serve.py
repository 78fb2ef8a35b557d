"""Serving the application with uvicorn."""

from __future__ import annotations

import ipaddress
import os
import socket
import sys

import uvicorn

from motionlab.errors import ConfigError, FieldError
from motionlab.service.app import create_app
from motionlab.service.settings import LOOPBACK, Settings

_TOKEN_MIN = 16
_SEND_BUFFER = 64 * 1024  # bytes: what a slow client can leave unread in the kernel


def serve(host: str, port: int, names: frozenset[str]) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        Port; 0 takes a free one.
    names : frozenset of str
        Further host names under which clients may reach the server.

    Raises
    ------
    ConfigError
        If another address than loopback has no token, or the address cannot be had.
    """
    token = os.environ.get("MOTIONLAB_TOKEN") or None
    if token is None and not _is_loopback(host):
        raise ConfigError(
            FieldError(
                loc="--host",
                message="is not loopback: set MOTIONLAB_TOKEN to what clients must present",
                value=host,
            )
        )
    if token is not None and len(token) < _TOKEN_MIN:
        raise ConfigError(
            FieldError("MOTIONLAB_TOKEN", "is too short", range=f">= {_TOKEN_MIN} characters")
        )
    listener = _listen(host, port)
    address, taken = listener.getsockname()[:2]
    own = {f"[{address}]" if ":" in address else address}
    settings = Settings(token=token, hosts=LOOPBACK | own | names)
    shown = f"[{address}]" if ":" in address else address
    print(f"Serving http://{shown}:{taken}/docs (Ctrl-C ends it)", file=sys.stderr, flush=True)
    config = uvicorn.Config(
        create_app(settings),
        log_level="warning",
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=5,
    )
    uvicorn.Server(config).run(sockets=[listener])


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _listen(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM
        )[0]
        listener = socket.socket(family, kind, protocol)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)  # inherited
        listener.bind(address)
        listener.listen(socket.SOMAXCONN)
    except OSError as error:
        raise ConfigError(
            FieldError("--host, --port", f"cannot be had: {error.strerror}", f"{host}:{port}")
        ) from None
    return listener
