"""Tables for people: plain text in a pipe, fitted to the columns of a terminal without loss."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Collection, Iterable, Sequence

from motionlab.reports.plain_text import without_controls

_MICRO = re.compile(r"(?<![\w-])u(?=m\b|s\b)")
_WORDS = re.compile(r"\s*\S+")  # each with the blanks before it
_GAP = "  "
_BOLD, _PLAIN = "\x1b[1m", "\x1b[0m"
_LINES_MAX = 6  # of a row; a table whose rows would be higher is written as blocks


def on_terminal() -> bool:
    """Return whether stdout is a terminal that can fit and mark text."""
    return sys.stdout.isatty() and os.environ.get("TERM") not in {"dumb", "unknown"}


def table(
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    right: Collection[int] = (),
    units: Sequence[str] = (),
) -> str:
    """Return a table: two spaces between columns.

    On a terminal that is too narrow, cells are wrapped between words, and where even the longest
    words do not fit beside each other, each row becomes a block of ``head  value`` lines.

    Parameters
    ----------
    heads : sequence of str
        Heads of the columns; without one, there is no line of them.
    rows : iterable of sequences of str
        The cells.
    right : collection of int
        Columns that are aligned to the right, as numbers are.
    units : sequence of str
        Units of the columns, in a line of their own below the heads.
    """
    heads = [without_controls(head) for head in heads]
    rows = [[without_controls(cell) for cell in row] for row in rows]
    lines = [*([list(heads)] if any(heads) else []), *([list(units)] if units else []), *rows]
    if not lines:
        return ""
    gap, widths = _GAP, [max(map(_cells, column)) for column in zip(*lines, strict=True)]
    if on_terminal():
        columns, gaps = shutil.get_terminal_size().columns, len(heads) - 1
        if sum(widths) + len(_GAP) * gaps > columns:
            for gap in (_GAP, " "):
                fitted = _fitted(lines, widths, columns - len(gap) * gaps)
                if fitted is not None:
                    break
            else:
                return _blocks(heads, rows, units)
            widths = fitted
    text = [line for row in lines for line in _row(row, widths, right, gap)]
    if on_terminal() and any(heads) and not os.environ.get("NO_COLOR"):
        height = len(_row(lines[0], widths, right, gap))
        text[:height] = [f"{_BOLD}{line}{_PLAIN}" for line in text[:height]]
    return "\n".join(text)


def _fitted(lines: list[list[str]], widths: list[int], available: int) -> list[int] | None:
    """Return widths that fit, no word broken; None where there are none, or rows grow too high."""
    least = [
        max((_cells(word) for cell in column for word in cell.split()), default=0)
        for column in zip(*lines, strict=True)
    ]
    # An indented first column keeps its indent.
    least[0] = max((_cells(line[0]) for line in lines if line[0][:1] == " "), default=least[0])
    if sum(least) > available:
        return None
    # The widest columns give first: columns of words rather than those of numbers.
    fitted = list(widths)
    while sum(fitted) > available:
        shrinkable = [i for i, width in enumerate(fitted) if width > least[i]]
        widest = max(shrinkable, key=lambda i: fitted[i])
        fitted[widest] -= 1
    height = max(
        len(_wrap(cell, width)) for row in lines for cell, width in zip(row, fitted, strict=True)
    )
    return fitted if height <= _LINES_MAX else None


def _row(row: Sequence[str], widths: Sequence[int], right: Collection[int], gap: str) -> list[str]:
    """Return a row as lines, its cells wrapped between words."""
    cells = [
        [cell] if _cells(cell) <= width else _wrap(cell, width)
        for cell, width in zip(row, widths, strict=True)
    ]
    height = max((len(cell) for cell in cells), default=1)
    return [
        gap.join(
            blanks + text if index in right else text + blanks
            for index, (cell, width) in enumerate(zip(cells, widths, strict=True))
            for text in ([*cell, *[""] * height][line],)
            for blanks in (" " * (width - _cells(text)),)
        ).rstrip()
        for line in range(max(height, 1))
    ]


def _blocks(heads: Sequence[str], rows: list[list[str]], units: Sequence[str]) -> str:
    """Return each row as its first cell, and below it a line for each of the others."""
    width = max(map(len, heads[1:]), default=0)
    lines = []
    for row in rows:
        lines.append(row[0])
        indent = " " * (len(row[0]) - len(row[0].lstrip()))
        for head, cell, unit in zip(heads[1:], row[1:], units[1:] or [""] * len(row), strict=False):
            if cell:
                lines.append(f"{indent}  {head.ljust(width)}  {cell} {unit}".rstrip())
    columns = shutil.get_terminal_size().columns
    return "\n".join(_wrapped(line, columns, 4 + width) for line in lines)


def fitted(text: str) -> str:
    """Return text whose lines a terminal need not break within a word or a number."""
    if not on_terminal():
        return text
    columns = shutil.get_terminal_size().columns
    return "\n".join(_wrapped(line, columns) for line in text.splitlines())


def _wrapped(line: str, columns: int, indent: int | None = None) -> str:
    """Return a line broken between words, its further lines indented."""
    if _cells(line) <= columns or "\x1b" in line:
        return line
    start = len(line) - len(line.lstrip())
    further = min(start + 4 if indent is None else indent, columns // 2)
    return "\n".join(_wrap(line, columns, " " * further))


def _wrap(text: str, columns: int, indent: str = "") -> list[str]:
    """Return text in lines; a word that is longer than a line has one of its own."""
    lines = [""]
    for piece in _WORDS.findall(text):
        if lines[-1] and _cells(lines[-1] + piece) > columns:
            lines.append(indent + piece.lstrip())
        else:
            lines[-1] += piece
    return lines


def _cells(text: str) -> int:
    """Return how many columns of a terminal text takes: Chinese letters take two, accents none."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def in_letters(text: str) -> str:
    """Return text with µm and µs where it is for a terminal that has the letter."""
    encoding = (getattr(sys.stdout, "encoding", None) or "").lower().replace("-", "")
    return _MICRO.sub("µ", text) if on_terminal() and encoding == "utf8" else text
