"""The score of a law, and the order of several; docs/challenge.md has the equations.

Every part is a ratio to the law ``off`` on the same motor in the same scenario, so that ``off`` has
1 throughout, and less is better.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Literal, NamedTuple, get_args

WEIGHTS = {"error": 0.5, "motors": 0.25, "effort": 0.25}
"""Exponents of the parts in the score; their sum is 1."""
LIMITS = {"gain_margin_dB": 6.0, "phase_margin_deg": 30.0}
"""Least margins of a law that holds."""
GAIN_MARGIN = 10.0 ** (LIMITS["gain_margin_dB"] / 20.0)
PHASE_MARGIN = math.radians(LIMITS["phase_margin_deg"])

_LEAST = 1e-9
"""An error below a nanometre is one of rounding, m."""

Verdict = Literal["holds", "short of margins", "without margins", "diverges"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
"""Best first: the margins hold; they fall short; a linearised loop is unstable, or there is none;
runs diverge."""


class AxisFigures(NamedTuple):
    """Figures of one axis of a run, over the window of its metrics."""

    max_error: float  # largest following error, m
    rms_error: float  # m
    rms_force: float  # of the force command, N
    rms_force_change: float  # of its change from one control period to the next, N


def geometric_mean(values: Iterable[float]) -> float:
    """Return ``exp(mean(ln(values)))``; NaN without any."""
    logarithms = [math.log(value) for value in values]
    return math.exp(math.fsum(logarithms) / len(logarithms)) if logarithms else math.nan


def error_ratio(max_error: float, rms_error: float, off: tuple[float, float]) -> float:
    """Return ``sqrt(max/max_off rms/rms_off)``, of errors in m."""
    return geometric_mean(
        max(error, _LEAST) / max(without, _LEAST)
        for error, without in zip((max_error, rms_error), off, strict=True)
    )


def error_of(axes: Mapping[str, AxisFigures], off: Mapping[str, AxisFigures]) -> float:
    """Return the error of a scenario: the geometric mean of `error_ratio` over its axes."""
    return geometric_mean(
        error_ratio(of.max_error, of.rms_error, (off[axis].max_error, off[axis].rms_error))
        for axis, of in axes.items()
    )


def effort_of(axes: Mapping[str, AxisFigures], off: Mapping[str, AxisFigures]) -> float:
    """Return the geometric mean of ``sqrt(F/F_off D/D_off)`` over the axes of a scenario.

    F is the rms of the force command, D that of its change in a control period.
    """
    return geometric_mean(
        ratio
        for axis, of in axes.items()
        for ratio in (
            of.rms_force / off[axis].rms_force,
            of.rms_force_change / off[axis].rms_force_change,
        )
    )


def score_of(parts: Mapping[str, float]) -> float:
    """Return ``error^(1/2) motors^(1/4) effort^(1/4)``."""
    return math.exp(math.fsum(weight * math.log(parts[name]) for name, weight in WEIGHTS.items()))


def verdict_of(*, diverged: int, stable: bool, gain_margin: float, phase_margin: float) -> Verdict:
    """Return whether a law holds, or the worst of what it does not.

    Parameters
    ----------
    diverged : int
        Runs in which it diverged.
    stable : bool
        Whether every linearised loop is stable; False where there is none.
    gain_margin : float
        The least, a factor; infinite where nothing crosses.
    phase_margin : float
        The least, rad; infinite where nothing crosses.
    """
    if diverged:
        return "diverges"
    if not stable:
        return "without margins"
    enough = gain_margin >= GAIN_MARGIN and phase_margin >= PHASE_MARGIN
    return "holds" if enough else "short of margins"


def place(verdict: Verdict, score: float | None, label: str) -> tuple[int, float, str]:
    """Return the sorting key of a law: its verdict, then its score, none being the last."""
    return VERDICTS.index(verdict), math.inf if score is None else score, label
