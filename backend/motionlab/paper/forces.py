"""Fig. 2, sections II-A and IV-A: forces by finite elements; friction, eqs (43) to (48)."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.fem.uncertainty import MEASURED_NOT_COMPARABLE
from motionlab.paper.documents import FigureAxis, Number, PaperFigure
from motionlab.paper.experiments import Build, Experiments, figure_series
from motionlab.paper.printed_number import (
    Compute,
    PrintedNumber,
    RowResult,
    RowSource,
    from_identify,
    percent,
)
from motionlab.plant.friction import steady_friction

FORCES = "forces"
I_PEAK = 10.0
"""Peak current, A."""

THRUST, NORMAL = 0.15, 0.10
"""Uncertainty of the finite elements: the paper leaves the cross-section partly open."""

_FINE = 721
_BASIS = "our finite elements in two dimensions with depths, preset default"
_DOING = "force map by finite elements"
_GRID = "the grid of the paper's own finite elements; ours are computed at the same currents"
_UNSEEN = "a mean over measured points that are drawn in Fig. 2 and printed nowhere"

Array = NDArray[np.float64]


def positions(force_map: ForceMap) -> Array:
    """Return positions over a pole pitch, 0 aligned, m."""
    return np.linspace(-force_map.tau / 2, force_map.tau / 2, _FINE)


def peak_thrust(force_map: ForceMap, current: float = I_PEAK) -> float:
    """Return the largest thrust of one phase, N."""
    x = positions(force_map)
    return float(np.abs(force_map.thrust(x, np.full(len(x), current))).max())


def peak_normal(force_map: ForceMap, current: float = I_PEAK) -> float:
    """Return the largest normal force of one phase, N."""
    x = positions(force_map)
    return float(force_map.normal_force(x, np.full(len(x), current)).max())


def two_phase_thrust(force_map: ForceMap) -> Array:
    """Return the thrust of the phases of one direction at peak current, over a pitch, N."""
    x = positions(force_map)
    full = np.full(len(x), I_PEAK)
    thrusts = [force_map.thrust(x - k * force_map.tau / 3, full) for k in range(3)]
    return np.maximum(0.0, np.array(thrusts)).sum(axis=0)


def _thrust(experiments: Experiments) -> RowResult:
    return RowResult(peak_thrust(experiments.force_map()))


def _normal(experiments: Experiments) -> RowResult:
    return RowResult(peak_normal(experiments.force_map()))


def _two_phase(experiments: Experiments) -> RowResult:
    thrust = two_phase_thrust(experiments.force_map())
    return RowResult(float(thrust.max()), {"least over a pole pitch": float(thrust.min())})


def _at_rest(experiments: Experiments) -> RowResult:
    force_map = experiments.force_map()
    places = np.array([0.0, force_map.tau / 2])
    return RowResult(float(np.abs(force_map.thrust(places, np.full(2, I_PEAK))).max()))


def _phases_at_once(experiments: Experiments) -> RowResult:
    record = experiments.run("pentagram", {"plant": "matched"}).recording.variants["B"]
    commands = [
        [record.channel(f"current_command_{phase}", axis) for phase in "abc"] for axis in "xy"
    ]
    return RowResult(float((np.array(commands) > 0.0).sum(axis=1).max()))


def _reason(share: float, what: str) -> str:
    return (
        f"{100 * share:.0f} %: the paper leaves the cross-section partly open, and what it leaves "
        f"open moves the {what} of two-dimensional finite elements by as much"
    )


_fem = partial(PrintedNumber, group=FORCES, basis=_BASIS, doing=_DOING)
_claim = partial(_fem, kind="claim")
_none = partial(PrintedNumber, group=FORCES, kind="no_data")


def _largest(
    what: str, fem: float, measured: float, share: float, compute: Compute
) -> tuple[PrintedNumber, PrintedNumber]:
    """Return the rows of a peak: the paper's finite elements, and its measurement.

    Ours is of finite elements as well, so it is judged against the former and shown with the
    latter.
    """
    name = what.split(maxsplit=1)[0]
    quantity = f"Largest {what} of one phase"
    one = "one figure confirms one of the two at most"
    ours = "ours, of finite elements, is held against finite elements"

    def shown(experiments: Experiments) -> RowResult:
        return RowResult(None, {"our finite elements": compute(experiments).ours})

    more, less = percent(measured / fem - 1.0), percent(1.0 - fem / measured)
    judged = _fem(
        *(f"{name}-fem", "II-A-2", f"{quantity}, FEM", "N", fem, f"{fem:g} N"),
        comparison="value",
        band=share * fem,
        reason=_reason(share, what),
        rival=measured,
        conflict=f"{name}-measured prints {measured:g} N, {more} more: {one}; {ours}",
        source=RowSource(compute),
        figure=f"fig2-{name}",
    )
    return judged, _none(
        *(f"{name}-measured", "IV-A", f"{quantity}, measured", "N", measured, f"{measured:g} N"),
        reason=MEASURED_NOT_COMPARABLE,
        conflict=f"{name}-fem prints {fem:g} N, {less} less: {one}; {ours}",
        source=RowSource(shown),
        doing=_DOING,
        figure=f"fig2-{name}",
    )


def _error(name: str, of: str, paper: Number, printed: str, more: str = "") -> PrintedNumber:
    peaks = "12.4 %" if name == "normal" else "12.6 %"
    return _none(
        *(f"force-error-{name}", "IV-A", f"Mean relative error of {of}", "1", paper, printed),
        reason=_UNSEEN + more,
        note=f"The peaks alone differ by {peaks}: see the errata",
    )


FORCE_ROWS = (
    *_largest("thrust", 34.1, 38.4, THRUST, _thrust),
    *_largest("normal force", 380.1, 427.4, NORMAL, _normal),
    _fem(
        *("thrust-two-phase", "IV-A", "Largest thrust of two phases", "N", 43.1, "43.1 N"),
        comparison="value",
        band=THRUST * 43.1,
        reason=_reason(THRUST, "thrust"),
        source=RowSource(_two_phase),
        figure="fig2-thrust",
    ),
    _claim(
        *("thrust-aligned", "IV-A", "Thrust at the aligned and unaligned positions"),
        *("N", 0.0, "0 N"),
        comparison="value",
        band=0.5,
        reason="half of the last printed digit, 0.5 N",
        note="By symmetry: any model of teeth with two like flanks has it",
        source=RowSource(_at_rest),
        figure="fig2-thrust",
    ),
    PrintedNumber(
        *("thrust-required", "II-A-2", "The thrust meets the requirement f_max"),
        *("N", 32.0, "32 N"),
        group=FORCES,
        kind="claim",
        comparison="at_least",
        band=0.0,
        reason="a requirement: met or not",
        basis=f"largest thrust of one phase; {_BASIS}",
        source=RowSource(_thrust),
        doing=_DOING,
        figure="fig2-thrust",
    ),
    PrintedNumber(
        *("phases-at-once", "II-B", "Largest number of phases excited at once on an axis"),
        *("1", 2.0, "two on each axis"),
        group=FORCES,
        kind="claim",
        comparison="value",
        band=0.0,
        reason="a whole number",
        basis="current commands along the pentagram, matched motor, LuGre observer",
        source=RowSource(_phases_at_once),
        doing="pentagram",
    ),
    _error(
        *("thrust", "thrust, FEM against measurement", (0.0003, 0.1111), "0.03 % to 11.11 %"),
        "; at aligned and unaligned a relative error of 0 N is not defined",
    ),
    _error(
        *("elsewhere", "thrust elsewhere than aligned and unaligned", 0.0189),
        "less than 1.89 %",
    ),
    _error(
        *("normal", "normal force, FEM against measurement", (0.0065, 0.0282)),
        "0.65 % to 2.82 %",
    ),
    *(
        PrintedNumber(
            *(f"fem-{name}", "II-A-2", f"{quantity} of the finite elements", unit, paper, printed),
            group=FORCES,
            kind="input",
            reason=_GRID,
        )
        for name, quantity, unit, paper, printed in (
            ("currents", "Currents", "A", (1.0, 10.0), "1 to 10 A"),
            ("current-step", "Interval of the currents", "A", 1.0, "intervals of 1 A"),
            ("positions", "Positions", "m", (0.0, 7.2e-3), "0 to 7.2 mm"),
        )
    ),
)


def _figure(experiments: Experiments, name: str) -> PaperFigure:
    """Return one part of Fig. 2: a curve each 2 A over a pitch, and the peaks that are printed."""
    force_map = experiments.force_map()
    x = np.linspace(0.0, force_map.tau, 145)
    about_aligned = x - force_map.tau / 2
    of, peaks = {
        "thrust": (force_map.thrust, (34.1, 38.4)),
        "normal force": (force_map.normal_force, (380.1, 427.4)),
    }[name]
    curves = [
        figure_series(
            f"{current:g} A",
            "B" if current == I_PEAK else "reference",
            x,
            of(about_aligned, np.full(len(x), current)),
        )
        for current in (2.0, 4.0, 6.0, 8.0, I_PEAK)
    ]
    top = int(np.argmax(of(about_aligned, np.full(len(x), I_PEAK))))
    points = [
        figure_series(label, "printed", x[top : top + 1], np.array([peak]), kind="points")
        for label, peak in zip(("FEM", "measured"), peaks, strict=True)
    ]
    part = "a" if name == "thrust" else "b"
    return PaperFigure(
        id=f"fig2-{name.split(maxsplit=1)[0]}",
        group=FORCES,
        title=f"Fig. 2({part}): {name}",
        about="One phase, by our finite elements, from unaligned to unaligned. The points are the "
        "peaks that the paper prints, drawn where ours peaks; its curves are printed nowhere.",
        x=FigureAxis(label="position", unit="m"),
        y=FigureAxis(label=name, unit="N"),
        series=[*curves, *points],
        bounds=[],
    )


FORCE_FIGURES: dict[str, Build] = {
    f"fig2-{name.split()[0]}": partial(_figure, name=name) for name in ("thrust", "normal force")
}


FRICTION = "friction"

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
        group=FRICTION,
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


FRICTION_ROWS = tuple(_row(axis, name) for axis in "xy" for name in _WHAT)


def _friction_figure(experiments: Experiments, axis: str) -> PaperFigure:
    """Return the friction over velocity of an axis: measured points and the printed curve."""
    sigma_2, F_c, F_s, v_s = (float(digits) for digits in _PRINTED[axis][2:])
    v = np.linspace(-0.15, 0.15, 301)
    identified = experiments.identification().axes[axis].points
    points = np.array(sorted((point.velocity, point.force) for point in identified))
    return PaperFigure(
        id=f"friction-{axis}",
        group=FRICTION,
        title=f"Friction over velocity, {axis}",
        about="Mean force command of uniform motions on the nominal motor, and the curve of the "
        "printed parameters.",
        x=FigureAxis(label="velocity", unit="m/s"),
        y=FigureAxis(label="friction", unit="N"),
        series=[
            figure_series(
                "printed parameters", "reference", v, steady_friction(v, F_c, F_s, v_s, sigma_2)
            ),
            figure_series("measured", "B", points[:, 0], points[:, 1], kind="points"),
        ],
        bounds=[],
    )


FRICTION_FIGURES: dict[str, Build] = {
    f"friction-{axis}": partial(_friction_figure, axis=axis) for axis in "xy"
}
