"""What a list says of the controllers of a run."""

from __future__ import annotations

import pytest

from motionlab.config.load import load_scenario
from motionlab.library.description import labels

LAW = "variants.B.controller.compensation.law"
ENABLED = "variants.B.controller.compensation.enabled"


@pytest.mark.parametrize(
    ("changes", "label"),
    [
        ({}, "LuGre observer"),
        ({"variants.B.controller.x.k_p": 3e5}, "LuGre observer"),
        ({LAW: "published-k"}, "K as published"),
        ({LAW: "off"}, "no compensation"),
        ({ENABLED: False}, "LuGre observer, K = 0, switched off"),
    ],
)
def test_a_label_names_the_law_that_runs(changes: dict[str, object], label: str) -> None:
    assert labels(load_scenario("circle", changes)) == {"A": "no compensation", "B": label}
