"""The table of measured figures, printed row by row as they come."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass

_WIDTHS = (46, 15, 15, 21, 8, 4)


@dataclass(frozen=True)
class Row:
    """One measured figure.

    Attributes
    ----------
    what : str
        What was measured.
    target : str
        What it should be.
    measured, reference, ratio : str
        The figure, what it is compared with in the same run, and their ratio.
    met : bool or None
        Whether the target is met; None where there is none, or nothing to compare with.
    """

    what: str
    target: str
    measured: str
    reference: str = ""
    ratio: str = ""
    met: bool | None = None


class Table:
    """Prints rows, and remembers whether everything could be run."""

    def __init__(self) -> None:
        self.complete = True
        self.missed = 0
        _print_line("what", "target", "measured", "reference", "ratio", "met")
        _print_line(*("-" * width for width in _WIDTHS))

    def add(self, title: str, measure: Callable[[], Iterable[Row]]) -> None:
        """Print the rows of one measurement; one that fails does not stop the others."""
        try:
            for row in measure():
                met = {True: "yes", False: "NO", None: ""}[row.met]
                self.missed += row.met is False
                _print_line(row.what, row.target, row.measured, row.reference, row.ratio, met)
        except Exception:
            self.complete = False
            print(f"{title}: failed to run")
            traceback.print_exc()


def _print_line(*cells: str) -> None:
    padded = (cell.ljust(width) for cell, width in zip(cells, _WIDTHS, strict=True))
    print("  ".join(padded).rstrip(), flush=True)
