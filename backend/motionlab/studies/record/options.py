"""Options of commands that read a kept run: its part and its columns, under one set of names."""

from __future__ import annotations

from typing import Any


def add_part(parser: Any) -> None:
    """Add the part of a run that is read."""
    for flags, dest, text in (
        (("--from", "--start"), "start", "part of the run that is read, from, s (default: 0)"),
        (("--to", "--end"), "end", "until, s (default: its end)"),
    ):
        parser.add_argument(*flags, dest=dest, metavar="S", type=float, help=text)


_COLUMNS = {
    "position": "of the position (default: position_measured)",
    "force": "of the force (default: the first there is of force_realised, force_command, thrust)",
    "normal_force": "of the normal force (default: known)",
    "excitation": "of what excited the loop (default: the reference)",
}


def add_columns(parser: Any, **fields: str) -> None:
    """Add options that name columns.

    Parameters
    ----------
    parser : ArgumentParser or its group
        That gets the options.
    **fields : str
        Field of the request by kind: ``position``, ``force``, ``normal_force``, ``excitation``.
    """
    for kind, field in fields.items():
        flag, help_text = f"--{kind.replace('_', '-')}-column", f"column {_COLUMNS[kind]}"
        parser.add_argument(flag, dest=field, metavar="COLUMN", help=help_text)
