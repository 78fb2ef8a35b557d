"""Dates, clocks and instants as measuring systems write them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import date

SECOND = 1_000_000_000
"""Nanoseconds."""

DAY = 86_400 * SECOND

_YEAR_FIRST = r"(?P<y>\d{4})[-/.](?P<m>\d{1,2})[-/.](?P<d>\d{1,2})"
_YEAR_LAST = r"(?P<a>\d{1,2})(?P<sign>[-/.])(?P<b>\d{1,2})(?P=sign)(?P<c>\d{4}|\d{2})"
_CLOCK_PART = (
    r"(?P<hour>\d{1,3}):(?P<minute>[0-5]?\d)(?::(?P<second>[0-5]?\d)(?:[.,:](?P<part>\d{1,9}))?)?"
    r"\s?(?P<half>[AaPp]\.?[Mm]\.?)?"
)
_ZONE = r"\s?(?P<zone>Z|[+-]\d{2}:?\d{2})?"
_DATES = tuple(re.compile(form) for form in (_YEAR_FIRST, _YEAR_LAST))
_CLOCK = re.compile(_CLOCK_PART)
_INSTANTS = tuple(
    re.compile(rf"{form}(?:T|,?\s{{1,3}}){_CLOCK_PART}{_ZONE}")
    for form in (_YEAR_FIRST, _YEAR_LAST)
)
_LONGEST = 40  # characters
_LEAST = 5
_EPOCH = date(1970, 1, 1).toordinal()


def instant(text: str, day_first: bool | None = None) -> int | None:
    """Return an instant, ns since 1970; UTC where it names no zone.

    Parameters
    ----------
    text : str
        ``2024-05-02T13:56:24.5Z``, ``02.05.2024 13:56:24,5``, ``5/2/2024 1:56:24 PM``.
    day_first : bool or None
        Whether ``5/2/2024`` is in February, None for whatever is a date; with points the day is
        first in any case.
    """
    if not _LEAST <= len(text) <= _LONGEST or not text[0].isdigit():
        return None
    match = next((instant for form in _INSTANTS if (instant := form.fullmatch(text))), None)
    if match is None:
        return None
    day, time = _day(match, day_first), _of_day(match)
    if day is None or time is None:
        return None
    zone = (match["zone"] or "Z").replace(":", "")
    if zone != "Z":
        time -= int(f"{zone[0]}1") * (int(zone[1:3]) * 60 + int(zone[3:5])) * 60 * SECOND
    return day * DAY + time


def day(text: str, day_first: bool | None = None) -> int | None:
    """Return a date, days since 1970."""
    if not _LEAST <= len(text) <= _LONGEST or not text[0].isdigit():
        return None
    match = next((date for form in _DATES if (date := form.fullmatch(text))), None)
    return None if match is None else _day(match, day_first)


def clock(text: str, day_first: bool | None = None) -> int | None:
    """Return a time of day or a duration, ns."""
    del day_first  # it has no day
    if not _LEAST <= len(text) <= _LONGEST or not text[0].isdigit():
        return None
    match = _CLOCK.fullmatch(text)
    return None if match is None else _of_day(match)


def is_day_first(texts: Iterable[str]) -> bool | None:
    """Return whether dates such as ``5/2/2024`` begin with the day; None if nothing shows it."""
    for text in texts:
        match = _DATES[1].match(text)
        if match is None or match["sign"] == ".":
            continue
        if int(match["a"]) > 12:
            return True
        if int(match["b"]) > 12:
            return False
    return None


def is_ambiguous(text: str) -> bool:
    """Return whether a date or instant has the form in which day and month may be exchanged."""
    match = _DATES[1].match(text)
    return match is not None and match["sign"] != "."


def _day(match: re.Match[str], day_first: bool | None) -> int | None:
    parts = match.groupdict()
    if "y" in parts:
        return _ordinal(int(match["y"]), int(match["m"]), int(match["d"]))
    year = int(match["c"]) + (2000 if len(match["c"]) == 2 else 0)
    first, second = int(match["a"]), int(match["b"])
    month_first = None if match["sign"] == "." or day_first else _ordinal(year, first, second)
    if month_first is None and (day_first is not False or match["sign"] == "."):
        return _ordinal(year, second, first)
    return month_first


def _ordinal(year: int, month: int, number: int) -> int | None:
    try:
        return date(year, month, number).toordinal() - _EPOCH
    except ValueError:
        return None


def _of_day(match: re.Match[str]) -> int | None:
    hour = int(match["hour"])
    if match["half"]:
        if not 1 <= hour <= 12:
            return None
        hour = hour % 12 + (12 if match["half"][0] in "Pp" else 0)
    seconds = (hour * 60 + int(match["minute"])) * 60 + int(match["second"] or 0)
    return seconds * SECOND + int((match["part"] or "").ljust(9, "0"))
