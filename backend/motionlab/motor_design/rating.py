"""From dimensions to limits: electrical ones, and velocity and acceleration of each axis."""

from __future__ import annotations

from motionlab.motor_design import equations as eq
from motionlab.motor_design import readings
from motionlab.motor_design.document import AxisRating, Rating, Reading
from motionlab.motor_design.inputs import Axis, Dimensions
from motionlab.motor_design.presets import ACCELERATION, VELOCITY_SINGLE_PHASE, VELOCITY_TWO_PHASE
from motionlab.motor_design.readings import reading

_NUMBER_ONLY = "a number without formula"


def rate(dimensions: Dimensions) -> Rating:
    """Return limits and requirements of a machine of given dimensions.

    Parameters
    ----------
    dimensions : Dimensions
        Teeth, gap, stack, turns, forces, masses and strokes; SI.

    Returns
    -------
    Rating
        As printed and as used.
    """
    d = dimensions.resolved()
    p, s = d.teeth
    A_g = eq.gap_area(n=d.n, p=p, l_m=d.l_m, sigma=eq.tooth_ratio(p=p, s=s))
    A = eq.electric_loading(N=d.N, i=d.i, w=readings.mover_width(d))
    K_2 = eq.K_2(ratio=d.lambda_)
    psi = eq.flux_linkage(B_g=d.B_g, A_g=A_g, N=d.N)
    N_needed = eq.turns(H_a=d.H_a, l_a=d.l_a, g=d.g, B_g=d.B_g, i=d.i)
    rating = Rating(
        P_specified=readings.specified_power(d),
        w=readings.width(d),
        A_g=reading(
            "gap area of one limb A_g",
            A_g,
            "m^2",
            form="n p l_m sigma/(1 + sigma)",
            equation="(4)",
            remark=f"n p alone are teeth already; the further share sigma/(1 + sigma) is right if "
            f"the stator has square posts, which face that share of the stack. With bars along all "
            f"of it: n p l_m = {d.n * p * d.l_m * 1e6:.4g} mm^2",
        ),
        A=readings.loading(d, d.N),
        N_needed=reading(
            "turns needed for B_g",
            N_needed,
            "1",
            form="(H_a l_a + 2 g B_g/mu_0)/i",
            equation="(14)",
            remark=f"not rounded; the machine has {d.N}",
        ),
        B_g_reached=reading(
            "flux density that N i reaches",
            eq.flux_density(H_a=d.H_a, l_a=d.l_a, g=d.g, N=d.N, i=d.i),
            "T",
            form="mu_0 (N i - H_a l_a)/(2 g), from (14)",
        ),
        K_1=readings.first_factor(d),
        K_2=readings.second_factor(d),
        lambda_needed=readings.inductance_ratio(d, A_g, A),
        psi=readings.aligned_flux(d, A_g, d.N),
        L_a=reading("aligned inductance L_a", psi / d.i, "H", form="B_g A_g N/i", equation="(6)"),
        L_u=reading("unaligned inductance L_u", psi / d.i / d.lambda_, "H", form="L_a/lambda"),
        dt=readings.unaligning_time(d),
        dpsi=reading(
            "change of flux linkage Delta psi",
            K_2 * psi,
            "Wb",
            form="L_a (1 - 1/lambda) i",
            equation="(7)",
            remark="as scanned, (7) has L_0 for L_u",
        ),
        u=readings.voltage(d, psi),
        **_capacity(d, A_g, A),
        x=_axis("x", d.x, d),
        y=_axis("y", d.y, d),
        warnings=readings.loading_warnings(d, A),
    )
    rating.warnings.extend(_shortfalls(d, rating, N_needed))
    return rating


def _capacity(d: Dimensions, A_g: float, A: float) -> dict[str, Reading]:
    """Return the power capacity at v_max, eq. (10), and the corresponding thrust, eq. (1)."""

    def power(K_1: float) -> float:
        return eq.power_capacity(
            K_e=d.K_e,
            K_d=d.K_d,
            K_1=K_1,
            K_2=eq.K_2(ratio=d.lambda_),
            A_g=A_g,
            B_g=d.B_g,
            v_max=d.v_max,
            loading=A,
        )

    printed, used = power(readings.printed_K_1(d)), power(readings.used_K_1(d))
    remark = f"with lambda = {d.lambda_:g}" + (f"; {readings.MIXED}" if d.limbs > 1 else "")
    form = "K_e K_d K_1 K_2 A_g B_g v_max A"
    return {
        "P_max": Reading(
            quantity="power capacity P_max",
            equation="(10)",
            printed_form=f"{form}, K_1 = {readings.PRINTED_K_1}",
            used_form=f"{form}, K_1 = 2 w/tau",
            printed_value=printed,
            value=used,
            unit="W",
            remark=remark,
        ),
        "f_max": Reading(
            quantity="thrust capacity f",
            equation="(1), (10)",
            printed_form=f"P_max/v_max, K_1 = {readings.PRINTED_K_1}",
            used_form="P_max/v_max, K_1 = 2 w/tau",
            printed_value=printed / d.v_max,
            value=used / d.v_max,
            unit="N",
            remark=remark,
        ),
    }


def _axis(name: str, axis: Axis, d: Dimensions) -> AxisRating:
    f_1, f_2 = d.single_phase_force, d.two_phase_force
    platform = axis.platform_mass or axis.mass
    published = (axis, f_1, f_2) == _PUBLISHED[name]
    printed = VELOCITY_SINGLE_PHASE[name] if published else None
    single = eq.velocity_rest_to_rest(f=f_1, stroke=axis.stroke, M=platform)
    two = eq.velocity_whole_stroke(f=f_2, stroke=axis.stroke, M=axis.mass)
    return AxisRating(
        acceleration=_number(
            f"largest acceleration, two phases, {name}",
            "f/M",
            eq.acceleration(f=f_2, M=axis.mass),
            ACCELERATION[name] if published else None,
            "m/s^2",
            f"{f_2:g} N over {axis.mass:g} kg",
        ),
        velocity_single_phase=_number(
            f"largest velocity, one phase, {name}",
            "sqrt(f stroke/M)",
            single,
            printed,
            "m/s",
            _single_phase_remark(axis, platform, f_1, printed, single),
        ),
        velocity_two_phase=_number(
            f"velocity after the whole stroke, two phases, {name}",
            "sqrt(2 f stroke/M)",
            two,
            VELOCITY_TWO_PHASE[name] if published else None,
            "m/s",
            "another formula than for one phase: nothing of the stroke is left to brake",
        ),
        velocity_two_phase_rest_to_rest=reading(
            f"largest velocity, two phases, {name}",
            eq.velocity_rest_to_rest(f=f_2, stroke=axis.stroke, M=axis.mass),
            "m/s",
            form="sqrt(f stroke/M)",
            remark="the formula of one phase: half of the stroke is left to brake",
        ),
        mass_for_printed_velocity=Reading(
            quantity=f"mass for the printed velocity, one phase, {name}",
            equation="",
            printed_form=f"M = {platform:g} kg" if published else "",
            used_form="f stroke/v^2",
            printed_value=platform if published else None,
            value=eq.mass_for_velocity(f=f_1, stroke=axis.stroke, v=printed) if printed else None,
            unit="kg",
            remark=f"v = {printed:g} m/s as printed" if printed else "",
        ),
    )


def _number(  # noqa: PLR0913, PLR0917 - what differs between rows of one form
    quantity: str, form: str, value: float, printed: float | None, unit: str, remark: str
) -> Reading:
    """Return a reading of which the paper prints a number and no formula."""
    return Reading(
        quantity=quantity,
        equation="",
        printed_form="" if printed is None else _NUMBER_ONLY,
        used_form=form,
        printed_value=printed,
        value=value,
        unit=unit,
        remark=remark,
    )


def _single_phase_remark(
    axis: Axis, platform: float, f: float, printed: float | None, value: float
) -> str:
    remark = f"{f:g} N, {axis.stroke:g} m, {platform:g} kg"
    if platform != axis.mass:
        moving = eq.velocity_rest_to_rest(f=f, stroke=axis.stroke, M=axis.mass)
        remark += f", the platform alone; with the moving mass of {axis.mass:g} kg {moving:.3g} m/s"
    if printed is not None and f"{value:.2f}" != f"{printed:.2f}":
        mass = eq.mass_for_velocity(f=f, stroke=axis.stroke, v=printed)
        remark += f"; {printed:g} m/s needs {mass:.1f} kg, a mass that the paper does not print"
    return remark


def _shortfalls(d: Dimensions, rating: Rating, N_needed: float) -> list[str]:
    """Return a warning for each specified value that the machine does not reach."""
    shortfalls = []
    if N_needed > d.N:
        shortfalls.append(f"N = {d.N} turns are fewer than the {N_needed:.2f} that B_g needs")
    if rating.lambda_needed.value is None:
        shortfalls.append(f"no lambda gives f_max = {d.f_max:g} N with these dimensions")
    if d.single_phase_force < d.f_max:
        shortfalls.append(
            f"single_phase_force = {d.single_phase_force:g} N is below f_max = {d.f_max:g} N"
        )
    for name, axis in (("x", rating.x), ("y", rating.y)):
        for what, velocity in (
            ("one phase", axis.velocity_single_phase.value),
            ("two phases", axis.velocity_two_phase_rest_to_rest.value),
        ):
            if velocity is not None and velocity < d.v_max:
                shortfalls.append(
                    f"{name} reaches {velocity:.3g} m/s from rest to rest with {what}, below "
                    f"v_max = {d.v_max:g} m/s"
                )
    return shortfalls


_EXAMPLE = Dimensions().resolved()
_FORCES = (_EXAMPLE.single_phase_force, _EXAMPLE.two_phase_force)
_PUBLISHED = {"x": (_EXAMPLE.x, *_FORCES), "y": (_EXAMPLE.y, *_FORCES)}
"""For what the paper prints velocities and accelerations."""
