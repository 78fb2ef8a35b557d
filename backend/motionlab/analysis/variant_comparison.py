"""One variant against another."""

from __future__ import annotations

import math
from typing import Any

from motionlab.analysis.metrics import DEFINITIONS

RATIOS = tuple(name for name, each in DEFINITIONS.items() if each.ratio)
"""Metrics of which a quotient means something."""


def compare(a: dict[str, Any], b: dict[str, Any]) -> dict[str, Any]:
    """Return B against A, axis by axis.

    Parameters
    ----------
    a, b : dict
        From `motionlab.analysis.metrics.variant_metrics`.

    Returns
    -------
    dict
        For each axis ``<metric>_ratio`` = B/A; None where one of them is missing or A is zero.
    """
    return {
        axis: {
            f"{metric}_ratio": _ratio(a["axes"][axis][metric], b["axes"][axis][metric])
            for metric in RATIOS
        }
        for axis in a["axes"]
    }


def _ratio(a: float | None, b: float | None) -> float | None:
    if a is None or b is None or a == 0.0:
        return None
    ratio = b / a
    return ratio if math.isfinite(ratio) else None  # a subnormal A: as good as zero
