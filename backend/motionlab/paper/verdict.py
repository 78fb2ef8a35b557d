"""When a printed number holds."""

from __future__ import annotations

from motionlab.paper.document import Comparison, Number, Status

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
