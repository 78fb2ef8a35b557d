"""Quantities that both directions share, as printed and as used."""

from __future__ import annotations

from motionlab.motor_design import equations as eq
from motionlab.motor_design.document import Reading
from motionlab.motor_design.inputs import Choices

PRINTED_K_1 = "2 (n + n sigma - 1)/(1 + sigma)"

MIXED = (
    "as printed, n counts the teeth of one limb in K_1 while A is taken over the whole width; "
    "consistently, K_1 = 2 w/tau with the same w"
)


def reading(  # noqa: PLR0913 - one keyword a field of the reading
    quantity: str,
    value: float | None,
    unit: str,
    *,
    form: str,
    equation: str = "",
    remark: str = "",
) -> Reading:
    """Return a reading in which the printed form, if the paper has one, is the one used.

    Parameters
    ----------
    quantity : str
        Name and symbol.
    value : float or None
        In `unit`.
    unit : str
        SI unit.
    form : str
        The formula.
    equation : str, optional
        Number in the paper; without one nothing counts as printed.
    remark : str, optional
        Remark.
    """
    return Reading(
        quantity=quantity,
        equation=equation,
        printed_form=form if equation else "",
        used_form=form,
        printed_value=value if equation else None,
        value=value,
        unit=unit,
        remark=remark,
    )


def specified_power(c: Choices) -> Reading:
    """Return the specified power of one axis, eq. (1)."""
    return reading(
        "power of one axis P_max",
        eq.power(f=c.f_max, v=c.v_max),
        "W",
        form="f_max v_max",
        equation="(1)",
        remark="the paper states the product, not the number",
    )


def width(c: Choices) -> Reading:
    """Return the mover's width, eq. (3): one limb as printed, all limbs as used."""
    _, s = c.teeth
    return Reading(
        quantity="mover width w",
        equation="(3)",
        printed_form="n tau - s",
        used_form="limbs n tau - s",
        printed_value=eq.mover_width(tau=c.tau, s=s, n=c.n, limbs=1),
        value=mover_width(c),
        unit="m",
        remark="as printed it is one limb; the paper's 39.6 mm is 2 n tau - s, two limbs"
        if c.limbs > 1
        else "",
    )


def loading(c: Choices, N: float) -> Reading:
    """Return the electric loading, eq. (11), over one limb as printed, the whole width as used."""
    _, s = c.teeth
    one_limb = eq.mover_width(tau=c.tau, s=s, n=c.n, limbs=1)
    return Reading(
        quantity="electric loading A",
        equation="(11)",
        printed_form="N i/w, w = n tau - s",
        used_form="N i/w, w = limbs n tau - s",
        printed_value=eq.electric_loading(N=N, i=c.i, w=one_limb),
        value=eq.electric_loading(N=N, i=c.i, w=mover_width(c)),
        unit="A/m",
        remark="as printed with the w of (3), one limb" if c.limbs > 1 else "",
    )


def first_factor(c: Choices) -> Reading:
    """Return K_1 of eq. (10), for one limb as printed, for the whole width as used."""
    return Reading(
        quantity="factor K_1",
        equation="(10)",
        printed_form=PRINTED_K_1,
        used_form="2 w/tau",
        printed_value=printed_K_1(c),
        value=used_K_1(c),
        unit="1",
        remark="as scanned there are two minus signs before the 1; the printed form is 2 w/tau of "
        "one limb" + (", not of the real width" if c.limbs > 1 else ""),
    )


def second_factor(c: Choices) -> Reading:
    """Return K_2 of eq. (10)."""
    return reading(
        "factor K_2",
        eq.K_2(ratio=c.lambda_),
        "1",
        form="1 - 1/lambda",
        equation="(10)",
        remark=f"the paper states no lambda{_origin(c)}",
    )


def _origin(c: Choices) -> str:
    """Return where lambda comes from, unless it was set."""
    if c.lambda_ != type(c).model_fields["lambda_"].default:
        return ""
    return (
        f"; {c.lambda_:g} is solved from its l_m = 42.3 mm, which it thus does not confirm; "
        "a force map has its own inductance ratio, and row (13) of Paper has l_m by that"
    )


def inductance_ratio(c: Choices, A_g: float, A: float) -> Reading:
    """Return the lambda with which eqs (12) and (13) give a gap area, by either K_1."""

    def ratio(K_1: float) -> float | None:
        return eq.inductance_ratio(
            f_max=c.f_max, K_e=c.K_e, K_d=c.K_d, K_1=K_1, A_g=A_g, B_g=c.B_g, loading=A
        )

    return Reading(
        quantity="lambda needed for f_max and l_m",
        equation="(12), (13)",
        printed_form=f"(13) solved for lambda, K_1 = {PRINTED_K_1}",
        used_form="(13) solved for lambda, K_1 = 2 w/tau",
        printed_value=ratio(printed_K_1(c)),
        value=ratio(used_K_1(c)),
        unit="1",
        remark="the paper states no lambda" + (f"; {MIXED}" if c.limbs > 1 else ""),
    )


def aligned_flux(c: Choices, A_g: float, N: float) -> Reading:
    """Return the aligned flux linkage, eq. (6)."""
    return reading(
        "aligned flux linkage L_a i",
        eq.flux_linkage(B_g=c.B_g, A_g=A_g, N=N),
        "Wb",
        form="B_g A_g N",
        equation="(6)",
    )


def unaligning_time(c: Choices) -> Reading:
    """Return the time from aligned to unaligned, eq. (8)."""
    return reading(
        "time from aligned to unaligned Delta t",
        eq.time_to_unaligned(tau=c.tau, v_max=c.v_max),
        "s",
        form="0.5 tau/v_max",
        equation="(8)",
        remark="the text beside (7) and (8) writes t for Delta t",
    )


def voltage(c: Choices, psi: float) -> Reading:
    """Return the phase voltage at the largest velocity, eq. (9)."""
    return reading(
        "phase voltage u",
        eq.phase_voltage(tau=c.tau, v_max=c.v_max, K_2=eq.K_2(ratio=c.lambda_), psi=psi),
        "V",
        form="2/tau v_max (1 - 1/lambda) B_g A_g N",
        equation="(9)",
        remark="times K_e K_d i it is the power (10) with K_1 = 2 w/tau",
    )


def mover_width(c: Choices) -> float:
    """Return the width of all limbs, m."""
    _, s = c.teeth
    return eq.mover_width(tau=c.tau, s=s, n=c.n, limbs=c.limbs)


def used_K_1(c: Choices) -> float:
    """Return K_1 of the whole width."""
    return eq.K_1(w=mover_width(c), tau=c.tau)


def printed_K_1(c: Choices) -> float:
    """Return K_1 as printed, of one limb."""
    p, s = c.teeth
    sigma = eq.tooth_ratio(p=p, s=s)
    return 2 * (c.n + c.n * sigma - 1) / (1 + sigma)


def loading_warnings(c: Choices, A: float) -> list[str]:
    """Return a warning if an electric loading is outside of its usual range."""
    if c.loading_min <= A <= c.loading_max:
        return []
    return [
        f"electric loading A = {A:.6g} A/m is outside of {c.loading_min:g} to {c.loading_max:g} A/m"
    ]
