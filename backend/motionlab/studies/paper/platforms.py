"""Section II-B: moving platforms, largest velocities and accelerations."""

from __future__ import annotations

from motionlab.studies.paper.experiments import Experiments
from motionlab.studies.paper.printed_number import (
    Compute,
    Found,
    Quantity,
    by_design,
    from_design,
    look_up,
    not_comparable,
)

GROUP = "platforms"
LIMITS = "limits"

_SHAPE = "the platform's shape is only drawn in Fig. 3"
_DIGIT = "half of the last printed digit"


def _reduction(old: float, new: float) -> Compute:
    def compute(_: Experiments) -> Found:
        return Found(1.0 - new / old)

    return compute


def _deformation(row_id: str, quantity: str, metres: float) -> Quantity:
    return not_comparable(
        row_id,
        GROUP,
        "II-B",
        quantity,
        unit="m",
        paper=metres,
        printed=f"{metres * 1e3:.5f} mm",
        reason=_SHAPE,
    )


def _share(  # noqa: PLR0913, PLR0917 - what differs between two rows of one form
    row_id: str, quantity: str, paper: float, old: float, new: float, note: str = ""
) -> Quantity:
    # The printed share and both printed lengths are rounded.
    lengths = 0.5e-8 / old + 0.5e-8 * new / old**2
    return Quantity(
        id=row_id,
        group=GROUP,
        kind="arithmetic",
        place="II-B",
        quantity=quantity,
        unit="1",
        paper=paper,
        printed=f"{paper:.1%}".replace("%", " %"),
        comparison="value",
        band=0.0005 + lengths,
        reason=f"{_DIGIT}, 0.05 %, and what the rounding of both lengths makes, {lengths:.2%}",
        basis="1 - new/old, of the paper's own lengths",
        note=note,
        compute=_reduction(old, new),
        doing="arithmetic",
    )


def _limit(  # noqa: PLR0913, PLR0917 - what differs between rows of one form
    row_id: str,
    place: str,
    quantity: str,
    paper: float,
    unit: str,
    find: str,
    basis: str,
    note: str = "",
) -> Quantity:
    return Quantity(
        id=row_id,
        group=LIMITS,
        kind="arithmetic",
        place=place,
        quantity=quantity,
        unit=unit,
        paper=paper,
        printed=f"{paper:.2f} {unit}",
        comparison="value",
        band=0.005,
        reason=f"{_DIGIT}, 0.005 {unit}",
        basis=basis,
        note=note,
        compute=from_design(find),
        recipe=by_design(find),
    )


def _requirement(  # noqa: PLR0913 - what differs between rows of one form
    row_id: str, quantity: str, paper: float, axis: str, *, printed: str, note: str = ""
) -> Quantity:
    find = f"rating.{axis}.velocity_two_phase_rest_to_rest.value"

    def compute(experiments: Experiments) -> Found:
        tables = experiments.design().model_dump(by_alias=True)
        return Found(
            look_up(tables, find),
            {"one phase": look_up(tables, f"rating.{axis}.velocity_single_phase.value")},
        )

    return Quantity(
        id=row_id,
        group=LIMITS,
        kind="arithmetic",
        place="II-B",
        quantity=quantity,
        unit="m/s",
        paper=paper,
        printed=printed,
        comparison="at_least",
        band=0.005,
        reason=f"{_DIGIT} of the velocities, 0.005 m/s",
        basis="two phases from rest to rest, printed force and mass, the formula that gives the "
        "printed 1.01 m/s",
        note=note,
        compute=compute,
        recipe=by_design(find),
    )


QUANTITIES = (
    not_comparable(
        "platform-load",
        GROUP,
        "II-B",
        "Normal force of the deformation analysis",
        kind="input",
        unit="N",
        paper=400.0,
        printed="four of 400 N",
        reason="a load that the paper chose",
        note="Called slightly larger than the maximum, it is below the measured 427.4 N: errata",
    ),
    Quantity(
        id="platform-movers",
        group=GROUP,
        kind="arithmetic",
        place="II-B",
        quantity="Movers that are loaded in the deformation analysis",
        unit="1",
        paper=4.0,
        printed="four normal forces on four movers",
        comparison="value",
        band=0.0,
        reason="a whole number",
        basis="the printed two excited phases, on each of two axes",
        compute=lambda _: Found(2.0 * 2.0),
        doing="arithmetic",
    ),
    _deformation("deformation-x-old", "Deformation of the previous x platform", 16.12e-6),
    _deformation("deformation-x-new", "Deformation of the new x platform", 4.05e-6),
    _share("deformation-x-reduction", "Reduction on the x platform", 0.749, 16.12e-6, 4.05e-6),
    _deformation("deformation-y-old", "Deformation of the previous y sliding plate", 126.36e-6),
    _deformation("deformation-y-new", "Deformation of the new y sliding plate", 34.18e-6),
    _share(
        "deformation-y-reduction", "Reduction on the y sliding plate", 0.725, 126.36e-6, 34.18e-6
    ),
    _limit(
        "velocity-single-x",
        "II-B",
        "Largest velocity, one phase, x",
        1.01,
        "m/s",
        "rating.x.velocity_single_phase.value",
        "sqrt(f s/M): 34.1 N, 170 mm, 5.7 kg",
    ),
    _limit(
        "velocity-single-y",
        "II-B",
        "Largest velocity, one phase, y",
        0.89,
        "m/s",
        "rating.y.velocity_single_phase.value",
        "sqrt(f s/M): 34.1 N, 290 mm, 13.9 kg",
        "0.89 m/s would need 12.5 kg, a mass that the paper does not print",
    ),
    _limit(
        "velocity-two-x",
        "IV-A",
        "Largest velocity, two phases, x",
        1.58,
        "m/s",
        "rating.x.velocity_two_phase.value",
        "sqrt(2 f s/M): 43.1 N, 170 mm, 5.9 kg",
        "Another formula than for one phase: nothing of the stroke is left to brake",
    ),
    _limit(
        "velocity-two-y",
        "IV-A",
        "Largest velocity, two phases, y",
        1.34,
        "m/s",
        "rating.y.velocity_two_phase.value",
        "sqrt(2 f s/M): 43.1 N, 290 mm, 13.9 kg",
        "Another formula than for one phase: nothing of the stroke is left to brake",
    ),
    _limit(
        "acceleration-x",
        "IV-A",
        "Largest acceleration, two phases, x",
        7.31,
        "m/s^2",
        "rating.x.acceleration.value",
        "43.1 N over 5.9 kg",
    ),
    _limit(
        "acceleration-y",
        "IV-A",
        "Largest acceleration, two phases, y",
        3.10,
        "m/s^2",
        "rating.y.acceleration.value",
        "43.1 N over 13.9 kg",
    ),
    _requirement(
        "velocity-above-x",
        "Two phases go faster than 1.01 m/s, x",
        1.01,
        "x",
        printed="higher than 1.01 m/s",
    ),
    _requirement(
        "velocity-above-y",
        "Two phases go faster than 1.01 m/s, y",
        1.01,
        "y",
        printed="higher than 1.01 m/s",
    ),
    _requirement(
        "velocity-required-x", "The requirement of 1 m/s is met, x", 1.0, "x", printed="1 m/s"
    ),
    _requirement(
        "velocity-required-y", "The requirement of 1 m/s is met, y", 1.0, "y", printed="1 m/s"
    ),
)
