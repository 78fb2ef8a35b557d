"""Elementary functions without branches or calls of a maths library.

Each is a range reduction and a Taylor polynomial, accurate to a few units in the last place on its
range.
"""

from __future__ import annotations

import math

from motionlab.lanes import (
    Lanes,
    compiled,
    power_of_two,
    round_nearest,
    select,
)

_LOG2_E = 1.0 / math.log(2.0)
_LN2 = math.log(2.0)
_EXP_MIN = -700.0

_E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11 = (1.0 / math.factorial(k) for k in range(2, 12))
_S3, _S5, _S7, _S9, _S11, _S13, _S15, _S17 = (
    (-1.0) ** k / math.factorial(2 * k + 1) for k in range(1, 9)
)
_C2, _C4, _C6, _C8, _C10, _C12, _C14, _C16 = (
    (-1.0) ** k / math.factorial(2 * k) for k in range(1, 9)
)
_TWO_PI = 2.0 * math.pi
_SERIES_BELOW = 0.03


@compiled
def clip(x: Lanes, low: Lanes, high: Lanes) -> Lanes:
    """Limit `x` to [low, high]; a NaN in `x` stays NaN, it never becomes a limit."""
    x = select(x < low, low, x)
    return select(x > high, high, x)


@compiled
def positive(x: Lanes) -> Lanes:
    """Return `x` where it is positive, else 0."""
    return select(x > 0.0, x, 0.0)


@compiled
def sign(x: Lanes) -> Lanes:
    """Return 1 where x > 0, -1 where x < 0, else 0."""
    return select(x > 0.0, 1.0, select(x < 0.0, -1.0, 0.0))


@compiled
def exponential(x: Lanes) -> Lanes:
    """Return e**x for x <= 700; below -700 it stays at e**-700.

    The relative error is below ``1e-14 + 1.2e-16 abs(x)``.
    """
    x = select(x < _EXP_MIN, _EXP_MIN, x)
    n = round_nearest(x * _LOG2_E)
    r = x - n * _LN2
    # e**r for abs(r) <= ln(2)/2 by Estrin's scheme, whose chain of operations is short.
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 + r) + r2 * (_E2 + _E3 * r)
    middle = (_E4 + _E5 * r) + r2 * (_E6 + _E7 * r)
    high = (_E8 + _E9 * r) + r2 * (_E10 + _E11 * r)
    return (low + r4 * (middle + r4 * high)) * power_of_two(n)


@compiled
def hyperbolic_tangent(x: Lanes) -> Lanes:
    """Return ``tanh x = sgn(x) (1 - e)/(1 + e)`` with ``e = exp(-2 abs(x))``."""
    e = exponential(-2.0 * abs(x))
    return sign(x) * ((1.0 - e) / (1.0 + e))


@compiled
def sine_cosine(turns: Lanes) -> tuple[Lanes, Lanes]:
    """Return sin and cos of 2 pi `turns`."""
    quarter = round_nearest(4.0 * turns)
    x = _TWO_PI * (turns - 0.25 * quarter)
    q = quarter - 4.0 * round_nearest(0.25 * quarter)  # -2, -1, 0, 1 or 2
    x2 = x * x
    x4 = x2 * x2
    x8 = x4 * x4
    s = (_S3 + _S5 * x2) + x4 * (_S7 + _S9 * x2)
    s = s + x8 * ((_S11 + _S13 * x2) + x4 * (_S15 + _S17 * x2))
    s = x + x * x2 * s
    c = (_C2 + _C4 * x2) + x4 * (_C6 + _C8 * x2)
    c = c + x8 * ((_C10 + _C12 * x2) + x4 * (_C14 + _C16 * x2))
    c = 1.0 + x2 * c
    odd = (q == 1.0) | (q == -1.0)
    sine = select(odd, c, s)
    cosine = select(odd, s, c)
    turned = (q == 2.0) | (q == -2.0)
    sine = select(turned | (q == -1.0), -sine, sine)
    cosine = select(turned | (q == 1.0), -cosine, cosine)
    return sine, cosine


@compiled
def decay(x: Lanes, inverse: Lanes) -> tuple[Lanes, Lanes]:
    """Return e**-x and ``phi1 = (1 - e**-x)/x``, its mean over a step, for x >= 0.

    Below x = 0.03 phi1 comes from its series: the quotient would lose digits as steps shrink.

    Parameters
    ----------
    x : Lanes
        Step length times decay rate.
    inverse : Lanes
        1 / x, which the caller often has without a further division; ignored below 0.03.
    """
    e = exponential(-x)
    near = 1.0 - x * (_E2 - x * (_E3 - x * (_E4 - x * (_E5 - x * (_E6 - x * _E7)))))
    return e, select(x < _SERIES_BELOW, near, (1.0 - e) * inverse)
