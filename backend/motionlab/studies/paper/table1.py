"""Table 1: position errors of the staircases, the trapezoid, the rhombus and the pentagram."""

from __future__ import annotations

from motionlab.studies.paper.bands import COUNT, STAIRCASE, TRAPEZOID
from motionlab.studies.paper.tracking import (
    A_LAW,
    LIKE_PD,
    PENTAGRAM_X,
    PENTAGRAM_Y,
    RHOMBUS_X,
    RHOMBUS_Y,
    TABLE,
    accuracy,
    edges,
)

GROUP = TABLE

QUANTITIES = (
    accuracy(
        "stair-x-500nm",
        "Steady-state error, x staircase of 0.5 um",
        "stair-x-500nm",
        "x",
        paper=0.4e-6,
        printed="±0.4 um",
        band=COUNT,
        reason="one encoder count, 50 nm",
        figure="stair-x-500nm",
    ),
    accuracy(
        "stair-y-500nm",
        "Steady-state error, y staircase of 0.5 um",
        "stair-y-500nm",
        "y",
        paper=0.4e-6,
        printed="±0.4 um",
        band=COUNT,
        reason="one encoder count, 50 nm",
        figure="stair-y-500nm",
    ),
    accuracy(
        "stair-y-50mm",
        "Steady-state error, y staircase of 50 mm",
        "stair-y-50mm",
        "y",
        paper=1.6e-6,
        printed="±1.6 um",
        band=STAIRCASE + COUNT,
        reason=A_LAW,
        figure="fig7-error",
        note=LIKE_PD,
    ),
    accuracy(
        "trapezoid-y",
        "Steady-state error, y trapezoid of 290 mm",
        "trapezoid-y",
        "y",
        paper=1.5e-6,
        printed="±1.5 um",
        band=TRAPEZOID + COUNT,
        reason=A_LAW,
        figure="fig6-error",
        note="Section IV-A says 1.6 um of the same motion",
    ),
    edges(
        "rhombus-x",
        "Following error, rhombus, x",
        "rhombus",
        "x",
        paper=(-14.2e-6, 14.3e-6),
        printed="[-14.2, 14.3] um",
        edge=RHOMBUS_X,
    ),
    edges(
        "rhombus-y",
        "Following error, rhombus, y",
        "rhombus",
        "y",
        paper=(-18.2e-6, 16.9e-6),
        printed="[-18.2, 16.9] um",
        edge=RHOMBUS_Y,
    ),
    edges(
        "pentagram-x",
        "Following error, pentagram, x",
        "pentagram",
        "x",
        paper=(-31.5e-6, 38.6e-6),
        printed="[-31.5, 38.6] um",
        edge=PENTAGRAM_X,
    ),
    edges(
        "pentagram-y",
        "Following error, pentagram, y",
        "pentagram",
        "y",
        paper=(-52.7e-6, 56.8e-6),
        printed="[-52.7, 56.8] um",
        edge=PENTAGRAM_Y,
    ),
)
