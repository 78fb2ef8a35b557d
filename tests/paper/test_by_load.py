"""Fig. 5 by friction that grows with the normal force: what stays as it was identified."""

from __future__ import annotations

import pytest

from motionlab.paper.by_load import (
    COEFFICIENTS,
    as_identified,
    deviations,
    errors,
    uniform_force,
    worst,
)


def test_uniform_motions_keep_their_force_and_the_guide_has_less_friction_of_its_own() -> None:
    changes = as_identified("as-measured", 0.05)
    for axis in "xy":
        plain = uniform_force({"plant": "as-measured"}, axis)
        assert uniform_force(changes, axis) == pytest.approx(plain, rel=1e-3)
        (effect,) = changes[f"plant.{axis}.effects"]
        assert effect["mu"] == 0.05
        assert changes[f"plant.{axis}.friction.enabled"] is False
    by_axis = [changes[f"plant.{axis}.effects"][0]["F_c"] for axis in "xy"]
    free = [as_identified("as-measured", 0.01)[f"plant.{a}.effects"][0]["F_c"] for a in "xy"]
    assert all(less < more for less, more in zip(by_axis, free, strict=True))


def test_the_worst_of_four_counts() -> None:
    assert deviations([20.5e-6, 17.4e-6, 10.4e-6, 11.6e-6]) == pytest.approx([0.0] * 4)
    assert worst([20.5e-6, 17.4e-6, 5.2e-6, 11.6e-6]) == pytest.approx(0.5)


def test_more_friction_by_load_makes_larger_errors_with_compensation() -> None:
    none, some = errors("nominal", 0.0), errors("nominal", 0.05)
    assert some[2] > 4.0 * none[2]
    assert worst(none) == pytest.approx(0.75, abs=0.01)
    assert 0.054 in COEFFICIENTS
