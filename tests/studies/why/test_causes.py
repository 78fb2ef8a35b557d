"""Scenarios with exactly one cause of error: it is named first, with the whole of the peak."""

from __future__ import annotations

import functools
import json
from typing import Any

import pytest

from motionlab.errors import ConfigError
from motionlab.studies.why.causes import CAUSES
from motionlab.studies.why.documents import WhyDocument
from motionlab.studies.why.study import WhyStudy
from tests.fixtures.__main__ import DEMO_WHY
from tests.fixtures.demo_why import causes as demo_why

IDEAL: dict[str, Any] = {
    "variants.B.controller.feedforward": True,
    "trajectory.laps": 1,
} | {
    f"plant.{axis}.{path}": value
    for axis in "xy"
    for path, value in {
        "friction.enabled": False,
        "amplifiers.bandwidth": None,
        "encoder.resolution": 0.0,
        "encoder.sde_amplitude": 0.0,
    }.items()
}
IDEAL |= {"variants.B.controller.compensation.law": "off"}
"""Circle on a motor without friction, its inertia fed forward: next to no error."""

COMPENSATED = IDEAL | {
    "plant.x.friction.enabled": True,
    "variants.B.controller.compensation.law": "lugre-observer",
}

ONE: dict[str, dict[str, Any]] = {
    "offset": {"plant.x.amplifiers.offset": [0.2, -0.1, 0.1]},
    "encoder": {"plant.x.encoder.resolution": 2e-6},
    "noise": {"plant.x.encoder.noise": 1e-6},
    "load": {"load.x": 2.0},
    "inertia": {"variants.B.controller.feedforward": False},
    "friction": {"plant.x.friction.enabled": True},
    "gain": {"plant.x.amplifiers.gain": [1.3, 1.3, 1.3]},
}


def why(changes: dict[str, Any], **request: Any) -> WhyDocument:
    """Return an explanation of B's error on x."""
    study = WhyStudy()
    asked = {"scenario": "circle", "set": changes, "variant": "B", "axis": "x"} | request
    return study.run(study.plan(asked), lambda *_: None)


@functools.cache
def ideal() -> float:
    """Return the peak without any cause."""
    return why(IDEAL).peak


@pytest.mark.parametrize("cause", ONE)
def test_the_only_cause_is_the_whole_of_the_peak(cause: str) -> None:
    found = why(IDEAL | ONE[cause])
    assert found.peak > 10.0 * ideal(), (found.peak, ideal())
    first = found.causes[0]
    assert first.id == cause
    assert first.share == pytest.approx(1.0, abs=0.1)
    assert first.error is not None
    assert first.share == pytest.approx(1.0 - first.error / found.peak)
    others = [other for other in found.causes[1:] if (cause, other.id) != ("friction", "stribeck")]
    assert all(abs(other.share or 0.0) < 0.6 for other in others)


def test_a_wrong_friction_model_is_named_and_its_repair_brings_the_error_of_the_right_one() -> None:
    model = "variants.B.controller.model.x.friction"
    right = why(COMPENSATED).peak
    found = why(COMPENSATED | {f"{model}.F_s": 6.0, f"{model}.F_c": 3.0})
    by_id = {cause.id: cause for cause in found.causes}
    assert found.causes[0].id in {"mismatch", "friction"}
    mismatch = by_id["mismatch"]
    assert mismatch.share is not None
    assert mismatch.share > 0.8
    assert mismatch.error is not None
    assert mismatch.error <= 1.001 * right


def test_causes_are_there_or_absent_and_act_on_one_axis_only() -> None:
    found = why(IDEAL | {"plant.y.amplifiers.offset": [0.2, -0.1, 0.1]})
    ids = {cause.id for cause in found.causes} | {cause.id for cause in found.absent}
    assert ids == {kind.id for kind in CAUSES}
    assert "offset" in {cause.id for cause in found.absent}
    assert found.axis == "x"
    assert all(".y." not in path for cause in found.causes for path in cause.set)


def test_compensation_that_helps_has_a_share_below_zero() -> None:
    found = why(COMPENSATED)
    (alone,) = [cause for cause in found.causes if cause.id == "compensation"]
    assert alone.share is not None
    assert alone.share < -1.0


def test_scheduled_changes_do_not_undo_what_is_taken_away() -> None:
    later = {"time": 1.0, "set": {"variants.B.controller.compensation.enabled": True}}
    found = why(COMPENSATED | {"schedule": [later], "trajectory.laps": 2}, time=4.5)
    (alone,) = [cause for cause in found.causes if cause.id == "compensation"]
    assert alone.share is not None
    assert alone.share < -1.0


def test_the_time_chooses_the_peak() -> None:
    found = why(COMPENSATED, time=1.0)
    assert found.time == pytest.approx(1.0, abs=0.1001)
    assert found.window == pytest.approx((found.time - 0.1, found.time + 0.1), abs=1e-3)


@pytest.mark.parametrize(
    ("request_", "loc"),
    [
        ({"variant": "Z"}, "variant"),
        ({"scenario": "stair-x-500nm", "set": {}, "axis": "x", "time": 1e3}, "time"),
        ({"goal": -1.0}, "goal"),
        ({"scenario": "stair-x-500nm", "set": {}, "axis": "y"}, "axis"),
    ],
)
def test_what_cannot_be_explained_is_refused(request_: dict[str, Any], loc: str) -> None:
    with pytest.raises(ConfigError) as refused:
        why(IDEAL, **request_)
    assert refused.value.errors[0].loc.endswith(loc)


def test_the_fixture_of_the_page_is_what_is_found() -> None:
    assert json.loads(DEMO_WHY.read_text()) == json.loads(json.dumps(demo_why()))
