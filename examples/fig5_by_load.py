"""Whether Fig. 5 follows from friction that grows with the normal force, without fitted factors.

Run with ``.venv/bin/python examples/fig5_by_load.py``; the table is in docs/paper.md. What is taken
for friction by normal force, `motionlab.paper.by_load` says; the row ``fig5-by-load`` judges it.
"""

from __future__ import annotations

from motionlab.paper.by_load import FOUR, errors, worst
from motionlab.paper.motions import PRINTED

STEPS = {
    "nominal": (0.0, 0.01, 0.02, 0.03, 0.034, 0.04, 0.05),
    "as-measured": (0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.054, 0.06),
}

printed = [PRINTED[axis][segment] for axis, segment in FOUR]
print("| motor | mu | off x | off y | on x | on y | worst |")
print("|---|---|---|---|---|---|---|")
print(f"| paper | | {' | '.join(f'{1e6 * each:.1f}' for each in printed)} | |")
for motor, coefficients in STEPS.items():
    for mu in coefficients:
        four = errors(motor, mu)
        cells = " | ".join(f"{1e6 * each:.1f}" for each in four)
        print(f"| {motor} | {mu:g} | {cells} | {100.0 * worst(four):.0f} % |")
