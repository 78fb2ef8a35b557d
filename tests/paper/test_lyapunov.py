"""The stability argument along runs: its terms, and what is wrong with it."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.plant import FrictionConfig
from motionlab.paper.control import NOISELESS, Lyapunov, lyapunov
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.telemetry.channels import CHANNELS
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD

WINDOW = (9000, 15000)
FRICTION = FrictionConfig(
    sigma_0=118913.2532, sigma_1=1162.3, sigma_2=10.3128, F_c=0.2399, F_s=3.5908, v_s=0.0436
)
GAINS = {"k_p": 200300.0, "k_d": 1530.0}


def along(scenario: str, changes: dict[str, object]) -> tuple[Lyapunov, VariantRecord]:
    record = run(prepare(load_scenario(scenario, changes))).variants["B"]
    return lyapunov(record.cut(*WINDOW), "x", friction=FRICTION, **GAINS), record


@pytest.fixture(scope="module")
def quiet() -> tuple[Lyapunov, VariantRecord]:
    """Return the circle with K = 0 on a motor without noise or lag."""
    return along("circle", dict(NOISELESS))


@pytest.fixture(scope="module")
def published() -> Lyapunov:
    return along("circle-published-k", dict(NOISELESS))[0]


def test_the_terms_are_those_of_the_paper() -> None:
    """At 10 mm/s, e = 2 um, z = 3 um, z* = 1 um, u = 0.5 N, by hand."""
    samples = np.zeros((len(CHANNELS), 2, 5), dtype=np.float32)
    names = [channel.name for channel in CHANNELS]
    for name, value in (
        ("following_error", 2e-6),
        ("bristle", 3e-6),
        ("bristle_estimate", 1e-6),
        ("velocity_measured", -0.01),
        ("pd_force", 0.5),
    ):
        samples[names.index(name), 0] = value
    found = lyapunov(VariantRecord(samples).cut(0, 5), "x", friction=FRICTION, **GAINS)
    g = (0.2399 + 3.3509 * np.exp(-((0.01 / 0.0436) ** 2))) / 118913.2532
    beta = 2e-6 * 2e-6
    assert found.V[2] == pytest.approx(0.5 * beta**2, rel=1e-5)
    assert found.argued[2] == pytest.approx(-(200.3 / 1.53 + 0.01 / g) * beta**2, rel=1e-5)
    assert found.rate[2] == 0.0
    denominator = 1162.3 * 0.5 + 2e-6 * 1530.0 * (1162.3 * 0.01 / g - 118913.2532)
    assert found.denominator[2] == pytest.approx(denominator, rel=1e-5)


def test_the_rate_is_that_of_v(quiet: tuple[Lyapunov, VariantRecord]) -> None:
    found, _ = quiet
    assert pytest.approx(0.5 * (found.error * found.bristle_error) ** 2) == found.V
    gained = np.cumsum(found.rate[1:-1]) * CONTROL_PERIOD
    assert gained[-1] == pytest.approx(
        found.V[-2:].mean() - found.V[:2].mean(), abs=1e-3 * found.V.max()
    )
    assert (found.argued <= 0.0).all()
    assert (found.argued[found.V > 0.0] < 0.0).all()


def test_v_rises_half_of_the_time_with_the_published_k(published: Lyapunov) -> None:
    """Whatever the argument says: V comes back every lap, so it cannot only fall."""
    assert 0.3 < published.rising_share < 0.7


def test_v_is_only_semidefinite(published: Lyapunov) -> None:
    """Where e passes through zero V is zero, and the bristle error is not."""
    assert published.zero_error_bristle > 10e-6


def test_the_denominator_is_singular_where_it_changes_its_sign(
    quiet: tuple[Lyapunov, VariantRecord],
) -> None:
    found, _ = quiet
    assert found.singular_rate == pytest.approx(2 / 3), "twice a lap, and it never stays away"
    assert len(found.singular_speeds) == len(found.singular_places)
    for place in found.singular_places:
        before = found.denominator[place]
        after = found.denominator[place + 1 :]
        assert np.sign(before) == -np.sign(after[np.flatnonzero(after)[0]])


def test_resting_on_the_reference_is_no_crossing() -> None:
    samples = np.zeros((len(CHANNELS), 2, 100), dtype=np.float32)
    names = [channel.name for channel in CHANNELS]
    samples[names.index("pd_force"), 0, 10:20] = 1.0
    samples[names.index("pd_force"), 0, 50:60] = -1.0
    samples[names.index("pd_force"), 0, 70:80] = -1.0
    found = lyapunov(VariantRecord(samples).cut(0, 100), "x", friction=FRICTION, **GAINS)
    assert found.singular_places.tolist() == [19]
    assert found.singular_rate == pytest.approx(1 / 0.05)


def test_a_window_that_says_nothing_is_refused() -> None:
    samples = np.zeros((len(CHANNELS), 2, 10), dtype=np.float32)
    for wrong in ((0, 2), (0, 10)):
        samples[:, :, 5:] = np.nan
        with pytest.raises(ValueError, match="three ticks"):
            lyapunov(VariantRecord(samples).cut(*wrong), "x", friction=FRICTION, **GAINS)
