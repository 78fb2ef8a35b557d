"""Figs 6 to 8: position, velocity, following error, acceleration and currents over time."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.paper.curves import Build, curve, trace
from motionlab.paper.document import (
    FigureAxis,
    FigureBound,
    FigureSeries,
    PaperFigure,
    Role,
)
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.tracking import MATCHED, TEXT

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
        group=TEXT,
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
        group=TEXT,
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
        group=TEXT,
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
        group=TEXT,
        title=f"Fig. 8(a): {scenario}",
        about="The shape is inferred: the paper prints its size only.",
        x=FigureAxis(label="position, x", unit="m"),
        y=FigureAxis(label="position, y", unit="m"),
        series=[
            curve("reference", "reference", position[:, 0], position[:, 1]),
            curve(LABELS["B"], "B", measured[0], measured[1]),
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
        group=TEXT,
        title=f"Fig. 8({part}): {scenario}, {what}",
        about="Matched motor, LuGre observer, the last lap; by differences of the encoder.",
        x=TIME,
        y=FigureAxis(label=what, unit=unit),
        series=series,
        bounds=[],
    )


FIGURES: dict[str, Build] = {
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
