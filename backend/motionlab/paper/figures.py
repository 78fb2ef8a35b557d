"""Figures in the manner of the paper's: Fig. 5 to Fig. 8 and the stability proof."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import MotionLabError
from motionlab.paper.control import STABILITY, published
from motionlab.paper.documents import FigureAxis, FigureBound, FigureSeries, PaperFigure, Role
from motionlab.paper.experiments import Build, Experiments, Run, figure_series, trace
from motionlab.paper.forces import FORCE_FIGURES, FORCES, FRICTION, FRICTION_FIGURES
from motionlab.paper.motions import CIRCLE, MATCHED, MOTIONS, PRINTED, TABLE
from motionlab.paper.printed_number import PrintedNumber
from motionlab.timing import CONTROL_PERIOD, to_ticks

TIME = FigureAxis(label="time", unit="s")
LABELS = {"A": "off", "B": "LuGre"}
"""Of the two variants."""


def channel(run: Run, variant: str, name: str, axis: str) -> NDArray[np.float64]:
    """Return one channel of one axis of a variant, shape (ticks,)."""
    return run.recording.variants[variant].channel(name, axis).astype(np.float64)


_Y_MOTIONS = {"fig6": "trapezoid-y", "fig7": "stair-y-50mm"}
_Y_PRINTED = {"fig6": 1.5e-6, "fig7": 1.6e-6}
_Y_TITLES = {"fig6": "Trapezoid of 290 mm", "fig7": "Staircase of 50 mm"}
_PHASES: tuple[tuple[str, Role], ...] = (("a", "phase-a"), ("b", "phase-b"), ("c", "phase-c"))
_PARTS = {"position": "a", "velocity": "b", "error": "c", "acceleration": "d"}
_PANELS = {
    "position": ("position, y", "m"),
    "velocity": ("velocity, y", "m/s"),
    "error": ("following error, y", "m"),
    "acceleration": ("acceleration, y", "m/s^2"),
}


def _y_motion(experiments: Experiments, figure: str, panel: str) -> PaperFigure:
    run = experiments.run(_Y_MOTIONS[figure], MATCHED)
    label, unit = _PANELS[panel]
    series = [_y_panel(run, panel, variant) for variant in "AB"]
    bounds = []
    if panel == "position":
        series.insert(0, trace("reference", "reference", run.prepared.reference.position[:, 1]))
    if panel == "error":
        limit = _Y_PRINTED[figure]
        bounds = [
            FigureBound(label="printed, at rest", low=-limit, high=limit, start=None, end=None)
        ]
    if panel == "acceleration":
        bounds = [
            FigureBound(label="printed, observed", low=-3.06, high=1.66, start=None, end=None)
        ]
    if panel == "velocity":
        bounds = [
            FigureBound(label="printed, observed", low=-0.14, high=0.15, start=None, end=None)
        ]
    return PaperFigure(
        id=f"{figure}-{panel}",
        group=MOTIONS,
        title=f"Fig. {figure[3:]}({_PARTS[panel]}): {label.split(',')[0]}",
        about=f"{_Y_TITLES[figure]}, matched motor; velocity and acceleration by differences of "
        "the encoder, as in the paper. The motion profile is ours.",
        x=TIME,
        y=FigureAxis(label=label, unit=unit),
        series=series,
        bounds=bounds,
    )


def _y_panel(run: Run, panel: str, variant: Any) -> FigureSeries:
    name = {"position": "position_measured", "error": "following_error"}.get(
        panel, "velocity_measured"
    )
    samples = channel(run, variant, name, "y")
    if panel == "acceleration":
        samples = np.diff(samples) / CONTROL_PERIOD
    return trace(LABELS[variant], variant, samples)


def _currents(experiments: Experiments) -> PaperFigure:
    run = experiments.run("trapezoid-y", MATCHED)
    return PaperFigure(
        id="fig6-currents",
        group=MOTIONS,
        title="Fig. 6(e) to (g): currents",
        about="Matched motor, LuGre observer. The paper shows currents of x beside a motion of y: "
        "see the errata.",
        x=TIME,
        y=FigureAxis(label="current, y", unit="A"),
        series=[
            trace(f"phase {phase}", role, channel(run, "B", f"current_{phase}", "y"))
            for phase, role in _PHASES
        ],
        bounds=[FigureBound(label="limit", low=None, high=10.0, start=None, end=None)],
    )


_FIG8 = {
    "rhombus": {"x": (-14.2e-6, 14.3e-6), "y": (-18.2e-6, 16.9e-6)},
    "pentagram": {"x": (-31.5e-6, 38.6e-6), "y": (-52.7e-6, 56.8e-6)},
}


def _last_lap(run: Run) -> slice:
    reference = run.prepared.reference
    return slice(reference.window[1] - reference.period, reference.window[1])


def _fig8_error(experiments: Experiments, scenario: str, axis: str) -> PaperFigure:
    run = experiments.run(scenario, MATCHED)
    here = _last_lap(run)
    low, high = _FIG8[scenario][axis]
    return PaperFigure(
        id=f"fig8-{scenario}-{axis}",
        group=MOTIONS,
        title=f"Fig. 8(b): {scenario}, {axis}",
        about="Matched motor, the last lap. Edges stop at the corners; the motion profile is ours.",
        x=TIME,
        y=FigureAxis(label=f"following error, {axis}", unit="m"),
        series=[
            trace(LABELS[variant], variant, channel(run, variant, "following_error", axis)[here])
            for variant in ("A", "B")
        ],
        bounds=[FigureBound(label="printed", low=low, high=high, start=None, end=None)],
    )


def _fig8_path(experiments: Experiments, scenario: str) -> PaperFigure:
    run = experiments.run(scenario, MATCHED)
    here = _last_lap(run)
    position = run.prepared.reference.position[here][::8]
    measured = [channel(run, "B", "position_measured", axis)[here][::8] for axis in "xy"]
    return PaperFigure(
        id=f"fig8-{scenario}-path",
        group=MOTIONS,
        title=f"Fig. 8(a): {scenario}",
        about="The shape is inferred: the paper prints its size only.",
        x=FigureAxis(label="position, x", unit="m"),
        y=FigureAxis(label="position, y", unit="m"),
        series=[
            figure_series("reference", "reference", position[:, 0], position[:, 1]),
            figure_series(LABELS["B"], "B", measured[0], measured[1]),
        ],
        bounds=[],
    )


def _fig8_motion(experiments: Experiments, scenario: str, what: str) -> PaperFigure:
    run = experiments.run(scenario, MATCHED)
    here = _last_lap(run)
    series: list[FigureSeries] = []
    for axis in ("x", "y"):
        samples = channel(run, "B", "velocity_measured", axis)[here]
        if what == "acceleration":
            samples = np.diff(samples) / CONTROL_PERIOD
        series.append(trace(axis, axis, samples))
    part, unit = {"velocity": ("c", "m/s"), "acceleration": ("d", "m/s^2")}[what]
    return PaperFigure(
        id=f"fig8-{scenario}-{what}",
        group=MOTIONS,
        title=f"Fig. 8({part}): {scenario}, {what}",
        about="Matched motor, LuGre observer, the last lap; by differences of the encoder.",
        x=TIME,
        y=FigureAxis(label=what, unit=unit),
        series=series,
        bounds=[],
    )


MOTION_FIGURES: dict[str, Build] = {
    **{
        f"{figure}-{panel}": partial(_y_motion, figure=figure, panel=panel)
        for figure in _Y_MOTIONS
        for panel in _PANELS
    },
    "fig6-currents": _currents,
    **{
        f"fig8-{scenario}-{part}": build
        for scenario in _FIG8
        for part, build in (
            ("path", partial(_fig8_path, scenario=scenario)),
            ("x", partial(_fig8_error, scenario=scenario, axis="x")),
            ("y", partial(_fig8_error, scenario=scenario, axis="y")),
            ("velocity", partial(_fig8_motion, scenario=scenario, what="velocity")),
            ("acceleration", partial(_fig8_motion, scenario=scenario, what="acceleration")),
        )
    },
}


_SWITCH = 90.0


def of_group(
    group: str, rows: Sequence[PrintedNumber], experiments: Experiments, *, whole: bool
) -> list[PaperFigure]:
    """Return the figures of a group: all of them, or those that some rows are shown in."""
    if whole:
        builds = FIGURES.get(group, {})
    else:
        every = {name: build for builds in FIGURES.values() for name, build in builds.items()}
        builds = {row.figure: every[row.figure] for row in rows if row.figure is not None}
    group_figures = []
    for build in builds.values():
        try:
            group_figures.append(build(experiments))
        except MotionLabError:
            continue
    return group_figures


def _fig5(experiments: Experiments, axis: str) -> PaperFigure:
    run = experiments.run("fig5", {})
    off, on = PRINTED[axis]
    return PaperFigure(
        id=f"fig5-{axis}",
        group=CIRCLE,
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
    proof = published(experiments, axis)
    series: list[FigureSeries] = []
    if proof is not None:
        lap = to_ticks(1.0)
        places = proof.singular_places[proof.singular_places < lap]
        series = [
            figure_series(
                "V", "B", proof.time[:lap:2], np.where(proof.V > 0.0, proof.V, np.nan)[:lap:2]
            ),
            figure_series(
                "K singular",
                "printed",
                proof.time[places],
                proof.V[places],
                kind="points",
            ),
        ]
    return PaperFigure(
        id=f"lyapunov-{axis}",
        group=STABILITY,
        title=f"V of (37), {axis}",
        about="One second of the circle with K of (25), nominal motor without encoder counts or "
        "current lag. By (38) V never rises. K is singular where its denominator crosses zero.",
        x=TIME,
        y=FigureAxis(label="V", unit="m^4", log=True),
        series=series,
        bounds=[],
    )


FIGURES: dict[str, dict[str, Build]] = {
    FORCES: FORCE_FIGURES,
    FRICTION: FRICTION_FIGURES,
    STABILITY: {f"lyapunov-{axis}": partial(_lyapunov, axis=axis) for axis in "xy"},
    CIRCLE: {f"fig5-{axis}": partial(_fig5, axis=axis) for axis in "xy"},
    TABLE: {f"stair-{axis}-500nm": partial(_stair, axis=axis) for axis in "xy"},
    MOTIONS: MOTION_FIGURES,
}
"""Group to figure to its drawing function."""
