"""Rows that hold with nearly any model: by a rule, not by a list."""

from __future__ import annotations

from motionlab.paper.document import Comparison, Number

WIDE = 0.2
"""A band is lax beyond this share of the printed value, bound or half of the printed range."""

FACTOR = 2.0
"""A bound is lax where ours would have to be more than this many times as bad to reach it."""


def lax(
    comparison: Comparison,
    *,
    paper: Number,
    ours: Number,
    band: float,
    rival: float | None = None,
) -> str:
    """Return why a row would hold with nearly any model; empty if it would not.

    Of a printed 0 no share can be taken: such a row is never lax.

    Parameters
    ----------
    comparison, paper, ours, band
        See `motionlab.paper.verdict.holds`.
    rival : float, optional
        Another printed value of the same quantity.
    """
    if isinstance(paper, tuple):
        return _range(paper, ours if isinstance(ours, tuple) else (ours, ours), band)
    if paper == 0.0 or isinstance(ours, tuple):
        return ""
    if band > WIDE * abs(paper):
        what = "value" if comparison == "value" else "bound"
        return f"the band is {_percent(band / abs(paper))} of the printed {what}"
    if comparison == "value":
        held = rival is not None and abs(rival - paper) <= band
        return f"the band holds {rival:g} too, which is printed of the same thing" if held else ""
    if comparison == "at_least":
        return f"ours is {ours / paper:.2g} times the bound" if ours > FACTOR * paper else ""
    return _inside(ours / paper)


def _range(paper: tuple[float, float], ours: tuple[float, float], band: float) -> str:
    """Return why a range is lax: an error's, about zero, is two bounds; any other is a band."""
    low, high = paper
    half = (high - low) / 2.0
    if not low < 0.0 < high:
        share = (half + band) / abs((low + high) / 2.0)
        return f"the range is {_percent(share)} to either side of its middle" * (share > WIDE)
    if band > WIDE * half:
        return f"the band is {_percent(band / half)} of half the printed range"
    return _inside(max(ours[0] / low, ours[1] / high))


def _inside(used: float) -> str:
    """Return why a bound of which ours takes that share is lax."""
    if used <= 0.0:
        return "ours is nothing beside the bound"
    return f"the bound is {1.0 / used:.2g} times ours" if FACTOR * used < 1.0 else ""


def _percent(share: float) -> str:
    return f"{share:.0%}".replace("%", " %")
