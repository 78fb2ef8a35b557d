"""A design as text for people: tables of printed beside corrected, with units and prefixes."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from pydantic import BaseModel

from motionlab.motor_design.document import DesignDocument, Reading
from motionlab.motor_design.inputs import Choices
from motionlab.reports.units import Scale, scale_for

_VALUE = 12
_WIDTH = 120


def report(document: DesignDocument) -> str:
    """Return both directions as tables, remarks numbered below each.

    Parameters
    ----------
    document : DesignDocument
        From `motionlab.motor_design.design.design`.

    Returns
    -------
    str
        Several lines.
    """
    lines = [document.title, *(f"  {note}" for note in document.notes), ""]
    lines += [f"From requirements to dimensions: {_choices(document.requirements)}"]
    lines += _table(_rows(document.sizing))
    lines += _warnings(document.sizing.warnings)
    if document.dimensions is None or document.rating is None:
        return "\n".join([*lines, "", "From dimensions to limits: no dimensions are known"])
    d = document.dimensions
    choices = f"{_choices(d)}, l_m = {_si(d.l_m, 'm')}, N = {d.N}"
    lines += ["", f"From dimensions to limits: {choices}"]
    lines += _table(_rows(document.rating))
    lines += _warnings(document.rating.warnings)
    return "\n".join(lines)


def _choices(c: Choices) -> str:
    p, s = c.teeth
    return (
        f"f_max = {_si(c.f_max, 'N')}, v_max = {_si(c.v_max, 'm/s')}, i = {_si(c.i, 'A')}, "
        f"tau = {_si(c.tau, 'm')},\n"
        f"  p = {_si(p, 'm')}, s = {_si(s, 'm')}, n = {c.n}, limbs = {c.limbs}, "
        f"g = {_si(c.g, 'm')}, B_g = {_si(c.B_g, 'T')}, lambda = {_si(c.lambda_, '1')}"
    )


def _rows(section: BaseModel) -> Iterable[Reading]:
    """Yield every reading of a section, those of its axes included."""
    for _, value in section:
        if isinstance(value, Reading):
            yield value
        elif isinstance(value, BaseModel):
            yield from _rows(value)


def _table(rows: Iterable[Reading]) -> list[str]:
    rows = [row for row in rows if (row.printed_value, row.value) != (None, None)]
    wide = max(len(row.quantity) for row in rows)
    head = f"  {'':{wide}}  {'eq.':10} {'printed':>{_VALUE}} {'corrected':>{_VALUE}}"
    lines, remarks = [f"{head}      formula used"], []
    for row in rows:
        mark = ""
        if row.remark:
            if row.remark not in remarks:
                remarks.append(row.remark)
            mark = f"[{remarks.index(row.remark) + 1}]"
        printed = _si(row.printed_value, row.unit)
        value = _si(row.value, row.unit)
        lines.append(
            f"  {row.quantity:{wide}}  {row.equation:10} {printed:>{_VALUE}} {value:>{_VALUE}} "
            f"{mark:4} {row.used_form}"
        )
    for k, remark in enumerate(remarks, start=1):
        lines += textwrap.wrap(
            remark, _WIDTH, initial_indent=f"  {f'[{k}]':5}", subsequent_indent=7 * " "
        )
    return lines


def _warnings(warnings: list[str]) -> list[str]:
    return [f"  warning: {warning}" for warning in warnings]


def _si(value: float | None, unit: str) -> str:
    """Return a value with an SI prefix where its unit takes one; a dash for none."""
    if value is None:
        return "-"
    if unit == "1":
        return f"{value:.4g}"
    if unit == "m^2":
        return f"{_digits(value * 1e6)} mm^2"
    value = float(f"{value:.2e}")  # so that 999.96 um is 1.00 mm
    scale = scale_for([value], unit, micro="u") if unit != "m/s" else Scale(1.0, unit)
    return f"{_digits(value / scale.size)} {scale.unit}"


def _digits(value: float) -> str:
    """Return three significant digits, or all of those before the point."""
    return f"{value:.0f}" if 100 <= abs(value) < 1e6 else f"{value:#.3g}"
