"""Tables for people: plain text in a pipe, fitted to a terminal by rich."""

from __future__ import annotations

import io
import os
import re
import shutil
import sys
from collections.abc import Collection, Iterable, Sequence

_MICRO = re.compile(r"(?<![\w-])u(?=m\b|s\b)")


def on_terminal() -> bool:
    """Return whether stdout is a terminal that can fit and mark text."""
    return sys.stdout.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}


def table(
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    right: Collection[int] = (),
) -> str:
    """Return a table: two spaces between columns; on a terminal, the last column is wrapped.

    Parameters
    ----------
    heads : sequence of str
        Heads of the columns; without one, there is no line of them.
    rows : iterable of sequences of str
        The cells.
    right : collection of int
        Columns that are aligned to the right, as numbers are.
    """
    rows = [list(row) for row in rows]
    if on_terminal():
        return _fitted(heads, rows, right)
    lines = [list(heads), *rows] if any(heads) else rows
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(
            cell.rjust(width) if index in right else cell.ljust(width)
            for index, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def _fitted(heads: Sequence[str], rows: list[list[str]], right: Collection[int]) -> str:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    style = "" if os.environ.get("NO_COLOR") else "bold"
    found = Table(box=None, pad_edge=False, show_header=any(heads), header_style=style)
    for index, head in enumerate(heads):
        found.add_column(
            head,
            justify="right" if index in right else "left",
            no_wrap=index < len(heads) - 1,
            overflow="fold",
        )
    for row in rows:
        found.add_row(*map(Text, row))
    width = shutil.get_terminal_size().columns
    console = Console(file=io.StringIO(), force_terminal=True, width=width, highlight=False)
    with console.capture() as captured:
        console.print(found)
    lines = captured.get().splitlines()
    return "\n".join(line.rstrip() for line in lines)


def in_letters(text: str) -> str:
    """Return text with µm and µs where it is for a terminal that has the letter."""
    encoding = (getattr(sys.stdout, "encoding", None) or "").lower().replace("-", "")
    return _MICRO.sub("µ", text) if on_terminal() and encoding == "utf8" else text
