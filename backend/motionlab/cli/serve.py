"""The commands ``motionlab serve`` and ``motionlab openapi``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.studies.options import add_scheduler

_PORT_MAX = 65_535


def add(commands: Any) -> None:
    """Add ``motionlab serve`` and ``motionlab openapi``."""
    parser = commands.add_parser(
        "serve",
        help="serve the REST API",
        description="Serve the REST API; /docs describes it. Another host than loopback needs a "
        "token in MOTIONLAB_TOKEN.",
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (%(default)s)")
    parser.add_argument("--port", type=_port, default=8000, help="port (%(default)s)")
    parser.add_argument(
        "--name",
        dest="host_names",
        metavar="HOST",
        action="append",
        default=[],
        help="further name under which clients reach this server (repeatable; MOTIONLAB_HOSTS "
        "takes several, comma between them)",
    )
    parser.add_argument(
        "--drive",
        metavar="FILE",
        help="link to drives, as configs/drives/virtual.toml, or virtual for that one "
        "(MOTIONLAB_DRIVE); docs/drive.md",
    )
    add_scheduler(parser)
    parser.set_defaults(command=_serve)
    parser = commands.add_parser(
        "openapi", help="print the OpenAPI document", description="Print the OpenAPI document."
    )
    parser.set_defaults(command=_openapi)


def _port(text: str) -> int:
    port = int(text) if text.isdecimal() else -1
    if not 0 <= port <= _PORT_MAX:
        raise argparse.ArgumentTypeError(f"{text!r} is no port; allowed 0 to {_PORT_MAX}")
    return port


def _serve(options: argparse.Namespace) -> int:
    """Carry out ``motionlab serve``."""
    from motionlab.service.serve import serve

    serve(
        options.host,
        options.port,
        frozenset(options.host_names),
        options.scheduler,
        drive=options.drive,
    )
    return DONE


def _openapi(_: argparse.Namespace) -> int:
    """Carry out ``motionlab openapi``."""
    from motionlab.service.app import create_app

    print(json.dumps(create_app().openapi(), indent=2))
    return DONE
