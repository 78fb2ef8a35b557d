"""Documents whose numbers may differ by rounding."""

from __future__ import annotations

import json
from typing import Any

import pytest


def assert_alike(kept: Any, now: Any, *, rel: float, least: float) -> None:
    """Compare numbers of two documents within bounds, all else exactly."""
    before, after = _leaves(kept), _leaves(json.loads(json.dumps(now)))
    assert before.keys() == after.keys()
    for place, value in before.items():
        number = isinstance(value, float) and isinstance(after[place], float)
        expected = pytest.approx(value, rel=rel, abs=least, nan_ok=True) if number else value
        assert after[place] == expected, f"{place}: run python -m tests.fixtures"


def _leaves(document: Any, place: str = "") -> dict[str, Any]:
    """Return what a document holds by where it is."""
    if not isinstance(document, dict | list):
        return {place: document}
    items = document.items() if isinstance(document, dict) else enumerate(document)
    below = [_leaves(each, f"{place}.{key}") for key, each in items]
    return {path: value for leaves in below for path, value in leaves.items()}
