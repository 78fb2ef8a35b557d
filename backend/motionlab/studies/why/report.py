"""An explained peak as text."""

from __future__ import annotations

import math

from motionlab.reports.tables import table
from motionlab.studies.why.document import Mend, WhyDocument


def report(found: WhyDocument) -> str:
    """Return causes by their share, and the change that mends the peak."""
    head = f"{found.scenario}, {found.variant} {found.axis}"
    lines = [
        f"{head}: {_um(found.peak)} um at {found.time:.4g} s",
        "",
        table(
            ("without", "um", "share of the peak"),
            [
                (
                    cause.label,
                    _um(cause.error),
                    "diverged" if cause.share is None else f"{100 * cause.share:.1f} %",
                )
                for cause in found.causes
            ],
            right={1, 2},
        ),
    ]
    if found.absent:
        lines += ["", "not there: " + ", ".join(cause.label for cause in found.absent)]
    lines += ["", f"goal {_um(found.goal)} um: {_mend(found.mend) or found.why_not}"]
    return "\n".join(lines + [f"note: {note}" for note in found.notes])


def _um(value: float | None) -> str:
    return "-" if value is None else f"{value * 1e6:.3g}"


def _mend(mend: Mend | None) -> str:
    if mend is None:
        return ""
    times = "" if mend.factor is None else f" times {mend.factor:.3g}"
    said = [f"{_um(mend.window_error)} um over the window"]
    if mend.gain_margin is not None:
        said.append(f"gain margin {20 * math.log10(mend.gain_margin):.3g} dB")
    if mend.phase_margin is not None:
        said.append(f"phase margin {math.degrees(mend.phase_margin):.3g} degrees")
    if mend.eased:
        said.append("no margin worse than now")
    options = " ".join(f"--set {path}={_toml(value)}" for path, value in mend.set.items())
    return f"{mend.label}{times}: {', '.join(said)}\n  {options}"


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
