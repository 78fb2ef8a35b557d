"""Spectra: against scipy, Parseval's theorem, and lines and resonances that were put in."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from motionlab.analysis.spectrum import (
    Window,
    longest_whole,
    peaks,
    spectrum,
    thinned,
)
from motionlab.errors import ConfigError

Array = NDArray[np.float64]

PERIOD = 5e-4
RATE = 2000.0
NAMES: dict[Window, str] = {
    "rectangular": "boxcar",
    "hann": "hann",
    "blackman-harris": "blackmanharris",
    "flat-top": "flattop",
}
SINE, RESONANCE = 47.3, 180.0  # Hz


def noise(count: int, seed: int = 7) -> Array:
    return np.random.default_rng(seed).standard_normal(count)


def with_lines(count: int) -> Array:
    """Return white noise, a sine, and a resonance driven by noise, m."""
    pole = np.exp((-0.02 + 1j) * 2 * np.pi * RESONANCE / RATE)
    ringing: Array = np.asarray(
        signal.lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], noise(count, 1))
    )
    sine = np.sin(2 * np.pi * SINE * PERIOD * np.arange(count))
    return 5e-8 * sine + 2e-8 * ringing + 1e-7 * noise(count)


@pytest.mark.parametrize("window", NAMES)
@pytest.mark.parametrize(("count", "averages"), [(4001, 1), (4000, 1), (9000, 8), (1000, 3)])
def test_the_density_is_that_of_scipy(window: Window, count: int, averages: int) -> None:
    samples = 3.0 + noise(count)
    found = spectrum(samples, period=PERIOD, window=window, averages=averages)
    frequency, density = signal.welch(
        samples - samples.mean(),
        RATE,
        NAMES[window],
        nperseg=found.segment,
        noverlap=found.segment // 2,
        detrend=False,  # pyright: ignore[reportArgumentType]
    )
    assert found.frequency == pytest.approx(frequency[1:])
    assert found.density == pytest.approx(density[1:], rel=1e-9)
    _, squared = signal.welch(
        samples - samples.mean(),
        RATE,
        NAMES[window],
        nperseg=found.segment,
        noverlap=found.segment // 2,
        detrend=False,  # pyright: ignore[reportArgumentType]
        scaling="spectrum",
    )
    inner = slice(0, -1)  # at half the rate a sine is its own mirror image
    assert found.amplitude[inner] ** 2 / 2 == pytest.approx(squared[1:][inner], rel=1e-9)


@pytest.mark.parametrize("window", NAMES)
@pytest.mark.parametrize("averages", [1, 5])
def test_the_cumulated_rms_ends_at_the_rms_without_the_mean(window: Window, averages: int) -> None:
    samples = 1.0 + with_lines(6001)
    found = spectrum(samples, period=PERIOD, window=window, averages=averages)
    assert found.cumulative[-1] == pytest.approx(np.std(samples), rel=1e-12)
    assert np.all(np.diff(found.cumulative) >= 0.0)
    summed = np.sqrt(found.density.sum() * found.resolution)
    exact = window == "rectangular" and averages == 1
    assert summed == pytest.approx(found.rms, rel=1e-12 if exact else 0.1)


def test_the_noise_bandwidths_are_those_of_the_books() -> None:
    bins: dict[Window, float] = {
        "rectangular": 1.0,
        "hann": 1.5,
        "blackman-harris": 2.0044,
        "flat-top": 3.7702,
    }
    for window, expected in bins.items():
        found = spectrum(noise(4096), period=PERIOD, window=window, averages=1)
        assert found.noise_bandwidth / found.resolution == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("window", NAMES)
def test_a_sine_in_the_middle_of_a_bin_has_its_amplitude(window: Window) -> None:
    samples = 3e-6 * np.sin(2 * np.pi * 50.0 * PERIOD * np.arange(4000))
    found = spectrum(samples, period=PERIOD, window=window, averages=1)
    k = int(np.argmax(found.amplitude))
    assert found.frequency[k] == pytest.approx(50.0)
    assert found.amplitude[k] == pytest.approx(3e-6, rel=1e-9)
    half = np.cos(np.pi * np.arange(4000))
    assert spectrum(half, period=PERIOD, window=window, averages=1).amplitude[-1] == pytest.approx(
        1.0, rel=1e-9
    )


@pytest.mark.parametrize("window", NAMES)
@pytest.mark.parametrize(("count", "averages"), [(480_000, 1), (40_000, 1), (40_000, 8)])
def test_a_sine_is_a_line_and_a_resonance_is_broad(
    window: Window, count: int, averages: int
) -> None:
    found = spectrum(with_lines(count), period=PERIOD, window=window, averages=averages)
    line, broad = peaks(found)[0]
    assert line.narrow
    assert line.frequency == pytest.approx(SINE, abs=found.resolution)
    assert np.sqrt(2) * line.rms == pytest.approx(5e-8, rel=0.15)
    assert not broad.narrow
    assert broad.frequency == pytest.approx(RESONANCE, rel=0.03)


def test_few_lines_are_seen_in_a_resonance_of_a_few_bins() -> None:
    """Its bins stand out from the noise, but none holds most of the power around it."""
    pole = np.exp((-0.02 + 1j) * 2 * np.pi * RESONANCE / RATE)
    lines = 0
    for seed in range(20):
        ringing = signal.lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], noise(24_000, seed))
        samples = ringing + noise(24_000, 99 + seed)
        found = spectrum(samples, period=PERIOD, window="hann", averages=16)
        lines += sum(peak.narrow for peak in peaks(found)[0])
    assert lines <= 20  # 16 of them, one a record at most


def test_noise_alone_has_no_peak() -> None:
    for seed in range(20):
        for averages in (1, 8):
            found = spectrum(noise(20_000, seed), period=PERIOD, window="hann", averages=averages)
            assert peaks(found)[0] == []


@pytest.mark.parametrize("window", ["hann", "blackman-harris", "flat-top"])
def test_a_motion_slower_than_a_bin_is_no_line(window: Window) -> None:
    slow = 1e-5 * np.sin(2 * np.pi * 0.333 * PERIOD * np.arange(12000)) + 1e-9 * noise(12000)
    density = spectrum(slow, period=PERIOD, window=window, averages=8)
    assert density.resolution > 2 * 0.333
    assert not any(peak.narrow for peak in peaks(density)[0])


def test_what_does_not_move_has_a_spectrum_of_nothing() -> None:
    found = spectrum(np.full(500, 2.0), period=PERIOD, window="hann", averages=1)
    assert not found.density.any()
    assert not found.cumulative.any()
    assert peaks(found)[0] == []


def test_no_line_is_lost_among_fewer_points() -> None:
    found = spectrum(with_lines(480_000), period=PERIOD, window="hann", averages=1)
    own = thinned(found.density, found.frequency, 400)
    assert len(own) <= 400
    assert np.all(np.diff(own) > 0)
    assert int(np.argmax(found.density)) in own
    near = np.abs(found.frequency - SINE) < 1
    assert found.density[near].max() in found.density[own]
    assert thinned(found.density[:50], found.frequency[:50], 400).tolist() == list(range(50))


def test_the_longest_stretch_without_a_missing_sample_is_taken() -> None:
    samples = np.arange(10.0)
    assert longest_whole(samples) == slice(0, 10)
    samples[3] = np.nan
    assert longest_whole(samples) == slice(4, 10)
    samples[[0, 9]] = np.inf
    assert longest_whole(samples) == slice(4, 9)
    assert longest_whole(np.full(4, np.nan)) == slice(0, 0)


def test_too_few_samples_are_refused_with_what_is_allowed() -> None:
    with pytest.raises(ConfigError, match=r"samples: too few.* got 63; allowed >= 64"):
        spectrum(noise(63), period=PERIOD, window="hann", averages=1)
    with pytest.raises(ConfigError, match=r"averages: leaves .* got 31; allowed <= 30"):
        spectrum(noise(1000), period=PERIOD, window="hann", averages=31)
    assert spectrum(noise(1000), period=PERIOD, window="hann", averages=30).segment == 64
