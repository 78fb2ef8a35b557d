"""Words of C and C++, and of the target's library, that are no names of a program's own."""

from __future__ import annotations

_LANGUAGE = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while
and and_eq asm bitand bitor bool catch class compl const_cast constexpr decltype delete dynamic_cast
explicit export false friend mutable namespace new noexcept not not_eq nullptr operator or or_eq
private protected public reinterpret_cast static_cast template this throw true try typeid typename
using virtual wchar_t xor xor_eq
"""
_LIBRARY = """
acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim
floor fma fmax fmin fmod frexp hypot ilogb isfinite isinf isnan isnormal ldexp lgamma llrint llround
log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter pow remainder remquo rint round
scalbln scalbn signbit sin sinh sqrt tan tanh tgamma trunc
power_of_two
"""
_RESERVED = frozenset((_LANGUAGE + _LIBRARY).split())


def safe(name: str) -> str:
    """Return a name that C allows."""
    return f"{name}_" if name in _RESERVED else name
