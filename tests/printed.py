"""What a page shows of a program's output, held against what it prints on this machine."""

from __future__ import annotations

import re

NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")


def alike(shown: str, printed: str, tolerance: float = 0.02) -> bool:
    """Tell whether two texts have the same words, and numbers that another machine may give.

    Another vector unit rounds differently, and friction carries that into the third digit: numbers
    may differ by a share `tolerance` of theirs, or by one in the last place shown.
    """
    theirs, ours = NUMBER.findall(shown), NUMBER.findall(printed)
    words = NUMBER.sub("#", shown).split(), NUMBER.sub("#", printed).split()
    return words[0] == words[1] and all(
        _close(a, b, tolerance) for a, b in zip(theirs, ours, strict=True)
    )


def _close(shown: str, printed: str, tolerance: float) -> bool:
    mantissa, _, exponent = shown.partition("e")
    last = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    a, b = float(shown), float(printed)
    return abs(a - b) <= max(tolerance * abs(a), 1.01 * last)
