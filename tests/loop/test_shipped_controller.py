"""What the best controller shipped reaches on the paper's circle, and what it rests on."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.loop.linearise import SLIDING, linearise
from motionlab.loop.margins import margins
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from tests.loop.shipped_controller import (
    GAIN_MARGIN,
    PHASE_MARGIN,
    SCENARIO,
    TARGETS,
    VARIANT,
    errors_over_the_pitch,
    least_margins,
    loop_margins,
)
from tests.simulated import play

# Largest following error, m: at mid-stroke, and anywhere in the pole pitch.
REACHED = {"x": (0.544e-6, 0.66e-6), "y": (0.792e-6, 0.967e-6)}
ENCODER_COUNT = 50e-9


@pytest.fixture(scope="module")
def errors() -> list[dict[str, float]]:
    return errors_over_the_pitch()


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_error_on_the_circle(errors: list[dict[str, float]], axis: str) -> None:
    middle, anywhere = errors[0][axis], max(place[axis] for place in errors)
    assert middle <= TARGETS[axis][0]
    assert anywhere <= TARGETS[axis][1]
    assert middle == pytest.approx(REACHED[axis][0], abs=1.2 * ENCODER_COUNT)
    assert anywhere == pytest.approx(REACHED[axis][1], abs=1.2 * ENCODER_COUNT)


def test_it_does_as_well_without_the_resonance() -> None:
    played = play(SCENARIO, {"plant": "matched"})
    for axis in "xy":
        found = played.largest_error(VARIANT, axis)
        assert found == pytest.approx(REACHED[axis][0], abs=1.2 * ENCODER_COUNT)


@pytest.mark.parametrize(("axis", "gain", "phase"), [("x", 9.1, 39.8), ("y", 8.3, 38.9)])
def test_margins(axis: str, gain: float, phase: float) -> None:
    found = loop_margins(axis)
    assert found == pytest.approx((gain, phase), rel=0.01)
    assert found.gain >= GAIN_MARGIN
    assert found.phase >= PHASE_MARGIN


@pytest.mark.parametrize("detuned", [0.9, 0.95, 1.0, 1.05, 1.1])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_margins_at_every_velocity_with_the_mode_elsewhere(axis: str, detuned: float) -> None:
    mode = getattr(load_scenario(SCENARIO).plant, axis).resonance
    changes = {f"plant.{axis}.resonance.frequency": detuned * mode.frequency}
    found = least_margins(axis, changes)
    # With the mode 10 % above, x has 5.96 dB; about 0.8 Stribeck velocities it has 29.4 to 29.6
    # degrees, less than the 30 that it was tuned for: docs/compensation.md.
    missing = 0.05 if detuned == 1.1 else 0.0
    assert GAIN_MARGIN - missing <= found.gain <= GAIN_MARGIN + 3.0
    least = {"x": 29.4, "y": PHASE_MARGIN}[axis]
    assert least <= found.phase <= least + 1.0


@pytest.mark.parametrize(("axis", "gain", "phase"), [("x", 11.6, 58.0), ("y", 14.2, 52.0)])
def test_margins_at_standstill(axis: str, gain: float, phase: float) -> None:
    loop = linearise(load_scenario(SCENARIO), VARIANT, axis, v=0.0)
    assert loop.stable
    found = margins(loop.open)
    assert found.gain_margin is not None and found.phase_margin is not None
    assert 20.0 * np.log10(found.gain_margin) == pytest.approx(gain, abs=0.1)
    assert np.degrees(found.phase_margin) == pytest.approx(phase, abs=0.5)
    assert found.gain_reduction is None


CROSSOVERS, MODES = [8.0, 70.0, 94.0], [160.0, 250.0]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(("places", "force"), [(CROSSOVERS, 5.0), (MODES, 0.5)])
def test_a_sweep_of_the_simulation_has_these_margins(
    axis: str, places: list[float], force: float
) -> None:
    """But for the encoder, which has no place in a linear loop; the notch has its limit at 5 N."""
    scenario = load_scenario(SCENARIO, {f"plant.{axis}.encoder.resolution": 0.0})
    v = 2.0 * getattr(scenario.plant, axis).friction.v_s
    measured = frequency_sweep(scenario, VARIANT, axis, places, v=v, force=force)
    ratio = measured.open / linearise(scenario, VARIANT, axis, v=v).open(measured.frequency)
    assert np.abs(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.angle(ratio) == pytest.approx(0.0, abs=0.06)


def stable(scenario: str, variant: str, axis: str, coupling: float) -> bool:
    """Return whether a shipped loop is, on the nominal motor with such a resonance."""
    changes = {"plant": "matched-resonant"}
    resonance = load_scenario(scenario, changes).plant.model_dump()[axis]["resonance"]
    nominal = {f"plant.{axis}.resonance": resonance | {"coupling": coupling}}
    loaded = load_scenario(scenario, nominal)
    v = SLIDING * getattr(loaded.plant, axis).friction.v_s
    return linearise(loaded, variant, axis, v=v).stable


TABLE_1 = {
    "x": ("stair-x-500nm", "rhombus", "pentagram"),
    "y": ("stair-y-500nm", "stair-y-50mm", "trapezoid-y", "rhombus", "pentagram"),
}


@pytest.mark.parametrize(("axis", "more"), [("x", -0.15), ("y", -0.2)])
def test_the_coupling_is_about_the_largest_that_table_1_allows(axis: str, more: float) -> None:
    for scenario in TABLE_1[axis]:
        assert stable(scenario, "A", axis, -0.1)
        assert stable(scenario, "B", axis, -0.1)
    assert not stable(TABLE_1[axis][0], "B", axis, more)


def test_published_gains_with_a_fast_observer_do_not_bear_the_resonance() -> None:
    played = play(SCENARIO, {"variants.B.controller": "lugre-reference"})
    for axis in "xy":
        assert played.largest_error("B", axis) > played.largest_error("A", axis)
