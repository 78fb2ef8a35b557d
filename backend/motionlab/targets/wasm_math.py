"""Functions of the C library that compiled Python calls, for the module, which has none.

Accurate to a few units in the last place. Each becomes a function of its name in the module.
"""

from __future__ import annotations

import math

from motionlab.lanes import compiled

_LN2_HIGH, _LN2_LOW = 0.6931471803691238, 1.9082149292705877e-10
_HALF_PI, _HALF_PI_LOW = math.pi / 2.0, 6.123233995736766e-17
_LEAST, _MOST = -745.0, 710.0


def exp(x: float) -> float:
    """Return e**x."""
    if x < _LEAST:
        return 0.0
    if x > _MOST:
        return math.inf
    n = math.floor(x / math.log(2.0) + 0.5)
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    value = 1.0
    for k in range(14, 0, -1):
        value = 1.0 + value * r / k
    while n > 0:
        value, n = 2.0 * value, n - 1
    while n < 0:
        value, n = 0.5 * value, n + 1
    return value


def log(x: float) -> float:
    """Return the natural logarithm of x; -inf of what is not above 0."""
    if x <= 0.0:
        return -math.inf
    if x == math.inf:
        return x
    n = 0
    while x > 1.5:
        x, n = 0.5 * x, n + 1
    while x < 0.75:
        x, n = 2.0 * x, n - 1
    s = (x - 1.0) / (x + 1.0)
    value = 0.0
    for k in range(27, 0, -2):
        value = value * (s * s) + 1.0 / k
    return n * _LN2_HIGH + (n * _LN2_LOW + 2.0 * s * value)


@compiled
def _turned(x: float, quarter: int) -> float:
    """Return sin(x + quarter pi/2)."""
    n = math.floor(x / _HALF_PI + 0.5)
    r = (x - n * _HALF_PI) - n * _HALF_PI_LOW
    q = n + quarter
    quadrant = q - 4.0 * math.floor(0.25 * q)
    odd = quadrant - 2.0 * math.floor(0.5 * quadrant) > 0.5
    value = 1.0
    for k in range(20, 0, -2):
        first = k if odd else k + 1
        value = 1.0 - value * (r * r) / (first * (first - 1.0))
    value = value if odd else value * r
    return -value if quadrant > 1.5 else value


def sin(x: float) -> float:
    """Return the sine of x in [-pi, pi]."""
    return _turned(x, 0)


def cos(x: float) -> float:
    """Return the cosine of x in [-pi, pi]."""
    return _turned(x, 1)


@compiled
def atan2(y: float, x: float) -> float:
    """Return the angle of (x, y)."""
    a, b = abs(x), abs(y)
    if a == 0.0 and b == 0.0:
        return 0.0
    t = min(a, b) / max(a, b)
    for _ in range(2):  # half of the angle
        t = t / (1.0 + math.sqrt(1.0 + t * t))
    value = 0.0
    for k in range(25, 0, -2):
        value = 1.0 / k - value * (t * t)
    angle = 4.0 * t * value
    if b > a:
        angle = _HALF_PI - angle
    if x < 0.0:
        angle = math.pi - angle
    return math.copysign(angle, y)


def acos(x: float) -> float:
    """Return the angle whose cosine is x."""
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x)


FUNCTIONS = {exp: 1, log: 1, sin: 1, cos: 1, atan2: 2, acos: 1}
"""Each with the number of its parameters."""
