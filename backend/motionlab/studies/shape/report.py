"""What is proposed on a measured response, as text."""

from __future__ import annotations

from motionlab.reports.tables import table
from motionlab.studies.response.report import margin_rows
from motionlab.studies.shape.documents import ShapeDocument

_UNITS = {"k_p": ("N/mm", 1e-3), "k_d": ("N s/mm", 1e-3), "bandwidth": ("Hz", 1.0)}


def report(result: ShapeDocument) -> str:
    """Return resonances, proposal with reasons, margins, the check and the changes."""
    response = result.response
    lines = [
        f"{response.variant} {response.axis}, on "
        + (f"run {response.run}" if response.run else f"{response.slides} slides")
        + f", sliding at {1e3 * response.velocity:.3g} mm/s",
        *(f"note: {each}" for each in [*response.warnings, *result.notes]),
        "",
    ]
    for each in result.resonances:
        lines.append(
            f"resonance at {each.frequency:.4g} Hz: {each.height:.3g} dB, at least "
            f"{each.least:.3g} dB"
        )
    if not result.resonances:
        lines.append("no resonance stands out of its neighbourhood by 3 dB with certainty")
    lines.append("")
    rows = []
    for name, before in result.before.items():
        unit, factor = _UNITS[name]
        rows.append(
            [f"{name}, {unit}", f"{factor * before:.4g}", f"{factor * result.after[name]:.4g}"]
        )
    lines += [table(("", "before", "proposed"), rows, right=(1, 2)), ""]
    for added in result.filters:
        values = ", ".join(f"{key} {value:.4g}" for key, value in added.values.items())
        lines.append(f"{added.kind} at {added.place}: {values}")
        lines.append(f"  {added.reason}; {added.gain:.2g} dB stiffer with it")
    if result.filters:
        lines.append("")
    heads = ("open loop", "proposed", "95 %", "before")
    lines += [table(heads, margin_rows(result.margins), right=(1, 2, 3)), ""]
    stiffer = 10.0 ** (-result.compliance / 20.0)
    lines.append(f"compliance {result.compliance:+.2f} dB: {stiffer:.3g} times as stiff")
    check = result.check
    if check is not None:
        heads = ("second measurement", "measured", "95 %", "proposed")
        if check.margins:
            lines += ["", table(heads, margin_rows(check.margins), right=(1, 2, 3))]
        lines += ["", check.text]
    elif result.changes:
        lines.append("not checked: record a second run with these values, and name it --second-run")
    if result.changes:
        lines += ["", *(f"--set {path}={value:.6g}" for path, value in result.changes.items())]
    return "\n".join(lines)
