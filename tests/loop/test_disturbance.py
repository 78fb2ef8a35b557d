"""What disturbs a loop: against the simulated motor, and in the spectrum of an error made of it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.loop.disturbance import disturbance_response
from motionlab.loop.linearise import linearise
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.spectrum import (
    OwnLoop,
    Samples,
    SpectrumOptions,
    Taken,
    document,
    take,
)
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

V = 0.02  # m/s
SETTLED = 2400  # ticks


@pytest.mark.parametrize(("variant", "axis"), [("A", "y"), ("B", "x")])
@pytest.mark.parametrize("frequency", [10.0, 40.0, 200.0])
def test_a_simulated_sine_of_force_has_the_error_that_it_says(
    variant: str, axis: str, frequency: float
) -> None:
    ramp = {"kind": "ramp", "start": {axis: -0.02}, "velocity": {axis: V}, "duration": 2.2}
    scenario = load_scenario("circle", {"trajectory": ramp})
    prepared = prepare(scenario)
    ticks = 2000  # whole cycles of each frequency

    def error(force: float) -> complex:
        time = np.arange(prepared.reference.ticks) * CONTROL_PERIOD
        load = prepared.load.copy()
        load[:, "xy".index(axis)] += force * np.sin(2 * math.pi * frequency * time)
        record = run(dataclasses.replace(prepared, load=load)).variants[variant]
        values = record.channel("following_error", axis)[SETTLED : SETTLED + ticks]
        turning = np.exp(-2j * math.pi * frequency * time[:ticks])
        return complex((values * turning).sum()) * 2 / ticks

    found = disturbance_response(scenario, variant, axis, v=V)
    expected = np.interp(frequency, found.frequency, found.force)
    assert abs(error(2.0) - error(0.0)) / 2 == pytest.approx(expected, rel=0.04)


def test_the_response_to_the_encoder_is_the_sensitivity() -> None:
    scenario = load_scenario("circle")
    found = disturbance_response(scenario, "B", "x", v=V)
    L = linearise(scenario, "B", "x", v=V).open(found.frequency)
    assert found.encoder == pytest.approx(np.abs(1 / (1 + L)), rel=1e-9)
    assert found.stable


def disturbed(line: float = 0.0) -> Taken:
    """Return the spectrum of an error that white force makes of a loop, and a line at 70 Hz."""
    scenario = load_scenario("circle", {"plant.x.encoder.resolution": 0.0})
    response = disturbance_response(scenario, "B", "x", v=V)
    count = 60_000
    white = np.fft.rfft(np.random.default_rng(3).standard_normal(count))
    frequency = np.fft.rfftfreq(count, CONTROL_PERIOD)
    force = 1e-3 * math.sqrt(0.5 / CONTROL_PERIOD)  # of 1 mN/sqrt(Hz)
    error = np.fft.irfft(force * white * np.interp(frequency, response.frequency, response.force))
    error += line * np.sin(2 * math.pi * 70.0 * CONTROL_PERIOD * np.arange(count))
    return take(
        Samples("B.x.following_error", "m", error),
        SpectrumOptions(),
        period=CONTROL_PERIOD,
        loop=OwnLoop(scenario, "B", "x", V),
    )


def test_the_fit_finds_the_force_that_made_the_error() -> None:
    found = disturbed()
    assert found.loop is not None
    assert found.loop.force == pytest.approx(1e-3, rel=0.1)
    assert found.loop.count == 0.0
    assert all(peak.kind == "loop" for peak in found.peaks)


def test_a_line_is_told_from_the_loop() -> None:
    (line,) = (peak for peak in disturbed(20e-9).peaks if peak.kind == "line")
    assert line.frequency == pytest.approx(70.0, abs=0.1)
    assert line.amplitude == pytest.approx(20e-9, rel=0.1)
    assert line.above_loop is not None
    assert line.above_loop > 10.0


def test_the_loop_s_own_peak_has_its_name() -> None:
    """Of stiff and little damped gains the response itself has a peak."""
    changes = {"variants.B.controller.x.k_p": 2e6, "plant.x.encoder.resolution": 0.0}
    scenario = load_scenario("circle", changes)
    response = disturbance_response(scenario, "B", "x", v=V)
    assert response.stable
    top = response.frequency[np.argmax(response.force)]
    count = 60_000
    white = np.fft.rfft(np.random.default_rng(5).standard_normal(count))
    frequency = np.fft.rfftfreq(count, CONTROL_PERIOD)
    error = np.fft.irfft(white * np.interp(frequency, response.frequency, response.force))
    found = take(
        Samples("B.x.following_error", "m", error),
        SpectrumOptions(),
        period=CONTROL_PERIOD,
        loop=OwnLoop(scenario, "B", "x", V),
    )
    (peak,) = found.peaks
    assert peak.kind == "loop"
    assert peak.frequency == pytest.approx(top, rel=0.05)


def test_a_loop_that_is_not_stable_has_no_response() -> None:
    scenario = load_scenario("circle", {"variants.B.controller.x.k_p": 3e7})
    found = take(
        Samples("B.x.following_error", "m", np.random.default_rng(1).standard_normal(2000)),
        SpectrumOptions(),
        period=CONTROL_PERIOD,
        loop=OwnLoop(scenario, "B", "x", V),
    )
    assert found.loop is None
    assert "unstable" in found.note


def test_a_part_of_the_frequencies_has_every_bin() -> None:
    taken = disturbed(20e-9)
    options = SpectrumOptions(low=69.0, high=71.0)
    (column,) = document([taken], options, period=CONTROL_PERIOD).columns
    bins = taken.spectrum.frequency
    assert len(column.frequency) == np.count_nonzero((bins >= 69.0) & (bins <= 71.0))
    assert column.loop is not None
    assert all(69.0 <= f <= 71.0 for f in column.loop.frequency)
