"""Section II-B: moving platforms, largest velocities and accelerations."""

from __future__ import annotations

from functools import partial

from motionlab.paper.printed_number import PrintedNumber, arithmetic, from_design, percent

GROUP = "platforms"
LIMITS = "limits"

_DIGIT = "half of the last printed digit"
_OTHER_FORMULA = "Another formula than for one phase: nothing of the stroke is left to brake"
_LENGTHS = {
    "x": ("x platform", 16.12e-6, 4.05e-6, 0.749),
    "y": ("y sliding plate", 126.36e-6, 34.18e-6, 0.725),
}
"""Deformation of the previous and the new platform, m, and the printed reduction."""

_judged = partial(PrintedNumber, kind="arithmetic")


def _deformation(axis: str) -> list[PrintedNumber]:
    plate, old, new, paper = _LENGTHS[axis]
    # The printed share and both printed lengths are rounded.
    lengths = 0.5e-8 / old + 0.5e-8 * new / old**2
    seen = [
        PrintedNumber(
            *(f"deformation-{axis}-{age}", "II-B", f"Deformation of the {name} {plate}"),
            *("m", metres, f"{metres * 1e3:.5f} mm"),
            group=GROUP,
            kind="no_data",
            reason="the platform's shape is only drawn in Fig. 3",
        )
        for age, name, metres in (("old", "previous", old), ("new", "new", new))
    ]
    return [
        *seen,
        _judged(
            *(f"deformation-{axis}-reduction", "II-B", f"Reduction on the {plate}"),
            *("1", paper, percent(paper)),
            group=GROUP,
            comparison="value",
            band=0.0005 + lengths,
            reason=f"{_DIGIT}, 0.05 %, and what the rounding of both lengths makes, {lengths:.2%}",
            basis="1 - new/old, of the paper's own lengths",
            source=arithmetic(1.0 - new / old),
            doing="arithmetic",
        ),
    ]


def _limit(name: str, paper: float, find: str, basis: str, note: str = "") -> PrintedNumber:
    what, *_, axis = name.split("-")
    place, phases = ("II-B", "one phase") if find == _ONE else ("IV-A", "two phases")
    unit = "m/s" if what == "velocity" else "m/s^2"
    return _judged(
        *(name, place, f"Largest {what}, {phases}, {axis}", unit, paper, f"{paper:.2f} {unit}"),
        group=LIMITS,
        comparison="value",
        band=0.005,
        reason=f"{_DIGIT}, 0.005 {unit}",
        basis=basis,
        note=note,
        source=from_design(f"rating.{axis}.{find}.value"),
    )


def _requirement(name: str, paper: float, printed: str, quantity: str) -> list[PrintedNumber]:
    return [
        _judged(
            *(f"{name}-{axis}", "II-B", f"{quantity}, {axis}", "m/s", paper, printed),
            group=LIMITS,
            comparison="at_least",
            band=0.005,
            reason=f"{_DIGIT} of the velocities, 0.005 m/s",
            basis="two phases from rest to rest, printed force and mass, the formula that gives "
            "the printed 1.01 m/s",
            source=from_design(
                f"rating.{axis}.velocity_two_phase_rest_to_rest.value",
                {"one phase": f"rating.{axis}.velocity_single_phase.value"},
            ),
        )
        for axis in "xy"
    ]


_MASS = "0.89 m/s would need 12.5 kg, a mass that the paper does not print"
_ONE, _TWO = "velocity_single_phase", "velocity_two_phase"
_FAST = ("sqrt(f s/M): 34.1 N", "sqrt(2 f s/M): 43.1 N")

QUANTITIES = (
    PrintedNumber(
        *("platform-load", "II-B", "Normal force of the deformation analysis"),
        *("N", 400.0, "four of 400 N"),
        group=GROUP,
        kind="input",
        reason="a load that the paper chose",
        note="Called slightly larger than the maximum, it is below the measured 427.4 N: errata",
    ),
    _judged(
        *("platform-movers", "II-B", "Movers that are loaded in the deformation analysis"),
        *("1", 4.0, "four normal forces on four movers"),
        group=GROUP,
        comparison="value",
        band=0.0,
        reason="a whole number",
        basis="the printed two excited phases, on each of two axes",
        source=arithmetic(2.0 * 2.0),
        doing="arithmetic",
    ),
    *_deformation("x"),
    *_deformation("y"),
    _limit("velocity-single-x", 1.01, _ONE, f"{_FAST[0]}, 170 mm, 5.7 kg"),
    _limit("velocity-single-y", 0.89, _ONE, f"{_FAST[0]}, 290 mm, 13.9 kg", _MASS),
    _limit("velocity-two-x", 1.58, _TWO, f"{_FAST[1]}, 170 mm, 5.9 kg", _OTHER_FORMULA),
    _limit("velocity-two-y", 1.34, _TWO, f"{_FAST[1]}, 290 mm, 13.9 kg", _OTHER_FORMULA),
    _limit("acceleration-x", 7.31, "acceleration", "43.1 N over 5.9 kg"),
    _limit("acceleration-y", 3.10, "acceleration", "43.1 N over 13.9 kg"),
    *_requirement(
        "velocity-above", 1.01, "higher than 1.01 m/s", "Two phases go faster than 1.01 m/s"
    ),
    *_requirement("velocity-required", 1.0, "1 m/s", "The requirement of 1 m/s is met"),
)
