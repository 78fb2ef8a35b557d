"""Options common to commands of several studies."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_scenario(parser: argparse.ArgumentParser, what: str = "") -> None:
    """Add the scenario, circle where none is given."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        nargs="?",
        default="circle",
        help=f"{what}path of a .toml file, or a shipped scenario (%(default)s)",
    )


def add_set(parser: argparse.ArgumentParser, what: str) -> None:
    """Add ``--set KEY=VALUE`` with the help text `what`."""
    parser.add_argument(
        "--set", dest="assignments", metavar="KEY=VALUE", action="append", default=[], help=what
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``."""
    parser.add_argument("--json", action="store_true", help="print one JSON document on stdout")


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Add ``--scheduler``."""
    parser.add_argument(
        "--scheduler",
        metavar="WHERE",
        help="where studies are computed: threads, processes[:N], tls://HOST:PORT or "
        "tcp://127.0.0.1:PORT, docs/cluster.md (MOTIONLAB_SCHEDULER, threads)",
    )


def source(options: argparse.Namespace) -> str | Path:
    """Return the scenario: a shipped one by name, or the path of a file."""
    name: str = options.scenario
    return Path(name) if name.endswith(".toml") else name


def given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return the options on the command line; omitted ones keep their defaults."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}
