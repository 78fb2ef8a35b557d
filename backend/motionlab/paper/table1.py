"""Table 1: position errors of the staircases, the trapezoid, the rhombus and the pentagram."""

from __future__ import annotations

from motionlab.paper.bands import COUNT, STAIRCASE, TRAPEZOID
from motionlab.paper.tracking import A_LAW, LIKE_PD, TABLE, accuracy, edges

GROUP = TABLE

QUANTITIES = (
    *(
        accuracy(
            f"stair-{axis}-500nm",
            f"Steady-state error, {axis} staircase of 0.5 um",
            0.4e-6,
            band=COUNT,
            reason="one encoder count, 50 nm",
            figure=f"stair-{axis}-500nm",
        )
        for axis in "xy"
    ),
    accuracy(
        *("stair-y-50mm", "Steady-state error, y staircase of 50 mm", 1.6e-6),
        band=STAIRCASE + COUNT,
        reason=A_LAW,
        figure="fig7-error",
        note=LIKE_PD,
    ),
    accuracy(
        *("trapezoid-y", "Steady-state error, y trapezoid of 290 mm", 1.5e-6),
        band=TRAPEZOID + COUNT,
        reason=A_LAW,
        figure="fig6-error",
        note="Section IV-A says 1.6 um of the same motion",
    ),
    edges("rhombus-x", (-14.2e-6, 14.3e-6), "x"),
    edges("rhombus-y", (-18.2e-6, 16.9e-6), "y"),
    edges("pentagram-x", (-31.5e-6, 38.6e-6), "x"),
    edges("pentagram-y", (-52.7e-6, 56.8e-6), "y"),
)
