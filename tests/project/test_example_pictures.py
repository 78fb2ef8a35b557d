"""The pictures of the gallery are those of the shipped scenarios."""

from __future__ import annotations

import json

import pytest

from motionlab.config.named_configs import names
from tests.fixtures.__main__ import PICTURES
from tests.fixtures.example_pictures import example_picture


def test_every_scenario_has_its_picture() -> None:
    assert list(json.loads(PICTURES.read_text())) == list(names("scenarios"))


@pytest.mark.parametrize("name", ["circle", "stair-x-500nm"])
def test_a_picture_is_that_of_the_scenario(name: str) -> None:
    kept, now = json.loads(PICTURES.read_text())[name], example_picture(name)
    assert list(kept) == list(now)
    for curve, values in now.items():  # of 1000; other processors round otherwise
        assert kept[curve] == pytest.approx(values, abs=2)
