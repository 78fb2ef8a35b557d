"""The fixture with which the page's own views are compared."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests.fixtures.__main__ import DEMO_VIEWS
from tests.fixtures.demo_views import views


def test_the_fixture_of_the_page_is_what_is_computed() -> None:
    assert _numbers(json.loads(DEMO_VIEWS.read_text())) == pytest.approx(
        _numbers(views()), rel=1e-5, abs=1e-20, nan_ok=True
    ), "run python -m tests.fixtures"


def _numbers(document: Any, path: str = "") -> dict[str, Any]:
    """Return the leaves of a document by path."""
    if isinstance(document, dict):
        document = list(document.items())
    elif isinstance(document, list):
        document = list(enumerate(document))
    else:
        return {path: document}
    return {
        place: value
        for key, each in document
        for place, value in _numbers(each, f"{path}.{key}").items()
    }
