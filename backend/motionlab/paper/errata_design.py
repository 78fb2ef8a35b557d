"""Errata of section II: sizing, forces, platforms, velocities."""

from __future__ import annotations

import math

from motionlab.motor_design import equations as eq
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.paper.design import inductance_ratio, stack_length
from motionlab.paper.documents import Erratum
from motionlab.paper.experiments import Experiments
from motionlab.paper.printed_number import step

_TAU, _S, _N_PAIRS = 7.2e-3, 3.6e-3, 3


def width(_: Experiments) -> Erratum:
    """Return that (3) is one limb."""
    one = eq.mover_width(tau=_TAU, s=_S, n=_N_PAIRS, limbs=1)
    two = eq.mover_width(tau=_TAU, s=_S, n=_N_PAIRS, limbs=2)
    return Erratum(
        id="eq3",
        place="(3)",
        as_scanned=True,
        printed="w = n tau - s, and w = 39.6 mm for n = 3",
        corrected="w = 2 n tau - s: the mover has two limbs of n teeth",
        steps=[step("n tau - s", one, "m"), step("2 n tau - s", two, "m")],
        shown=math.isclose(one, 18e-3) and math.isclose(two, 39.6e-3),
    )


def gap_area(experiments: Experiments) -> Erratum:
    """Return that the further tooth share in (4) means square posts."""
    d = experiments.design()
    rating = d.rating
    assert rating is not None and d.dimensions is not None, "the paper's example has dimensions"
    posts = rating.A_g.value or 0.0
    bars = d.dimensions.n * d.dimensions.teeth[0] * d.dimensions.l_m
    facing = bars * Geometry().post
    return Erratum(
        id="eq4",
        place="(4)",
        as_scanned=False,
        printed="A_g = n p l_m sigma/(1 + sigma): n p are teeth already, the share counts them "
        "twice",
        corrected="right if the stator has square posts that face half of the stack; n then counts "
        "one limb's teeth",
        steps=[
            step("teeth of one limb along the whole stack, n p l_m", bars, "m^2"),
            step("what square posts, every other half of the stack, face of it", facing, "m^2"),
            step("A_g by (4)", posts, "m^2"),
        ],
        shown=math.isclose(facing, posts),
    )


def interval(experiments: Experiments) -> Erratum:
    """Return that t in (7) and (8) is the interval."""
    rating = experiments.design().rating
    assert rating is not None, "the paper's example has dimensions"
    dpsi, dt, u = (r.value or 0.0 for r in (rating.dpsi, rating.dt, rating.u))
    return Erratum(
        id="eq7",
        place="(7), (8)",
        as_scanned=True,
        printed="t is the time from aligned to unaligned",
        corrected="Delta t is; so by the definition of a mean voltage: nothing here could come out "
        "otherwise",
        steps=[
            step("Delta psi", dpsi, "Wb"),
            step("Delta t = 0.5 tau/v_max", dt, "s"),
            step("u = Delta psi/Delta t", dpsi / dt, "V"),
            step("u by (9)", u, "V"),
        ],
        shown=math.isclose(dpsi / dt, u),
    )


def first_factor(experiments: Experiments) -> Erratum:
    """Return the two readings of K_1."""
    K_1 = experiments.design().sizing.K_1
    return Erratum(
        id="eq10",
        place="(10)",
        as_scanned=True,
        printed="K_1 = 2(n + n sigma - - 1)/(1 + sigma)",
        corrected="K_1 = 2 w/tau: 5 for one limb, which one minus sign gives, 11 for the real "
        "width",
        steps=[
            step("one minus sign", K_1.printed_value, "1"),
            step("2 w/tau, one limb", 2.0 * 18e-3 / _TAU, "1"),
            step("2 w/tau, w = 39.6 mm", K_1.value, "1"),
        ],
        shown=math.isclose(K_1.printed_value or 0.0, 5.0) and math.isclose(K_1.value or 0.0, 11.0),
    )


def lengths(experiments: Experiments) -> Erratum:
    """Return the lambda that 42.3 mm requires by either reading, and the true one."""
    rating = experiments.design().rating
    assert rating is not None, "the paper's example has dimensions"
    needed = rating.lambda_needed
    ratio = inductance_ratio(experiments)
    printed = stack_length(ratio, 5.0, experiments)
    used = stack_length(ratio, 11.0, experiments)
    return Erratum(
        id="eq13",
        place="(12), (13)",
        as_scanned=False,
        printed="one limb's n in K_1, the width of both in A; l_m = 42.3 mm; no lambda",
        corrected="the same width in both: K_1 = 11",
        steps=[
            step("lambda that 42.3 mm needs, as printed", needed.printed_value, "1"),
            step("lambda that 42.3 mm needs, consistently", needed.value, "1"),
            step("lambda at 1 A by finite elements", ratio, "1"),
            step("l_m with that lambda, as printed", printed, "m"),
            step("l_m with that lambda, consistently", used, "m"),
        ],
        shown=abs(used - 42.3e-3) < 0.15 * 42.3e-3 < abs(printed - 42.3e-3),
    )


def turns(experiments: Experiments) -> Erratum:
    """Return that (14) is no whole number, and which electric loading it means."""
    rating = experiments.design().rating
    assert rating is not None, "the paper's example has dimensions"
    exact = rating.N_needed.value or 0.0
    return Erratum(
        id="eq14",
        place="(14), (11)",
        as_scanned=False,
        printed="N = 145; no electric loading",
        corrected="144.17, rounded up; A = N i/w follows",
        steps=[step("N by (14)", exact, "1"), step("A by (11)", rating.A.value, "A/m")],
        shown=math.ceil(exact) == 145 and exact < 144.5,
    )


def velocities(experiments: Experiments) -> Erratum:
    """Return that the largest velocities follow two formulas and a mass that is not printed."""
    rating = experiments.design().rating
    assert rating is not None, "the paper's example has dimensions"
    x, y = rating.x, rating.y
    return Erratum(
        id="velocities",
        place="II-B, IV-A",
        as_scanned=False,
        printed="1.01 and 0.89 m/s with one phase, 1.58 and 1.34 m/s with two; higher than "
        "1.01 m/s with two phases",
        corrected="two formulas: sqrt(f s/M), rest to rest, for one phase; sqrt(2 f s/M), which "
        "leaves nothing to brake, for two. 0.89 m/s needs a mass that is not printed",
        steps=[
            step("x, one phase: 34.1 N, 170 mm, 5.7 kg", x.velocity_single_phase.value, "m/s"),
            step("y, one phase: 34.1 N, 290 mm, 13.9 kg", y.velocity_single_phase.value, "m/s"),
            step("mass that 0.89 m/s needs", y.mass_for_printed_velocity.value, "kg"),
            step("x, two phases, whole stroke", x.velocity_two_phase.value, "m/s"),
            step("y, two phases, whole stroke", y.velocity_two_phase.value, "m/s"),
            step("x, two phases, to rest", x.velocity_two_phase_rest_to_rest.value, "m/s"),
            step("y, two phases, to rest", y.velocity_two_phase_rest_to_rest.value, "m/s"),
        ],
        shown=(y.velocity_single_phase.value or 1.0) < 0.885
        and (y.velocity_two_phase_rest_to_rest.value or 2.0) < 1.01,
    )


def deformation(_: Experiments) -> Erratum:
    """Return that the printed reduction of the y plate contradicts the printed lengths."""
    share = 1.0 - 34.18 / 126.36
    return Erratum(
        id="deformation",
        place="II-B",
        as_scanned=True,
        printed="0.12636 mm to 0.03418 mm is a decrease of 72.5 %",
        corrected="73.0 %; the other one, 74.9 %, is right",
        steps=[
            step("1 - 34.18/126.36", share, "1"),
            step("1 - 4.05/16.12", 1.0 - 4.05 / 16.12, "1"),
        ],
        shown=abs(share - 0.725) > 0.0011,
    )


def platform_load(_: Experiments) -> Erratum:
    """Return that 400 N is not above the largest normal force."""
    load, computed, measured = 400.0, 380.1, 427.4
    return Erratum(
        id="platform-load",
        place="II-B, IV-A",
        as_scanned=False,
        printed="400 N, slightly larger than the maximum normal force",
        corrected="larger than the computed 380.1 N, smaller than the measured 427.4 N",
        steps=[
            step("400 N less 380.1 N", load - computed, "N"),
            step("400 N less 427.4 N", load - measured, "N"),
        ],
        shown=computed < load < measured,
    )


ERRATA = (
    width,
    gap_area,
    interval,
    first_factor,
    lengths,
    turns,
    velocities,
    deformation,
    platform_load,
)
