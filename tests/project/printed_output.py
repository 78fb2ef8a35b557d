"""What a page of the docs prints beside what a command or an example prints on this machine.

Vector units differ in their last bits, which now and then moves a reading of the encoder by one
count, 50 nm: the largest error of a run, and with it a figure on a page, is that of its machine.
"""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def approx(number: float, least: float = 1e-9) -> Any:
    """Return what equals a number that may be off by a count of the encoder, and its rounding."""
    return pytest.approx(number, rel=0.05, abs=least)


def same_text(shown: str, printed: str) -> bool:
    """Compare line by line; a line of dots on the page stands for any number of lines."""
    if shown.lstrip().startswith("{"):
        return same_document(json.loads(shown), json.loads(printed))
    pattern = "".join(
        r"(?:.*\n)*?" if re.sub(r"\\", "", line).strip() == "..." else _pattern(line.rstrip())
        for line in shown.splitlines()
    )
    found = re.match(pattern, "".join(line.rstrip() + "\n" for line in printed.splitlines()))
    if found is None:
        return False
    wanted = [float(number) for number in NUMBER.findall(shown)]
    return all(float(a) == approx(b, 0.01) for a, b in zip(found.groups(), wanted, strict=True))


def same_document(shown: Any, printed: Any) -> bool:
    """Compare two JSON documents, numbers as `approx` has it."""
    match shown, printed:
        case dict(), dict():
            return shown.keys() == printed.keys() and all(
                same_document(shown[key], printed[key]) for key in shown
            )
        case list(), list():
            return len(shown) == len(printed) and all(map(same_document, shown, printed))
        case float(), float() | int():
            return printed == approx(shown)
        case _:
            return shown == printed


def _pattern(line: str) -> str:
    """Return a pattern that finds a line with other numbers in it, and each of them."""
    texts = [re.sub(r"(?:\\ )+", " +", re.escape(text)) for text in NUMBER.split(line)]
    return f"({NUMBER.pattern})".join(texts) + "\n"
