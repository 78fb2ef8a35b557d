"""The control period, and the only conversion between seconds and ticks."""

from __future__ import annotations

CONTROL_PERIOD = 0.5e-3
"""Control period T_s, s (Huang et al. 2019, section IV-A)."""

SUBSTEPS = 5
"""Steps of the plant in one control period."""

PLANT_STEP = CONTROL_PERIOD / SUBSTEPS
"""Step of the plant, s."""


def to_ticks(seconds: float) -> int:
    """Round a duration to whole control periods.

    Parameters
    ----------
    seconds : float
        Duration or instant, s.

    Returns
    -------
    int
        The nearest tick; every later computation uses this integer, never ``int(t / T_s)``.
    """
    return round(seconds / CONTROL_PERIOD)
