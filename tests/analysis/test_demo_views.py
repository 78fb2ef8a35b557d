"""The fixture with which the page's own views are compared."""

from __future__ import annotations

import json

from tests.alike import assert_alike
from tests.fixtures.__main__ import DEMO_VIEWS
from tests.fixtures.demo_views import views


def test_the_fixture_of_the_page_is_what_is_computed() -> None:
    assert_alike(json.loads(DEMO_VIEWS.read_text()), views(), rel=1e-5, least=1e-20)
