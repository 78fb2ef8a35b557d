"""Section II-A: the motor's dimensions, equations (1) to (14)."""

from __future__ import annotations

from motionlab.design import equations as eq
from motionlab.design.fem.geometry import Geometry
from motionlab.studies.paper.experiments import Experiments
from motionlab.studies.paper.printed_number import (
    Found,
    Quantity,
    by_design,
    from_design,
    not_comparable,
)

GROUP = "sizing"
FEM_THRUST = 0.15
"""What the finite elements' thrust is worth: the paper leaves the cross-section partly open."""

_DIGIT = "half of the last printed digit"
_TOOTH = _SLOT = 3.6e-3


def inductance_ratio(experiments: Experiments) -> float:
    """Return the aligned inductance over the unaligned one at 1 A, by finite elements."""
    force_map = experiments.force_map()
    aligned, unaligned = force_map.linkage([0.0, force_map.tau / 2], [1.0, 1.0])
    return float(aligned / unaligned)


def stack_length(ratio: float, K_1: float, experiments: Experiments) -> float:
    """Return l_m of eq. (13), m, for an inductance ratio and a reading of K_1."""
    d = experiments.design()
    r, s = d.requirements, d.sizing
    area = eq.gap_area_for_thrust(
        f_max=r.f_max,
        K_e=r.K_e,
        K_d=r.K_d,
        K_1=K_1,
        K_2=eq.K_2(ratio=ratio),
        B_g=r.B_g,
        loading=_used(s.A.value),
    )
    return eq.stack_length(A_g=area, n=r.n, p=r.teeth[0], sigma=_used(s.sigma.value))


def _used(value: float | None) -> float:
    assert value is not None, "the paper's example has every value"
    return value


def _stack_length(experiments: Experiments) -> Found:
    ratio = inductance_ratio(experiments)
    K_1 = experiments.design().sizing.K_1
    used, printed = (
        stack_length(ratio, _used(value), experiments) for value in (K_1.value, K_1.printed_value)
    )
    return Found(used, {"with K_1 as printed, 5": printed})


def _height(_: Experiments) -> Found:
    g = Geometry()
    return Found(g.tooth_depth + g.shoe + g.window + g.yoke)


def _path(_: Experiments) -> Found:
    """Return the mean path: up one limb, along the yoke, down the other, and back below."""
    g = Geometry()
    down = g.tooth_depth + g.shoe / 2
    return Found(
        2 * (g.stator_tooth_depth + g.stator_back / 2 + down + g.shoe / 2 + g.window + g.yoke / 2)
        + 2 * (g.width - g.limb)
    )


QUANTITIES = (
    Quantity(
        id="power",
        group=GROUP,
        kind="arithmetic",
        place="(1)",
        quantity="Power of one axis P_max = f_max v_max",
        unit="W",
        paper=32.0,
        printed="f_max v_max of 32 N and 1 m/s",
        comparison="value",
        band=0.5,
        reason=f"{_DIGIT} of 32 N",
        basis="32 N times 1 m/s",
        note="The paper prints no power: both sides are the same product",
        compute=from_design("sizing.P_max.value"),
        recipe=by_design("sizing.P_max.value"),
    ),
    Quantity(
        id="pole-pitch",
        group=GROUP,
        kind="arithmetic",
        place="(2)",
        quantity="Pole pitch tau = p + s, teeth as wide as slots",
        unit="m",
        paper=7.2e-3,
        printed="7.2 mm",
        comparison="value",
        band=0.05e-3,
        reason=f"{_DIGIT}, 0.05 mm",
        basis="the sum of the printed p and s",
        note="The pitch is a choice, and (2) gives p and s from it: it only adds up",
        compute=lambda _: Found(_TOOTH + _SLOT),
        doing="arithmetic",
    ),
    *(
        not_comparable(
            f"{name}-width",
            GROUP,
            "II-A-2",
            f"{name.capitalize()} width {symbol}",
            kind="input",
            unit="m",
            paper=width,
            printed=f"{symbol} = 3.6 mm",
            reason="said to follow from (2), which gives their sum: equal widths are a choice",
        )
        for name, symbol, width in (("tooth", "p", _TOOTH), ("slot", "s", _SLOT))
    ),
    not_comparable(
        "pitch-multiple",
        GROUP,
        "II-A-2",
        "The pole pitch should be a multiple of 3",
        paper=3.0,
        printed="a multiple of 3",
        reason="without a unit every length is a multiple of 3: 7.2 mm are 3 times 2.4 mm, as the "
        "previous 9 mm are 3 times 3 mm",
    ),
    Quantity(
        id="efficiency-range",
        group=GROUP,
        kind="arithmetic",
        place="II-A-1",
        quantity="Efficiency K_e, usual range",
        unit="1",
        paper=(0.65, 0.75),
        printed="0.65 to 0.75",
        comparison="within",
        band=0.0,
        reason="a rule of thumb with round ends, taken as printed",
        basis="the 0.7 that the paper chooses",
        compute=lambda _: Found(0.7),
        doing="arithmetic",
    ),
    Quantity(
        id="mover-width",
        group=GROUP,
        kind="arithmetic",
        place="(3)",
        quantity="Mover width w",
        unit="m",
        paper=39.6e-3,
        printed="39.6 mm",
        comparison="value",
        band=0.05e-3,
        reason=f"{_DIGIT}, 0.05 mm",
        basis="sizing, two limbs: 2 n tau - s",
        note="(3) as printed is one limb, 18 mm: see the errata",
        compute=from_design("sizing.w.value"),
        recipe=by_design("sizing.w.value"),
    ),
    Quantity(
        id="turns",
        group=GROUP,
        kind="arithmetic",
        place="(14)",
        quantity="Turns of a phase N",
        unit="1",
        paper=145.0,
        printed="145 turns",
        comparison="value",
        band=0.0,
        reason="a whole number",
        basis="sizing: 144.17 rounded up",
        compute=from_design("sizing.N.value"),
        recipe=by_design("sizing.N.value"),
    ),
    Quantity(
        id="electric-loading",
        group=GROUP,
        kind="arithmetic",
        place="(11)",
        quantity="Electric loading A, usual range",
        unit="A/m",
        paper=(25e3, 90e3),
        printed="25000 to 90000 A/m",
        comparison="within",
        band=0.0,
        reason="a rule of thumb with round ends, taken as printed",
        basis="sizing, over the whole width",
        compute=from_design("sizing.A.value"),
        recipe=by_design("sizing.A.value"),
    ),
    Quantity(
        id="flux-density",
        group=GROUP,
        kind="arithmetic",
        place="II-A-2",
        quantity="Gap flux density B_g that 145 turns at 10 A reach",
        unit="T",
        paper=1.5,
        printed="1.5 T",
        comparison="value",
        band=0.05,
        reason=f"{_DIGIT}, 0.05 T",
        basis="rating: (14) solved for B_g",
        compute=from_design("rating.B_g_reached.value"),
        recipe=by_design("rating.B_g_reached.value"),
    ),
    Quantity(
        id="stack-length",
        group=GROUP,
        place="(13)",
        quantity="Stack length l_m",
        unit="m",
        paper=42.3e-3,
        printed="42.3 mm",
        comparison="value",
        band=FEM_THRUST * 42.3e-3,
        reason="15 %: what finite elements of a partly open cross-section are worth; they give the "
        "lambda that the paper does not print",
        basis="(13) with K_1 = 2 w/tau = 11 and lambda at 1 A by finite elements",
        note="K_1 = 11 is our reading and not printed; with K_1 as printed no lambda near that of "
        "finite elements gives 42.3 mm: errata",
        compute=_stack_length,
        doing="force map by finite elements",
    ),
    Quantity(
        id="mover-height",
        group=GROUP,
        place="II-A-2",
        quantity="Mover height h",
        unit="m",
        paper=36.0e-3,
        printed="36.0 mm",
        comparison="value",
        band=0.05e-3,
        reason=f"{_DIGIT}, 0.05 mm",
        basis="the cross-section of the finite elements: teeth, shoe, window and yoke",
        kind="fit",
        note="That cross-section was chosen to fit",
        compute=_height,
    ),
    Quantity(
        id="iron-path",
        group=GROUP,
        place="II-A-2",
        quantity="Mean path along stator and mover l_a",
        unit="m",
        paper=145.1e-3,
        printed="145.1 mm",
        comparison="value",
        band=0.05e-3,
        reason=f"{_DIGIT}, 0.05 mm",
        basis="the cross-section of the finite elements, along its middle",
        kind="fit",
        note="That cross-section was chosen to fit",
        compute=_path,
    ),
)
