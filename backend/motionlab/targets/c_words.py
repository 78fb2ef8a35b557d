"""Names of an exported program's own: none of C and C++, their libraries, or the interface."""

from __future__ import annotations

import re
from collections.abc import Container

_LANGUAGE = """
asm auto bool break case char const continue default do double else enum extern false float
for goto if inline int long register restrict return short signed sizeof static
struct switch true typedef typeof union unsigned void volatile while
alignas alignof and and_eq bitand bitor catch char8_t char16_t char32_t class co_await co_return
co_yield compl concept const_cast consteval constexpr constinit decltype delete dynamic_cast
explicit export friend mutable namespace new noexcept not not_eq nullptr operator or or_eq private
protected public reinterpret_cast requires static_assert static_cast template this thread_local
throw try typeid typename typeof_unqual using virtual wchar_t xor xor_eq
"""
_MACROS = """
BUFSIZ EOF FILE INFINITY NAN NDEBUG NULL assert errno offsetof stderr stdin stdout
arm hpux i386 linux m68k mips sgi sparc sun unix vax
"""
_MATHS = """
acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs fdim
floor fma fmax fmin fmod fpclassify frexp hypot ilogb isfinite isgreater isgreaterequal isinf isless
islessequal islessgreater isnan isnormal isunordered ldexp lgamma llrint llround log log10 log1p
log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo rint round
scalbln scalbn signbit signgam sin sinh sqrt tan tanh tgamma trunc
power_of_two
"""
_FUNCTIONS = """
abort abs acospi alloca atexit atof atoi atol bcmp bcopy bzero calloc conj creal cimag carg cabs
cexp clog cpow cproj csqrt dcgettext dgettext drem exit exp10 ffs finite fprintf fputc fputs free
fscanf fwrite gamma gettext index isalnum isalpha isblank iscntrl isdigit isgraph islower isprint
ispunct isspace isupper isxdigit j0 j1 jn labs llabs main malloc memchr memcmp memcpy memmove memset
mempcpy pow10 printf putc putchar puts realloc rindex roundeven scalb scanf significand sincos
snprintf sprintf sscanf stpcpy strcat strchr strcmp strcpy strcspn strdup strfmon strftime strlen
strncat strncmp strncpy strpbrk strrchr strspn strstr tolower toupper vfprintf vprintf vsnprintf
vsprintf y0 y1 yn
INITIAL TABLES
"""
"""What compilers know without a header, and names of the exported files between functions."""

_EVERYWHERE = frozenset((_LANGUAGE + _MACROS + _MATHS).split())
_BETWEEN_FUNCTIONS = frozenset((_FUNCTIONS + _MATHS).split())
_PATTERNS = re.compile(
    r"(?i:(psrm|fmi\d*)_.*)|u?int(_least|_fast)?\d+_t|u?int(max|ptr)_t|(size|ptrdiff|max_align)_t"
    r"|U?INT(_LEAST|_FAST)?(\d+|MAX|PTR)_(MIN|MAX|C)|(FLT|DBL|LDBL|M|FP|MATH)_\w+|HUGE_VAL\w?"
)
"""The interface, of which all names begin alike, and families of types and macros."""


def ascii_name(name: str) -> str:
    """Return a name with the numbers of letters that not every compiler allows."""
    return "".join(each if each.isascii() else f"u{ord(each):04x}" for each in name)


def safe(name: str) -> str:
    """Return a name that C allows inside of a function or a structure; other names give others."""
    plain = ascii_name(name)
    word = plain.rstrip("_")
    reserved = word in _EVERYWHERE or _PATTERNS.fullmatch(word) is not None
    return f"{plain}_" if reserved else plain


def safe_outside(name: str) -> str:
    """Return a name that C allows for a function or a constant of a file."""
    made = safe(name)
    word = made.rstrip("_")
    known = word in _BETWEEN_FUNCTIONS or (word[:-1] in _MATHS.split() and word[-1] in "fl")
    return f"{made}_" if known and made == name else made


def free_name(name: str, taken: Container[str]) -> str:
    """Return a name, with a number at its end where it is taken."""
    free, number = name, 2
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    return free
