"""Equations (1) to (14) and their inverses, Huang et al. 2019, section II-A, as plain functions.

What the paper prints in two readings, such as the mover's width for one limb or two, is one
function here; `motionlab.motor_design.readings` calls it with either.
"""

from __future__ import annotations

import math

MU_0 = 4e-7 * math.pi
"""Permeability of air, H/m."""


def power(*, f: float, v: float) -> float:
    """Return the power of one axis, ``P = f v``, eq. (1), W."""
    return f * v


def tooth_ratio(*, p: float, s: float) -> float:
    """Return the ratio of tooth to slot, ``sigma = p/s``, eq. (5)."""
    return p / s


def mover_width(*, tau: float, s: float, n: int, limbs: int) -> float:
    """Return the mover's width, ``w = limbs n tau - s``, m; eq. (3) has one limb."""
    return limbs * n * tau - s


def gap_area(*, n: int, p: float, l_m: float, sigma: float) -> float:
    """Return the gap area of one limb, aligned, ``A_g = n p l_m sigma/(1 + sigma)``, eq. (4), m^2.

    Square posts as wide as a tooth face the share sigma/(1 + sigma) of the stack.
    """
    return n * p * l_m * sigma / (1 + sigma)


def flux_linkage(*, B_g: float, A_g: float, N: float) -> float:
    """Return the aligned flux linkage, ``L_a i = B_g A_g N``, eq. (6), Wb."""
    return B_g * A_g * N


def time_to_unaligned(*, tau: float, v_max: float) -> float:
    """Return the time from aligned to unaligned, ``Delta t = tau/(2 v_max)``, eq. (8), s."""
    return 0.5 * tau / v_max


def K_1(*, w: float, tau: float) -> float:
    """Return ``K_1 = 2 w/tau`` of eq. (10).

    With one limb this is the printed ``2 (n + n sigma - 1)/(1 + sigma)``.
    """
    return 2 * w / tau


def K_2(*, ratio: float) -> float:
    """Return ``K_2 = 1 - 1/lambda`` of eq. (10), ``lambda = L_a/L_u``."""
    return 1 - 1 / ratio


def phase_voltage(*, tau: float, v_max: float, K_2: float, psi: float) -> float:
    """Return the phase voltage, ``u = 2 v_max K_2 psi/tau``, eqs (7) to (9), V."""
    return 2 / tau * v_max * K_2 * psi


def electric_loading(*, N: float, i: float, w: float) -> float:
    """Return the specific electric loading, ``A = N i/w``, eq. (11), A/m."""
    return N * i / w


def power_capacity(  # noqa: PLR0913 - one keyword a symbol
    *,
    K_e: float,
    K_d: float,
    K_1: float,
    K_2: float,
    A_g: float,
    B_g: float,
    v_max: float,
    loading: float,
) -> float:
    """Return the power capacity, ``P = K_e K_d K_1 K_2 A_g B_g v_max A``, eq. (10), W."""
    return K_e * K_d * K_1 * K_2 * A_g * B_g * v_max * loading


def gap_area_for_thrust(  # noqa: PLR0913 - one keyword a symbol
    *, f_max: float, K_e: float, K_d: float, K_1: float, K_2: float, B_g: float, loading: float
) -> float:
    """Return the gap area, ``A_g = f_max/(K_e K_d K_1 K_2 B_g A)``, eq. (12), m^2.

    The paper's v_max cancels.
    """
    return f_max / (K_e * K_d * K_1 * K_2 * B_g * loading)


def stack_length(*, A_g: float, n: int, p: float, sigma: float) -> float:
    """Return the stack length, ``l_m = A_g (1 + sigma)/(sigma n p)``, eq. (13), m."""
    return A_g * (1 + sigma) / (sigma * n * p)


def inductance_ratio(  # noqa: PLR0913 - one keyword a symbol
    *,
    f_max: float,
    K_e: float,
    K_d: float,
    K_1: float,
    A_g: float,
    B_g: float,
    loading: float,
) -> float | None:
    """Return the ``lambda = L_a/L_u`` with which eq. (12) gives `A_g`; None where none does.

    ``K_2 = f_max/(K_e K_d K_1 B_g A A_g)``, ``lambda = 1/(1 - K_2)``. At K_2 = 1 even an unaligned
    inductance of zero is not enough.
    """
    needed = f_max / (K_e * K_d * K_1 * B_g * loading * A_g)
    return 1 / (1 - needed) if needed < 1 else None


def turns(*, H_a: float, l_a: float, g: float, B_g: float, i: float) -> float:
    """Return the turns of a phase, ``N = (H_a l_a + 2 g B_g/mu_0)/i``, eq. (14), not rounded."""
    return (H_a * l_a + 2 * g * B_g / MU_0) / i


def flux_density(*, H_a: float, l_a: float, g: float, N: float, i: float) -> float:
    """Return the gap's flux density, ``B_g = mu_0 (N i - H_a l_a)/(2 g)``, eq. (14) inverted, T.

    Zero where the iron takes all of N i.
    """
    return max(0.0, MU_0 * (N * i - H_a * l_a) / (2 * g))


def acceleration(*, f: float, M: float) -> float:
    """Return the acceleration without friction, ``a = f/M``, m/s^2."""
    return f / M


def velocity_rest_to_rest(*, f: float, stroke: float, M: float) -> float:
    """Return the top velocity between two rests, ``v = sqrt(f stroke/M)``, m/s.

    The force accelerates over half of the stroke and brakes over the other half.
    """
    return math.sqrt(f * stroke / M)


def velocity_whole_stroke(*, f: float, stroke: float, M: float) -> float:
    """Return the velocity at the stroke's end, ``v = sqrt(2 f stroke/M)``, m/s.

    The force accelerates over all of the stroke; none is left to brake.
    """
    return math.sqrt(2 * f * stroke / M)


def mass_for_velocity(*, f: float, stroke: float, v: float) -> float:
    """Return the mass that reaches `v` between two rests, ``M = f stroke/v^2``, kg."""
    return f * stroke / v**2
