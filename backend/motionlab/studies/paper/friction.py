"""Eqs (43) to (48): the friction parameters, found again by the paper's procedure."""

from __future__ import annotations

from functools import partial

import numpy as np

from motionlab.studies.paper.curves import Build, curve
from motionlab.studies.paper.document import FigureAxis, PaperFigure
from motionlab.studies.paper.experiments import Experiments
from motionlab.studies.paper.printed_number import Quantity, by_identify, from_identify

GROUP = "friction"

_BAND = 0.02
_PRINTED = {
    "x": {
        "sigma_0": ("118913.2532", 118913.2532),
        "sigma_1": ("1162.3000", 1162.3),
        "sigma_2": ("10.3128", 10.3128),
        "F_c": ("0.2399", 0.2399),
        "F_s": ("3.5908", 3.5908),
        "v_s": ("0.0436", 0.0436),
    },
    "y": {
        "sigma_0": ("84737", 84737.0),
        "sigma_1": ("1493.5", 1493.5),
        "sigma_2": ("25.8778", 25.8778),
        "F_c": ("0.8179", 0.8179),
        "F_s": ("4.3917", 4.3917),
        "v_s": ("0.0222", 0.0222),
    },
}
_WHAT = {
    "sigma_0": ("bristle stiffness", "N/m", "presliding"),
    "sigma_1": ("bristle damping", "N s/m", "presliding"),
    "sigma_2": ("viscous friction", "N s/m", "sliding"),
    "F_c": ("Coulomb friction", "N", "sliding"),
    "F_s": ("stiction", "N", "sliding"),
    "v_s": ("Stribeck velocity", "m/s", "sliding"),
}


def _row(axis: str, name: str) -> Quantity:
    digits, paper = _PRINTED[axis][name]
    what, unit, part = _WHAT[name]
    find = f"axes.{axis}.{part}.parameters.{name}"
    equation = {"sigma_0": 43, "sigma_1": 43, "sigma_2": 43}.get(name, 45) + 3 * (axis == "y")
    return Quantity(
        id=f"friction-{axis}-{name.lower().replace('_', '')}",
        group=GROUP,
        kind="recovered",
        place=f"({equation})",
        quantity=f"{name}, {what}, {axis}",
        unit=unit,
        paper=paper,
        printed=f"{digits} {unit}",
        comparison="value",
        band=_BAND * paper,
        reason="2 %: chosen here; the identification itself is off by less than 0.1 %",
        basis="identified on the nominal motor, whose friction is the printed one: shows that the "
        "procedure finds it, not that the machine has it",
        compute=from_identify(find),
        doing="identification of friction",
        recipe=by_identify(f"{find}.value"),
        figure=f"friction-{axis}",
    )


QUANTITIES = tuple(_row(axis, name) for axis in "xy" for name in _WHAT)


def _figure(experiments: Experiments, axis: str) -> PaperFigure:
    """Return the friction over velocity of an axis: measured points and the printed curve."""
    p = {name: value for name, (_, value) in _PRINTED[axis].items()}
    v = np.linspace(-0.15, 0.15, 301)
    steady = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((v / p["v_s"]) ** 2))
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
            curve("printed parameters", "reference", v, np.sign(v) * steady + p["sigma_2"] * v),
            curve("measured", "B", points[:, 0], points[:, 1], kind="points"),
        ],
        bounds=[],
    )


FIGURES: dict[str, Build] = {f"friction-{axis}": partial(_figure, axis=axis) for axis in "xy"}
