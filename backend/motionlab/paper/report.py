"""The paper's numbers and ours as text."""

from __future__ import annotations

import math
import textwrap

from motionlab.paper.document import Erratum, JudgedRow, Number, ReproduceDocument
from motionlab.paper.evidence import KINDS

_PREFIXES = {-9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M"}
_PREFIXED = {"m": range(-9, 1), "s": range(-9, 1), "A/m": range(7), "W": range(7), "Hz": range(7)}
_WORDS = {
    "holds": ("holds", "32"),
    "fails": ("FAILS", "31;1"),
    "known_failure": ("known failure", "31"),
    "not_comparable": ("not comparable", "2"),
}
_TITLES = {kind.id: kind.title for kind in KINDS}
_KIND = max(map(len, _TITLES.values()))
_WIDE = 56
_WIDTH = 120


def report(document: ReproduceDocument, *, colour: bool = False) -> str:
    """Return tables of printed numbers and ours, group by group, then errata and the count.

    Parameters
    ----------
    document : ReproduceDocument
        From `motionlab.paper.reproduce.reproduce`.
    colour : bool
        Whether the words of the last column are coloured too, for a terminal.

    Returns
    -------
    str
        Several lines.
    """
    lines = []
    for group in document.groups:
        lines += [f"{group.title} ({group.about})"]
        lines += [_line(row, colour) for row in document.rows if row.group == group.id]
        lines.append("")
    for row in document.rows:
        if row.status in {"fails", "known_failure"} or (row.holds and row.known):
            lines += _explained(row)
    if conflicts := [row for row in document.rows if row.conflict]:
        lines += ["", "Printed values in conflict with each other"]
        lines += [f"  {row.id}: {row.conflict}" for row in conflicts]
    if lax := [row for row in document.rows if row.lax]:
        lines += ["", "Lax: these rows would hold with nearly any model"]
        lines += [f"  {row.id}: lax: {row.lax}" for row in lax]
    if document.errata:
        lines += ["", "Errata"]
        for erratum in document.errata:
            lines += _erratum(erratum)
    return "\n".join([*lines, "", *_summary(document)])


def _summary(document: ReproduceDocument) -> list[str]:
    """Return a line on all rows and one on each kind of them."""
    s = document.summary
    total = (
        f"{s.holds} hold ({s.better} better than a bound asks for, {s.lax} lax), {s.fails} fail, "
        f"{s.known_failure} known failures, {s.not_comparable} not comparable; of these"
    )
    lines = [total]
    for kind in document.kinds:
        if count := s.kinds.get(kind.id):
            words = (
                (count.holds, "hold"),
                (count.lax, "of them lax"),
                (count.fails, "fail"),
                (count.known_failure, "known failures"),
                (count.not_comparable, "not comparable"),
            )
            counted = ", ".join(f"{n} {word}" for n, word in words if n)
            lines.append(f"  {kind.title:{_KIND}}  {counted:40}  {kind.about}")
    return lines


def _line(row: JudgedRow, colour: bool) -> str:
    word, code = _WORDS[row.status]
    word += ", better" * bool(row.better) + ", lax" * bool(row.lax)
    if colour:
        word = f"\x1b[{code}m{word}\x1b[0m"
    band = "" if row.band is None else f"+-{number(row.band, row.unit)}"
    quantity = row.quantity if len(row.quantity) <= _WIDE else row.quantity[: _WIDE - 1] + "…"
    paper = row.printed if row.paper is None else number(row.paper, row.unit)
    ours = number(row.ours, row.unit)
    state = f"{_TITLES[row.kind]:{_KIND}}  {word}"
    return f"  {row.id:26} {quantity:{_WIDE}} {paper:>20} {ours:>20} {band:>12}  {state}"


def _explained(row: JudgedRow) -> list[str]:
    head = f"{row.id}: {number(row.paper, row.unit)} printed, {number(row.ours, row.unit)} ours"
    why = row.error or row.known or row.reason
    if row.holds:
        why = "known_failures.toml lists it, but it holds now: remove it from that file"
    return textwrap.wrap(f"{head}. {why}", _WIDTH, subsequent_indent="    ")


def _erratum(erratum: Erratum) -> list[str]:
    scanned = " (as scanned)" if erratum.as_scanned else ""
    lines = textwrap.wrap(
        f"{erratum.place}{scanned}: {erratum.printed}",
        _WIDTH,
        initial_indent="  ",
        subsequent_indent="      ",
    )
    lines += textwrap.wrap(
        f"corrected: {erratum.corrected}",
        _WIDTH,
        initial_indent="    ",
        subsequent_indent="      ",
    )
    return lines + [f"      {step.what}: {number(step.value, step.unit)}" for step in erratum.steps]


def number(value: Number | None, unit: str) -> str:
    """Return a number, or both ends of a range, with an SI prefix where its unit takes one."""
    if value is None:
        return "-"
    ends = value if isinstance(value, tuple) else (value,)
    exponent = _exponent(max(abs(end) for end in ends), unit)
    digits = " to ".join(f"{end / 10**exponent:.4g}" for end in ends)
    return f"{digits} {_PREFIXES[exponent]}{unit if unit != '1' else ''}".rstrip()


def _exponent(size: float, unit: str) -> int:
    size = float(f"{size:.3e}")
    if size == 0.0 or unit not in _PREFIXED:
        return 0
    third = 3 * math.floor(math.log10(size) / 3)
    allowed = [e for e in _PREFIXES if e in _PREFIXED[unit]]
    return min(max(third, allowed[0]), allowed[-1])
