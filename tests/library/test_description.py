"""What a list says of the controllers of a run."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.library.description import differences, labels
from tests.learnt_forces import known

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


def test_a_learnt_force_is_told_by_its_laps() -> None:
    force = known(np.zeros((6000, 2)))
    (one,) = differences(load_scenario("circle", {"learnt": force.model_dump(mode="json")}))
    assert (one.path, one.shipped, one.value) == ("learnt", None, "1 lap")
    more = force.model_copy(update={"laps": 12}).model_dump(mode="json")
    (two,) = differences(load_scenario("circle", {"learnt": more}))
    assert two.value == "12 laps"
