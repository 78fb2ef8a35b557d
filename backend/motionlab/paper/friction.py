"""Eqs (43) to (48): the friction parameters, found again by the paper's procedure."""

from __future__ import annotations

from functools import partial

import numpy as np

from motionlab.paper.curves import Build, curve
from motionlab.paper.document import FigureAxis, PaperFigure
from motionlab.paper.experiments import Experiments
from motionlab.paper.printed_number import PrintedNumber, from_identify
from motionlab.plant.friction import steady_friction

GROUP = "friction"

_BAND = 0.02
_PRINTED = {
    "x": ("118913.2532", "1162.3000", "10.3128", "0.2399", "3.5908", "0.0436"),
    "y": ("84737", "1493.5", "25.8778", "0.8179", "4.3917", "0.0222"),
}
"""Digits in the order of _WHAT."""
_WHAT = {
    "sigma_0": ("bristle stiffness", "N/m", "presliding"),
    "sigma_1": ("bristle damping", "N s/m", "presliding"),
    "sigma_2": ("viscous friction", "N s/m", "sliding"),
    "F_c": ("Coulomb friction", "N", "sliding"),
    "F_s": ("stiction", "N", "sliding"),
    "v_s": ("Stribeck velocity", "m/s", "sliding"),
}


def _row(axis: str, name: str) -> PrintedNumber:
    digits = _PRINTED[axis][list(_WHAT).index(name)]
    what, unit, part = _WHAT[name]
    equation = (43 if name.startswith("sigma") else 45) + 3 * (axis == "y")
    return PrintedNumber(
        *(f"friction-{axis}-{name.lower().replace('_', '')}", f"({equation})"),
        *(f"{name}, {what}, {axis}", unit, float(digits), f"{digits} {unit}"),
        group=GROUP,
        kind="recovered",
        comparison="value",
        band=_BAND * float(digits),
        reason="2 %: chosen here; the identification itself is off by less than 0.1 %",
        basis="identified on the nominal motor, whose friction is the printed one: shows that the "
        "procedure finds it, not that the machine has it",
        source=from_identify(f"axes.{axis}.{part}.parameters.{name}"),
        doing="identification of friction",
        figure=f"friction-{axis}",
    )


QUANTITIES = tuple(_row(axis, name) for axis in "xy" for name in _WHAT)


def _figure(experiments: Experiments, axis: str) -> PaperFigure:
    """Return the friction over velocity of an axis: measured points and the printed curve."""
    sigma_2, F_c, F_s, v_s = (float(digits) for digits in _PRINTED[axis][2:])
    v = np.linspace(-0.15, 0.15, 301)
    found = experiments.identification().axes[axis].points
    points = np.array(sorted((point.velocity, point.force) for point in found))
    return PaperFigure(
        id=f"friction-{axis}",
        group=GROUP,
        title=f"Friction over velocity, {axis}",
        about="Mean force command of uniform motions on the nominal motor, and the curve of the "
        "printed parameters.",
        x=FigureAxis(label="velocity", unit="m/s"),
        y=FigureAxis(label="friction", unit="N"),
        series=[
            curve("printed parameters", "reference", v, steady_friction(v, F_c, F_s, v_s, sigma_2)),
            curve("measured", "B", points[:, 0], points[:, 1], kind="points"),
        ],
        bounds=[],
    )


FIGURES: dict[str, Build] = {f"friction-{axis}": partial(_figure, axis=axis) for axis in "xy"}
