"""The commands ``motionlab serve`` and ``motionlab openapi``."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from motionlab.errors import DONE
from motionlab.studies.options import add_scheduler

_PORT_MAX = 65_535
_LEVELS = ("debug", "info", "warning", "error", "critical")
_OPTIONS = (
    "host",
    "port",
    "hosts",
    "token_file",
    "edit_laws",
    "drive",
    "scheduler",
    "data",
    "log_level",
)


def add(commands: Any) -> None:
    """Add ``motionlab serve`` and ``motionlab openapi``."""
    parser = commands.add_parser(
        "serve",
        help="serve the lab: page, API and their documentation",
        description="Serve the lab: the page at /, the API below /api/v1, its documentation at "
        "/docs. Another host than loopback needs a token, in MOTIONLAB_TOKEN or a file.",
        epilog="A setting is an option, a variable or a key of the file of settings, in this order "
        "of precedence: docs/deploy.md lists them, --show-settings prints those in effect.",
    )
    parser.add_argument("--host", help="address to listen on (127.0.0.1)")
    parser.add_argument("--port", type=_port, help="port (8000)")
    parser.add_argument(
        "--name",
        dest="hosts",
        metavar="HOST",
        action="append",
        help="further name under which clients reach this server (repeatable; MOTIONLAB_HOSTS "
        "takes several, comma between them)",
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument("--token-file", metavar="FILE", help="what clients must present")
    parser.add_argument(
        "--edit-laws",
        action="store_const",
        const=True,
        help="let the page change files of --laws, which is code that runs here: on loopback only, "
        "and with a token; docs/own-law.md",
    )
    parser.add_argument(
        "--data", metavar="FOLDER", help="runs, trajectories, jobs and force maps (MOTIONLAB_DATA)"
    )
    parser.add_argument(
        "--drive",
        metavar="FILE",
        help="link to drives, as configs/drives/virtual.toml, or virtual for that one "
        "(MOTIONLAB_DRIVE); docs/drive.md",
    )
    add_scheduler(parser)
    parser.add_argument(
        "--log-level",
        choices=_LEVELS,
        help="least level of what is logged (warning); info: also "
        "one line of JSON on stdout for each request",
    )
    parser.add_argument("--settings", metavar="FILE", help="TOML file (MOTIONLAB_SETTINGS)")
    parser.add_argument(
        "--show-settings", action="store_true", help="print all settings in effect, and end"
    )
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
    from motionlab.reports.tables import table
    from motionlab.server.settings_sources import load

    loaded = load({name: getattr(options, name) for name in _OPTIONS}, options.settings)
    if options.show_settings:
        for warning in loaded.warnings:
            print(f"motionlab: {warning}", file=sys.stderr)
        print(table(("setting", "value", "from", "unit", "range"), loaded.rows()))
        return DONE

    from motionlab.own_laws.accepted import accept_files

    for problem in accept_files(loaded.settings.laws or ""):  # before anything that imports laws
        print(f"motionlab: law not taken: {problem}", file=sys.stderr)
    from motionlab.studies.own_check import accept_studies

    for problem in accept_studies(loaded.settings.studies or ""):
        print(f"motionlab: study or view not taken: {problem}", file=sys.stderr)
    from motionlab.server.serve import serve

    serve(loaded, opens=options.open)
    return DONE


def _openapi(_: argparse.Namespace) -> int:
    """Carry out ``motionlab openapi``."""
    from motionlab.server.app import create_app

    print(json.dumps(create_app().openapi(), indent=2))
    return DONE
