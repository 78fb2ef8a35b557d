"""When a printed number holds, when its band is lax, and the known failures."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from motionlab.errors import StoreError
from motionlab.paper.documents import Comparison, Number, Status

BETTER = 1.0
"""A value is better than a bound if it lies more than this many bands inside."""


def holds(comparison: Comparison, *, paper: Number, ours: Number, band: float) -> bool:
    """Return whether ours agrees with the printed value, within a band.

    Parameters
    ----------
    comparison : str
        ``value``: ``abs(ours - paper) <= band``. ``at_most``: ``ours <= paper + band``.
        ``at_least``: ``ours >= paper - band``. ``within``: both ends of ours lie in
        ``[low - band, high + band]``.
    paper : float or tuple of float
        As printed, SI; two numbers for ``within``.
    ours : float or tuple of float
        As computed.
    band : float
        Not negative.

    Raises
    ------
    ValueError
        If nothing can be judged, or there is one number in place of two.
    """
    if comparison == "within":
        if not isinstance(paper, tuple):
            raise ValueError(f"a range has two ends, not {paper!r}")
        low, high = ours if isinstance(ours, tuple) else (ours, ours)
        return paper[0] - band <= low and high <= paper[1] + band
    if isinstance(paper, tuple) or isinstance(ours, tuple):
        raise ValueError(f"{comparison} compares one number with another")
    match comparison:
        case "value":
            return abs(ours - paper) <= band
        case "at_most":
            return ours <= paper + band
        case "at_least":
            return ours >= paper - band
        case _:
            raise ValueError("there is nothing to judge")


def is_better(comparison: Comparison, *, paper: Number, ours: Number, band: float) -> bool | None:
    """Return whether ours lies inside of a bound by more than the band; None without a bound.

    Of ranges only those about zero, as errors have them, bound anything.
    """
    if comparison == "within" and isinstance(paper, tuple) and paper[0] < 0.0 < paper[1]:
        low, high = ours if isinstance(ours, tuple) else (ours, ours)
        return paper[0] + BETTER * band < low and high < paper[1] - BETTER * band
    if isinstance(paper, tuple) or isinstance(ours, tuple):
        return None
    match comparison:
        case "at_most":
            return ours < paper - BETTER * band
        case "at_least":
            return ours > paper + BETTER * band
        case _:
            return None


def status(held: bool | None, *, known: bool) -> Status:
    """Return the status of a row.

    Parameters
    ----------
    held : bool or None
        From `holds`; None where nothing is judged.
    known : bool
        Whether known_failures.toml lists the row. A listed row that holds is ``holds``, and
        `motionlab reproduce` fails until the file no longer lists it.
    """
    if held is None:
        return "not_comparable"
    if held:
        return "holds"
    return "known_failure" if known else "fails"


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
        See `motionlab.paper.judgement.holds`.
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


FILE = Path(__file__).with_name("known_failures.toml")
"""Table of identifiers and reasons, part of the package; docs/known-failures.md shows it."""


def known_failures(path: Path | None = None) -> Mapping[str, str]:
    """Return the reason why each known failure fails, by the row's identifier.

    Raises
    ------
    StoreError
        If the file cannot be read, is not TOML, or holds anything but texts.
    """
    path = FILE if path is None else path
    try:
        reasons = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # not UTF-8, not TOML, or a row that comes twice
        raise StoreError(f"{path} is not valid TOML: {error}") from None
    for row, reason in reasons.items():
        if not isinstance(reason, str):
            raise StoreError(f"{path}: {row} needs a reason in quotes")
    return reasons
