"""Options common to commands of several studies."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.config.bounds import FILE_MAX
from motionlab.config.named_configs import names, parse_text
from motionlab.errors import ConfigError, FieldError

if TYPE_CHECKING:
    from pydantic import BaseModel


def add_scenario(parser: argparse.ArgumentParser, what: str = "", *, shipped: str = "") -> None:
    """Add the scenario, circle where none is given."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        nargs="?",
        default="circle",
        help=f"{what}path of a .toml file, - for stdin, or a shipped scenario"
        f"{f': {shipped}' if shipped else ''} (default: %(default)s)",
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
        "tcp://127.0.0.1:PORT, `motionlab docs cluster` (default: MOTIONLAB_SCHEDULER, or "
        "else threads)",
    )


def add_fields(parser: Any, model: type[BaseModel], known: set[str]) -> None:
    """Add an option for each number, text and choice of a model whose name is not known yet.

    Parameters
    ----------
    parser : ArgumentParser or its group
        That gets the options.
    model : type
        Whose fields they are.
    known : set of str
        Names that are left out; those of the added options go in.
    """
    from motionlab.config.fields import fields_of
    from motionlab.config.validation_errors import members

    for name, field in fields_of(model).items():
        if name in known or name not in model.model_fields:
            continue
        kinds = members(model.model_fields[name].annotation)
        known.add(name)
        default = "" if field.default is None else f", default {field.default}"
        text = f"{field.description}{default}".replace("%", "%%")
        add = partial(parser.add_argument, f"--{name.replace('_', '-')}", dest=name, help=text)
        if field.choices:
            add(choices=[choice.value for choice in field.choices])
        elif field.whole:
            add(metavar="N", type=int)
        elif float in kinds:
            add(metavar=field.unit.upper() or "X", type=float)
        elif str in kinds:
            add(metavar="TEXT")


def source(options: argparse.Namespace) -> str | Path | dict[str, Any]:
    """Return the scenario: a shipped one by name, the path of a file, or tables from stdin.

    Raises
    ------
    ConfigError
        If stdin is closed or holds no TOML, or a file is named without its ending.
    """
    name: str = options.scenario
    if name == "-":
        if sys.stdin is None:  # pyright: ignore[reportUnnecessaryComparison]
            raise ConfigError(FieldError("stdin", "is closed"))
        return parse_text(sys.stdin.buffer.read(FILE_MAX + 1), loc="stdin", size_max=FILE_MAX)
    if name.endswith(".toml") or ("/" in name and Path(name).is_file()):
        return Path(name)
    if name not in names("scenarios") and Path(f"{name}.toml").is_file():
        message = f"no shipped scenario of that name, did you mean the file '{name}.toml'?"
        raise ConfigError(FieldError("scenario", message, name))
    return name


def set_options(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return the options on the command line; omitted ones keep their defaults."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}
