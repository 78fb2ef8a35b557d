"""The table of docs/paper.md: ``python -m motionlab.paper.docs_table`` prints it."""

from __future__ import annotations

from motionlab.paper.documents import KINDS
from motionlab.paper.printed_number import PrintedNumber
from motionlab.paper.registry import GROUPS, quantities
from motionlab.paper.reproduce import number

_JUDGED = {
    "value": "equal",
    "at_most": "at most",
    "at_least": "at least",
    "within": "within",
    "none": "not comparable",
}

_KINDS = {kind.id: kind.title for kind in KINDS}


def table() -> str:
    """Return every row in Markdown, by group: printed value, judgement, band."""
    lines = []
    for group in GROUPS:
        lines += [f"### {group.title}", "", f"{group.about}. `{group.id}`", ""]
        lines += [
            "| row | place | quantity | printed | kind | judged | band |",
            "|---|---|---|---|---|---|---|",
        ]
        lines += [_line(row) for row in quantities([group.id])]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _line(row: PrintedNumber) -> str:
    band = "" if row.band is None else number(row.band, row.unit)
    cells = (f"`{row.id}`", row.place, row.quantity, row.printed, _KINDS[row.kind])
    return f"| {' | '.join((*cells, _JUDGED[row.comparison], band))} |"


if __name__ == "__main__":
    print(table(), end="")
