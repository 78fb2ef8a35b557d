"""From requirements to dimensions, eqs (1) to (14)."""

from __future__ import annotations

import math

from pydantic import ValidationError

from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError, FieldError
from motionlab.motor_design import equations as eq
from motionlab.motor_design import readings
from motionlab.motor_design.document import Reading, Sizing
from motionlab.motor_design.inputs import Choices, Requirements, SizedDimensions
from motionlab.motor_design.readings import reading


def size(requirements: Requirements) -> Sizing:
    """Return the dimensions that meet requirements, with every intermediate quantity.

    Parameters
    ----------
    requirements : Requirements
        Thrust, velocity, current, teeth, gap and iron; SI.

    Returns
    -------
    Sizing
        As printed and as used.

    Raises
    ------
    ConfigError
        If the dimensions found are none that a machine could have.
    """
    r = requirements
    p, s = r.teeth
    sigma = eq.tooth_ratio(p=p, s=s)
    exact = eq.turns(H_a=r.H_a, l_a=r.l_a, g=r.g, B_g=r.B_g, i=r.i)
    N = math.ceil(exact)
    A = eq.electric_loading(N=N, i=r.i, w=readings.mover_width(r))
    printed_A_g = _gap_area(r, readings.printed_K_1(r), A)
    A_g = _gap_area(r, readings.used_K_1(r), A)
    printed_l_m = eq.stack_length(A_g=printed_A_g, n=r.n, p=p, sigma=sigma)
    l_m = eq.stack_length(A_g=A_g, n=r.n, p=p, sigma=sigma)
    psi = eq.flux_linkage(B_g=r.B_g, A_g=A_g, N=N)
    remark = readings.MIXED if r.limbs > 1 else ""
    return Sizing(
        P_max=readings.specified_power(r),
        tau=reading("pole pitch tau", r.tau, "m", form="p + s", equation="(2)"),
        sigma=reading("tooth over slot sigma", sigma, "1", form="p/s", equation="(5)"),
        w=readings.width(r),
        N=Reading(
            quantity="turns of a phase N",
            equation="(14)",
            printed_form="(H_a l_a + 2 g B_g/mu_0)/i",
            used_form="(H_a l_a + 2 g B_g/mu_0)/i, rounded up",
            printed_value=exact,
            value=N,
            unit="1",
            remark=f"{exact:.2f} rounded up to whole turns",
        ),
        A=readings.loading(r, N),
        K_1=readings.first_factor(r),
        K_2=readings.second_factor(r),
        A_g=Reading(
            quantity="gap area of one limb A_g",
            equation="(12)",
            printed_form="f_max v_max/(K_e K_d K_1 K_2 B_g v_max N i/w)",
            used_form="f_max/(K_e K_d K_1 K_2 B_g A), K_1 = 2 w/tau",
            printed_value=printed_A_g,
            value=A_g,
            unit="m^2",
            remark=remark,
        ),
        l_m=Reading(
            quantity="stack length l_m",
            equation="(13)",
            printed_form="f_max v_max w (1 + sigma)/(K_e K_d K_1 K_2 B_g v_max N i sigma n p)",
            used_form="A_g (1 + sigma)/(sigma n p), K_1 = 2 w/tau",
            printed_value=printed_l_m,
            value=l_m,
            unit="m",
            remark=remark,
        ),
        lambda_needed=readings.inductance_ratio(r, A_g, A),
        psi=readings.aligned_flux(r, A_g, N),
        dt=readings.unaligning_time(r),
        u=readings.voltage(r, psi),
        dimensions=_core(r, l_m, N),
        warnings=readings.loading_warnings(r, A),
    )


def _gap_area(r: Requirements, K_1: float, A: float) -> float:
    return eq.gap_area_for_thrust(
        f_max=r.f_max,
        K_e=r.K_e,
        K_d=r.K_d,
        K_1=K_1,
        K_2=eq.K_2(ratio=r.lambda_),
        B_g=r.B_g,
        loading=A,
    )


def _core(r: Requirements, l_m: float, N: int) -> SizedDimensions:
    """Return the result in the form of the other direction's input."""
    shared = r.resolved().model_dump(by_alias=True, include=set(Choices.model_fields))
    try:
        return SizedDimensions.model_validate({**shared, "l_m": l_m, "N": N})
    except ValidationError as error:
        raise ConfigError(
            *(
                FieldError(
                    loc="requirements",
                    message=f"lead to a machine whose {e.loc} {e.message}",
                    value=e.value,
                    range=e.range,
                    unit=e.unit,
                    bounds=e.bounds,
                )
                for e in field_errors(error, SizedDimensions)
            )
        ) from None
