"""Table 1 and Figs 6 to 8: staircases, trapezoid, rhombus and pentagram."""

from __future__ import annotations

from typing import Any

from motionlab.paper.bands import COUNT, edge_law
from motionlab.paper.document import Number
from motionlab.paper.printed_number import PrintedNumber, Spread, from_run

TABLE, TEXT = "table1", "motions"
"""Identifiers of the groups."""

MATCHED: dict[str, Any] = {"plant": "matched"}
NOMINAL: dict[str, Any] = {}

BASIS = "matched motor, LuGre observer (K = 0), the printed gains"
_PEAK = "max_abs_following_error"
_ROUND = 0.05e-6
"""Half of the last printed digit, m."""

LIKE_PD = "The nominal motor without compensation is closest to the printed value"

A_LAW = (
    "half of what accelerations of 1.0 to 1.66 m/s^2, all allowed by the text, make of the steady "
    "state without compensation, and one encoder count"
)


def _find(axis: str, metric: str | tuple[str, str], variant: str) -> str | tuple[str, str]:
    path = f"variants.{variant}.axes.{axis}."
    if isinstance(metric, str):
        return path + metric
    return (path + metric[0], path + metric[1])


def accuracy(
    row_id: str, quantity: str, paper: Number, *, run: tuple[str, str] | None = None, **more: Any
) -> PrintedNumber:
    """Return a row on the error of the matched, compensated motor, with the other three as values.

    Parameters
    ----------
    row_id, quantity, paper
        See `motionlab.paper.printed_number.PrintedNumber`; two numbers for `paper` are a
        range.
    run : tuple of str, optional
        Scenario and axis, where they are not those of the identifier.
    **more
        Further fields of the row.
    """
    scenario, axis = run or (row_id, "x" if "-x" in row_id else "y")
    metric: str | tuple[str, str] = "steady_state_error"
    if ranged := isinstance(paper, tuple):
        metric = ("min_following_error", "max_following_error")
        printed = "[{:.1f}, {:.1f}] um".format(*(1e6 * end for end in paper))
    else:
        printed = f"±{1e6 * paper:.1f} um"
    if not ranged and scenario in {"rhombus", "pentagram"}:
        metric = _PEAK
    source = from_run(
        scenario,
        _find(axis, metric, "B"),
        changes=MATCHED,
        others={
            f"{motor}, {'LuGre observer' if variant == 'B' else 'no compensation'}": (
                scenario,
                changes,
                _find(axis, metric, variant),
            )
            for motor, changes, variant in (
                ("matched", MATCHED, "A"),
                ("nominal", NOMINAL, "B"),
                ("nominal", NOMINAL, "A"),
            )
        },
    )
    fields: dict[str, Any] = {"place": "Table 1", "group": TABLE} | more
    return PrintedNumber(
        id=row_id,
        quantity=quantity,
        unit="m",
        paper=paper,
        printed=printed,
        comparison="within" if ranged else "at_most",
        basis=BASIS,
        source=source,
        doing=scenario,
        spread=Spread(scenario, axis, metric if isinstance(metric, str) else _PEAK),
        **fields,
    )


def edges(row_id: str, paper: Number, axis: str, **more: Any) -> PrintedNumber:
    """Return a row on the following error along edges of unprinted motion profile.

    Parameters
    ----------
    row_id, paper
        See `motionlab.paper.printed_number.PrintedNumber`.
    axis : str
        ``x`` or ``y``.
    **more
        Further fields of the row.
    """
    scenario = row_id.split("-", maxsplit=1)[0]
    law = edge_law(scenario, axis)
    fields = {"quantity": f"Following error, {scenario}, {axis}"} | more
    return accuracy(
        row_id,
        paper=paper,
        run=(scenario, axis),
        band=law + COUNT + _ROUND,
        reason="the motion profile of the edges is not printed: "
        f"31 % of M a/k_p, {law * 1e6:.1f} um, between the least acceleration that stops at the "
        "corners and ours; one encoder count; half of the last printed digit",
        figure=f"fig8-{scenario}-{axis}",
        note=LIKE_PD,
        **fields,
    )
