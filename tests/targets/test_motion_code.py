"""The fixtures with which the page's motions are compared, and what the translator refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motionlab.targets.javascript import Translator, UntranslatableError
from motionlab.targets.motion_code import motion_code
from tests.alike import assert_alike
from tests.fixtures.__main__ import DEMO_CHECKS, DEMO_MOTIONS, MOTION_CODE
from tests.fixtures.demo_checks import checks
from tests.fixtures.demo_motions import motions


def test_the_fixtures_of_the_page_are_what_is_computed() -> None:
    hint = "run python -m tests.fixtures"
    assert MOTION_CODE.read_text() == motion_code(), hint
    for kept, now in zip(json.loads(DEMO_MOTIONS.read_text()), motions(), strict=True):
        assert kept["trajectory"] == json.loads(json.dumps(now["trajectory"])), hint
        samples = (np.array(each["reference"].pop("samples")) for each in (kept, now))
        np.testing.assert_allclose(*samples, rtol=1e-9, atol=1e-12, err_msg=hint)
        sizes = (each["reference"].pop("size") for each in (kept, now))
        np.testing.assert_allclose(*sizes, rtol=1e-9, atol=1e-12, err_msg=hint)
        assert kept["reference"].pop("end") == pytest.approx(now["reference"].pop("end"), abs=1e-13)
        assert _rounded(kept["reference"]) == _rounded(json.loads(json.dumps(now["reference"])))


def test_the_fixture_of_checked_paths_is_what_is_computed() -> None:
    assert_alike(json.loads(DEMO_CHECKS.read_text()), checks(), rel=1e-5, least=1e-9)


def _rounded(value: Any) -> Any:
    """Return a document whose numbers have 11 decimals."""
    return json.loads(json.dumps(value), parse_float=lambda text: round(float(text), 11))


def _list_of_squares(n: int) -> list[int]:
    return [k * k for k in range(n)]


def _every_other(values: Any) -> Any:
    return values[::2]


def _sorted(values: Any) -> Any:
    return np.sort(values)


@pytest.mark.parametrize("function", [_list_of_squares, _every_other, _sorted])
def test_what_is_not_translated_is_named(function: Callable[..., Any]) -> None:
    with pytest.raises(UntranslatableError, match=function.__name__):
        Translator(replaced={}, constants={}, methods={}).name(function)
