"""Table 1 and Figs 6 to 8: staircases, trapezoid, rhombus and pentagram."""

from __future__ import annotations

import math
from typing import Any

from motionlab.studies.paper.bands import COUNT, Edge, edge_law
from motionlab.studies.paper.document import Number
from motionlab.studies.paper.printed_number import Compute, Quantity, Spread, by_run, from_run

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


def _compute(scenario: str, axis: str, metric: str | tuple[str, str]) -> Compute:
    """Return what compares the matched, compensated motor, and shows the other three."""
    return from_run(
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


def accuracy(  # noqa: PLR0913 - what differs between the rows of the table
    row_id: str,
    quantity: str,
    scenario: str,
    axis: str,
    *,
    paper: Number,
    printed: str,
    band: float,
    reason: str,
    figure: str | None,
    place: str = "Table 1",
    group: str = TABLE,
    note: str = "",
) -> Quantity:
    """Return a row on an error of the matched, compensated motor: at rest, or along the path.

    Parameters
    ----------
    row_id, quantity, paper, printed, band, reason, figure, place, group, note
        See `motionlab.studies.paper.printed_number.Quantity`; two numbers for `paper` are a range.
    scenario, axis : str
        The run.
    """
    ranged = isinstance(paper, tuple)
    metric: str | tuple[str, str] = "steady_state_error"
    if ranged:
        metric = ("min_following_error", "max_following_error")
    elif scenario in {"rhombus", "pentagram"}:
        metric = _PEAK
    find = _find(axis, metric, "B")
    return Quantity(
        id=row_id,
        group=group,
        place=place,
        quantity=quantity,
        unit="m",
        paper=paper,
        printed=printed,
        comparison="within" if ranged else "at_most",
        band=band,
        reason=reason,
        basis=BASIS,
        note=note,
        compute=_compute(scenario, axis, metric),
        doing=scenario,
        recipe=by_run(scenario, MATCHED, [find] if isinstance(find, str) else find),
        figure=figure,
        spread=Spread(scenario, axis, metric if isinstance(metric, str) else _PEAK),
    )


def edges(  # noqa: PLR0913 - what differs between the rows of the table
    row_id: str,
    quantity: str,
    scenario: str,
    axis: str,
    *,
    paper: Number,
    printed: str,
    edge: Edge,
    place: str = "Table 1",
    group: str = TABLE,
) -> Quantity:
    """Return a row on the following error along edges, whose time law the paper does not print.

    Parameters
    ----------
    row_id, quantity, paper, printed, place, group
        See `motionlab.studies.paper.printed_number.Quantity`.
    scenario, axis : str
        The run.
    edge : Edge
        Decides the band.
    """
    law = edge_law(edge)
    return accuracy(
        row_id,
        quantity,
        scenario,
        axis,
        paper=paper,
        printed=printed,
        band=law + COUNT + _ROUND,
        reason=f"the time law of the edges is not printed: 31 % of M a/k_p, {law * 1e6:.1f} um, "
        "between the least acceleration that stops at the corners and ours; one encoder count; "
        "half of the last printed digit",
        figure=f"fig8-{scenario}-{axis}",
        place=place,
        group=group,
        note=LIKE_PD,
    )


RHOMBUS_X = Edge(M=5.9, k_p=400.0e3, d=0.03, T=0.75)
RHOMBUS_Y = Edge(M=13.9, k_p=501.6e3, d=0.03, T=0.75)
# The pentagram's edges along an axis: 57.06 mm on x, 57.06 mm sin 72 deg on y.
PENTAGRAM_X = Edge(M=5.9, k_p=200.3e3, d=0.05706, T=0.6)
PENTAGRAM_Y = Edge(M=13.9, k_p=280.5e3, d=0.05706 * math.sin(0.4 * math.pi), T=0.6)
