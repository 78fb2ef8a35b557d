"""Figures in the manner of the paper's: Fig. 5 to Fig. 8 and the stability proof."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from motionlab.config.timing import to_ticks
from motionlab.errors import MotionLabError
from motionlab.paper import circle, forces, friction, motion_figures, stability
from motionlab.paper.curves import Build, curve, trace
from motionlab.paper.document import FigureAxis, FigureBound, FigureSeries, PaperFigure
from motionlab.paper.experiments import Experiments
from motionlab.paper.motion_figures import LABELS, TIME, channel
from motionlab.paper.printed_number import PrintedNumber
from motionlab.paper.tracking import MATCHED, TABLE, TEXT

_SWITCH = 90.0


def of_group(
    group: str, rows: Sequence[PrintedNumber], experiments: Experiments, *, whole: bool
) -> list[PaperFigure]:
    """Return the figures of a group: all of them, or those that some rows are shown in.

    Parameters
    ----------
    group : str
        Identifier.
    rows : sequence of PrintedNumber
        Its rows that are computed.
    experiments : Experiments
        Experiments of the rows.
    whole : bool
        Whether every figure of the group is wanted.

    Returns
    -------
    list of PaperFigure
        One that cannot be drawn is left out: its rows state why.
    """
    if whole:
        builds = FIGURES.get(group, {})
    else:
        every = {name: build for builds in FIGURES.values() for name, build in builds.items()}
        builds = {row.figure: every[row.figure] for row in rows if row.figure is not None}
    found = []
    for build in builds.values():
        try:
            found.append(build(experiments))
        except MotionLabError:
            continue
    return found


def _fig5(experiments: Experiments, axis: str) -> PaperFigure:
    run = experiments.run("fig5", {})
    off, on = circle.PRINTED[axis]
    return PaperFigure(
        id=f"fig5-{axis}",
        group=circle.GROUP,
        title=f"Fig. 5({'a' if axis == 'x' else 'b'}): error on {axis}",
        about="Matched motor; A: the LuGre observer is switched on at 90 s; B: feedforward and a "
        "disturbance observer with it, drawn from then on. Gains, frequency and the length of the "
        "recording are ours: the paper prints none.",
        x=TIME,
        y=FigureAxis(label=f"following error, {axis}", unit="m"),
        series=[
            trace("A: LuGre", "A", channel(run, "A", "following_error", axis)),
            trace(
                "B: with both",
                "B",
                channel(run, "B", "following_error", axis)[to_ticks(_SWITCH) :],
                start=_SWITCH,
            ),
        ],
        bounds=[
            FigureBound(label="printed", low=-off, high=off, start=0.0, end=_SWITCH),
            FigureBound(label="printed, on", low=-on, high=on, start=_SWITCH, end=None),
        ],
    )


def _stair(experiments: Experiments, axis: str) -> PaperFigure:
    run = experiments.run(f"stair-{axis}-500nm", MATCHED)
    reference = run.prepared.reference.position[:, "xy".index(axis)]
    return PaperFigure(
        id=f"stair-{axis}-500nm",
        group=TABLE,
        title=f"Staircase of 0.5 um, {axis}",
        about="Matched motor; the encoder counts 50 nm.",
        x=TIME,
        y=FigureAxis(label=f"position, {axis}", unit="m"),
        series=[
            trace("reference", "reference", reference),
            *(
                trace(
                    LABELS[variant],
                    variant,
                    # Not the recorded position: as float32 it is good to 7 nm.
                    reference - channel(run, variant, "following_error", axis),
                )
                for variant in ("A", "B")
            ),
        ],
        bounds=[],
    )


def _lyapunov(experiments: Experiments, axis: str) -> PaperFigure:
    found = stability.published(experiments, axis)
    series: list[FigureSeries] = []
    if found is not None:
        lap = to_ticks(1.0)
        places = found.singular_places[found.singular_places < lap]
        series = [
            curve("V", "B", found.time[:lap:2], np.where(found.V > 0.0, found.V, np.nan)[:lap:2]),
            curve(
                "K singular",
                "printed",
                found.time[places],
                found.V[places],
                kind="points",
            ),
        ]
    return PaperFigure(
        id=f"lyapunov-{axis}",
        group=stability.GROUP,
        title=f"V of (37), {axis}",
        about="One second of the circle with K of (25), nominal motor without encoder counts or "
        "current lag. By (38) V never rises. K is singular where its denominator crosses zero.",
        x=TIME,
        y=FigureAxis(label="V", unit="m^4", log=True),
        series=series,
        bounds=[],
    )


FIGURES: dict[str, dict[str, Build]] = {
    forces.GROUP: forces.FIGURES,
    friction.GROUP: friction.FIGURES,
    stability.GROUP: {f"lyapunov-{axis}": partial(_lyapunov, axis=axis) for axis in "xy"},
    circle.GROUP: {f"fig5-{axis}": partial(_fig5, axis=axis) for axis in "xy"},
    TABLE: {f"stair-{axis}-500nm": partial(_stair, axis=axis) for axis in "xy"},
    TEXT: motion_figures.FIGURES,
}
"""Group to figure to its drawing function."""
