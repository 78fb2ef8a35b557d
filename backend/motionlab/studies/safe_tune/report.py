"""Motions made on a machine and the next one, as text."""

from __future__ import annotations

import math

from motionlab.reports.tables import table
from motionlab.studies.safe_tune.documents import LeastMargins, NextMotion, SafeTuneDocument


def report(result: SafeTuneDocument) -> str:
    """Return the motions, the limits, what is proposed or why not, and the best gains."""
    error = "none yet" if result.error is None else f"{1e6 * result.error:.4g} um"
    lines = [f"limits: error {error}, force {result.force:.4g} N", ""]
    rows = []
    for number, each in enumerate(result.motions):
        marks = ["best"] if number == result.best else []
        marks += [] if each.within else ["beyond its limits"]
        rows.append(
            [
                str(number + 1),
                f"{1e-3 * each.k_p:.4g}",
                f"{1e-3 * each.k_d:.4g}",
                _shown(each.metric, 1e6),
                _shown(each.error, 1e6),
                _shown(each.force),
                ", ".join(marks),
            ]
        )
    if rows:
        heads = ("motion", "k_p, N/mm", "k_d, N s/mm", "metric, um", "error, um", "force, N", "")
        lines += [table(heads, rows, right=(0, 1, 2, 3, 4, 5)), ""]
    lines += [f"note: {each}" for each in result.warnings]
    lines += [result.ended] if result.proposal is None else in_words(result.proposal)
    if result.changes:
        lines += ["", "best so far:", *_set(result.changes)]
    return "\n".join(lines)


def in_words(motion: NextMotion) -> list[str]:
    """Return a proposed motion, line by line."""
    lines = [
        f"next: k_p {1e-3 * motion.k_p:.4g} N/mm, k_d {1e-3 * motion.k_d:.4g} N s/mm",
        f"  {motion.text}",
        f"  expected {1e6 * motion.expected:.4g} um; error at most "
        f"{1e6 * motion.error_high:.4g} um, force at most {motion.force_high:.4g} N",
        f"  margins {_margins(motion.margins)}; worst plausible motor {_margins(motion.plausible)}",
    ]
    return lines + [f"  {each}" for each in _set(motion.changes)]


def _shown(value: float | None, factor: float = 1.0) -> str:
    return "diverged" if value is None else f"{factor * value:.4g}"


def _set(changes: dict[str, float]) -> list[str]:
    return [f"--set {path}={value:.6g}" for path, value in changes.items()]


def _margins(margins: LeastMargins) -> str:
    gain, phase = margins.gain_margin, margins.phase_margin
    first = "none" if gain is None else f"{20.0 * math.log10(gain):.3g} dB"
    second = "none" if phase is None else f"{math.degrees(phase):.3g} deg"
    return f"{first}, {second}"
