"""Every metric against a value computed by hand, and what must hold whatever the samples."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.analysis.metrics import CONTOUR_DEFINITIONS, DEFINITIONS, variant_metrics
from motionlab.analysis.variant_comparison import RATIOS, compare
from motionlab.telemetry.recording import Divergence
from motionlab.timing import CONTROL_PERIOD
from tests.paths import DOCS
from tests.recordings import make_recording, make_reference

PAGE = DOCS / "metrics.md"
UNITS = {"m", "m/s", "m s^2", "s", "N", "A", "1"}
BAND = 1e-6


def measure(channels, reference, window=None, band=BAND):
    """Return the metrics of one variant."""
    recording = make_recording(reference.ticks, {"A": channels})
    return variant_metrics(
        recording, "A", reference, window or (0, reference.ticks), settling_band=band
    )


def on_x(values, **holds_and_edges):
    """Return a reference that moves on x only."""
    values = np.asarray(values, dtype=float)
    return make_reference(np.stack([values, np.zeros_like(values)], axis=1), **holds_and_edges)


def test_following_error_by_hand():
    x = measure({"x.following_error": [1e-6, -3e-6, 2e-6, 0.0]}, on_x([0, 1, 2, 3]))["axes"]["x"]
    assert x["max_abs_following_error"] == pytest.approx(3e-6)
    assert x["min_following_error"] == pytest.approx(-3e-6)
    assert x["max_following_error"] == pytest.approx(2e-6)
    assert x["mean_following_error"] == pytest.approx(0.0, abs=1e-12)
    assert x["rms_following_error"] == pytest.approx(math.sqrt(14 / 4) * 1e-6)
    assert x["itae"] == pytest.approx((1 * 3e-6 + 2 * 2e-6) * CONTROL_PERIOD**2)


def test_only_the_window_counts_and_itae_starts_with_it():
    reference = on_x(np.arange(6.0))
    error = [9e-6, 9e-6, 1e-6, 2e-6, 9e-6, 9e-6]
    x = measure({"x.following_error": error}, reference, (2, 4))["axes"]["x"]
    assert x["max_abs_following_error"] == pytest.approx(2e-6)
    assert x["itae"] == pytest.approx(2e-6 * CONTROL_PERIOD**2)


def test_what_a_drive_does_not_measure_has_no_metric():
    nothing = [math.nan] * 4
    channels = {
        "x.following_error": [1e-6, math.nan, 3e-6, 0.0],
        "x.current_a": [1.0, 2.0, 3.0, 0.0],
        **dict.fromkeys(("x.position", "x.velocity", "x.thrust"), nothing),
    }
    metrics = measure(channels, on_x([0, 1, 2, 3]))
    x = metrics["axes"]["x"]
    absent = {"max_abs_position_error", "max_abs_velocity", "rms_force", "max_abs_force"}
    assert {name for name in absent if x[name] is not None} == set()
    assert x["max_abs_following_error"] == pytest.approx(3e-6)
    assert x["mean_following_error"] == pytest.approx((1 + 2 + 3 + 0) / 4 * 1e-6)  # a straight line
    assert x["max_current"] == 3.0
    json.dumps(metrics, allow_nan=False)


def test_without_any_following_error_there_are_no_metrics():
    metrics = measure({"x.following_error": [math.nan] * 3}, on_x([0, 1, 2]))
    assert set(metrics["axes"]["x"].values()) == {None}
    assert set(metrics["contour"].values()) == {None}


def test_position_error_is_that_of_the_true_position():
    channels = {"x.position": [0.0, 0.001, 0.002], "x.following_error": [0.0, 0.0, 0.0]}
    x = measure(channels, on_x([0.0, 0.001, 0.00201]))["axes"]["x"]
    assert x["max_abs_position_error"] == pytest.approx(1e-5, rel=1e-4)
    assert x["max_abs_following_error"] == 0.0


def test_force_current_and_velocity_by_hand():
    channels = {
        "x.thrust": [3.0, -4.0],
        "x.velocity": [0.1, -0.2],
        "x.current_a": [1.0, 0.0],
        "x.current_b": [2.0, 0.0],
        "x.current_c": [2.0, 3.0],
    }
    x = measure(channels, on_x([0, 1]))["axes"]["x"]
    assert x["rms_force"] == pytest.approx(math.sqrt(12.5))
    assert x["max_abs_force"] == 4.0
    assert x["rms_current"] == pytest.approx(3.0)
    assert x["max_current"] == 3.0
    assert x["max_abs_velocity"] == pytest.approx(0.2)


def test_saturation_of_force_or_current_counts_a_tick_once():
    channels = {"x.force_saturated": [1, 1, 0, 0], "x.current_saturated": [0, 1, 1, 0]}
    assert measure(channels, on_x(np.arange(4)))["axes"]["x"]["saturated_fraction"] == 0.75


def test_only_axes_that_move_are_reported():
    assert list(measure({}, on_x([0, 1]))["axes"]) == ["x"]
    both = make_reference(np.array([[0.0, 0.0], [1.0, 1.0]]))
    assert list(measure({}, both)["axes"]) == ["x", "y"]


def test_without_a_hold_there_is_nothing_to_settle():
    x = measure({"x.following_error": [1e-3, 1e-3]}, on_x([0, 1]))["axes"]["x"]
    for name in ("settling_time", "steady_state_error", "overshoot", "relative_overshoot"):
        assert x[name] is None


# A step of 10 um at tick 5, held for ten ticks; the mover passes the target by 3 um.
STEP = on_x([0.0] * 5 + [1e-5] * 10, holds=((5, 15),))
STEP_ERROR = np.array([0] * 5 + [10, 4, -3, 1.5, -1.2, 0.8, -0.7, 0.6, -0.3, 0.2]) * 1e-6


def test_step_by_hand():
    x = measure({"x.following_error": STEP_ERROR}, STEP)["axes"]["x"]
    assert x["settling_time"] == pytest.approx(5 * CONTROL_PERIOD)
    assert x["overshoot"] == pytest.approx(3e-6)
    assert x["relative_overshoot"] == pytest.approx(0.3)
    assert x["steady_state_error"] == pytest.approx(0.3e-6)


def test_rounding_at_rest_is_no_error():
    # counts times their resolution is not to the last bit the reference that it stands on
    error = STEP_ERROR.copy()
    error[8:] = -1.7e-21
    x = measure({"x.following_error": np.minimum(error, 0.0)}, STEP)["axes"]["x"]
    assert x["steady_state_error"] == 0.0
    error[:8] = 1.7e-21
    x = measure({"x.following_error": error}, STEP)["axes"]["x"]
    assert x["overshoot"] == x["relative_overshoot"] == 0.0


def test_step_down_mirrors_step_up():
    down = on_x(-STEP.position[:, 0], holds=STEP.holds)
    up = measure({"x.following_error": STEP_ERROR}, STEP)["axes"]["x"]
    x = measure({"x.following_error": -STEP_ERROR}, down)["axes"]["x"]
    for name in ("settling_time", "overshoot", "relative_overshoot", "steady_state_error"):
        assert x[name] == up[name]


def test_settling_counts_the_last_time_out_of_the_band():
    late = STEP_ERROR.copy()
    late[13] = 1.1e-6
    x = measure({"x.following_error": late}, STEP)["axes"]["x"]
    assert x["settling_time"] == pytest.approx(9 * CONTROL_PERIOD)
    late[14] = 1.1e-6
    assert measure({"x.following_error": late}, STEP)["axes"]["x"]["settling_time"] is None


def test_settled_from_the_start_takes_no_time():
    x = measure({"x.following_error": STEP_ERROR}, STEP, band=1e-3)["axes"]["x"]
    assert x["settling_time"] == 0.0


def test_overshoot_goes_by_the_move_that_led_to_the_hold():
    # Out by 8 um and, without a stop, back by 2 um: the hold follows a move down.
    position = np.array([0, 4, 8, 7, 6, 6, 6]) * 1e-6
    reference = on_x(position, holds=((4, 7),), edges=((0, 2), (2, 4)))
    error = np.array([0, 0, 0, 0, 1, -0.5, 0]) * 1e-6  # 1 um below the target first
    x = measure({"x.following_error": error}, reference)["axes"]["x"]
    assert x["overshoot"] == pytest.approx(1e-6)
    assert x["relative_overshoot"] == pytest.approx(0.5)


def test_a_move_is_measured_in_full_though_the_window_cuts_it():
    position = np.array([0, 4, 8, 10, 10, 10]) * 1e-6
    reference = on_x(position, holds=((3, 6),), edges=((0, 3),))
    error = np.array([0, 0, 0, -1, 0, 0]) * 1e-6
    x = measure({"x.following_error": error}, reference, (2, 6))["axes"]["x"]
    assert x["relative_overshoot"] == pytest.approx(0.1)


def test_worst_of_all_holds_counts_and_holds_begun_before_the_window_do_not():
    position = np.array([0, 1, 1, 1, 1, 2, 2, 2, 2]) * 1e-5
    reference = on_x(position, holds=((1, 5), (5, 9)))
    error = np.array([0, 5, 5, 3, 0, 5, 3, 0, 0.5]) * 1e-6
    x = measure({"x.following_error": error}, reference)["axes"]["x"]
    assert x["settling_time"] == pytest.approx(3 * CONTROL_PERIOD)
    assert x["steady_state_error"] == pytest.approx(0.5e-6)
    x = measure({"x.following_error": error}, reference, (2, 9))["axes"]["x"]
    assert x["settling_time"] == pytest.approx(2 * CONTROL_PERIOD)


def test_no_overshoot_where_only_the_other_axis_moved():
    position = np.array([[0.0, 0.0], [1e-5, 0.0], [1e-5, 0.0], [1e-5, 1e-5], [1e-5, 1e-5]])
    reference = make_reference(position, holds=((1, 3), (3, 5)))
    axes = measure({"y.following_error": [0, -1e-6, 0, 0, 0]}, reference)["axes"]
    assert axes["y"]["overshoot"] == 0.0


def test_a_diverged_variant_has_null_metrics():
    recording = make_recording(4, {"A": {}}, {"A": Divergence(2, "x.following_error", ())})
    metrics = variant_metrics(recording, "A", on_x(np.arange(4)), (0, 4), settling_band=BAND)
    assert metrics == {
        "axes": {"x": dict.fromkeys(DEFINITIONS)},
        "contour": dict.fromkeys(CONTOUR_DEFINITIONS),
    }


samples = st.lists(st.floats(-0.0625, 0.0625, width=32), min_size=2, max_size=60)


@given(samples)
def test_relations_between_metrics(error):
    axis = measure(
        {"x.following_error": error, "x.thrust": error}, on_x(np.arange(len(error)), holds=())
    )["axes"]["x"]
    largest = axis["max_abs_following_error"]
    assert largest == max(abs(axis["min_following_error"]), abs(axis["max_following_error"]))
    assert abs(axis["mean_following_error"]) <= axis["rms_following_error"] * (1 + 1e-12)
    assert axis["rms_following_error"] <= largest * (1 + 1e-12)
    duration = len(error) * CONTROL_PERIOD
    assert 0.0 <= axis["itae"] <= largest * duration**2 / 2 + 1e-30
    assert axis["rms_force"] == axis["rms_following_error"]


@given(samples, st.integers(1, 59))
def test_json_knows_every_value(error, hold):
    hold = min(hold, len(error) - 1)
    position = np.where(np.arange(len(error)) < hold, 0.0, 1e-5)
    metrics = measure({"x.following_error": error}, on_x(position, holds=((hold, len(error)),)))
    assert json.loads(json.dumps(metrics, allow_nan=False)) == metrics
    axis = metrics["axes"]["x"]
    assert list(axis) == list(DEFINITIONS)
    assert list(metrics["contour"]) == list(CONTOUR_DEFINITIONS)
    assert all(value is None or type(value) is float for value in axis.values())
    assert axis["steady_state_error"] <= axis["max_abs_following_error"]
    assert 0.0 <= axis["overshoot"] <= axis["max_abs_following_error"]


def metrics_of(**values):
    return {"axes": {"x": dict.fromkeys(RATIOS) | values}}


def test_ratios_are_b_over_a():
    ratios = compare(metrics_of(itae=4.0, rms_force=2.0), metrics_of(itae=1.0, rms_force=3.0))
    assert ratios["x"]["itae_ratio"] == 0.25
    assert ratios["x"]["rms_force_ratio"] == 1.5
    assert set(ratios["x"]) == {f"{name}_ratio" for name in RATIOS}


@pytest.mark.parametrize(("a", "b"), [(0.0, 1.0), (None, 1.0), (1.0, None), (5e-324, 1.0)])
def test_no_ratio_to_nothing(a, b):
    assert compare(metrics_of(itae=a), metrics_of(itae=b))["x"]["itae_ratio"] is None


def test_ratios_are_of_metrics_that_exist():
    assert set(RATIOS) <= set(DEFINITIONS)


def test_names_that_scripts_rely_on():
    names = {"max_abs_following_error", "rms_following_error", "itae", "rms_force"}
    assert names | {"saturated_fraction"} <= set(DEFINITIONS)
    assert "max_abs_following_error" in RATIOS


def test_the_page_states_every_definition():
    text = PAGE.read_text()
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+?) \| `(.+?)` \|$", text, re.MULTILINE)
    tables = [*DEFINITIONS.items(), *((f"contour_{k}", d) for k, d in CONTOUR_DEFINITIONS.items())]
    assert rows == [(name, d.unit, d.meaning, d.formula) for name, d in tables]
    assert {d.unit for _, d in tables} <= UNITS
    listed = re.search(r"\nRatios: ([^.]+)\.", text)
    assert listed and re.findall(r"`(\w+)`", listed[1]) == list(RATIOS), "docs/metrics.md"
