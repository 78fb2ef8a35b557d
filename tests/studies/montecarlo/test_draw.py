"""Drawn plants: where they come from, how they are spread, what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.studies.montecarlo.cases import probability
from motionlab.studies.montecarlo.documents import DEFAULT, Variation, read_request
from motionlab.studies.montecarlo.draw import draw, missing

PLANT: dict[str, Any] = load_scenario("circle").plant.model_dump(mode="json")
MANY = 4000


def drawn(path: str, axis: str = "x") -> np.ndarray[Any, Any]:
    cases = draw(PLANT, DEFAULT, cases=MANY, seed=1)
    return np.array([case[f"plant.{axis}.{path}"] for case in cases])


def test_log_normal_draws_have_their_sigma_about_the_plant() -> None:
    logs = np.log(drawn("friction.sigma_1") / PLANT["x"]["friction"]["sigma_1"])
    assert logs.mean() == pytest.approx(0.0, abs=0.03)
    assert logs.std() == pytest.approx(0.4, rel=0.05)


def test_each_phase_is_drawn_on_its_own() -> None:
    offsets = drawn("amplifiers.offset")
    assert offsets.shape == (MANY, 3)
    assert offsets.std(axis=0) == pytest.approx([0.1] * 3, rel=0.06)
    assert abs(np.corrcoef(offsets.T)[0, 1]) < 0.06


def test_ranges_are_kept() -> None:
    h_2, bandwidth = drawn("force_map.h_2"), drawn("amplifiers.bandwidth")
    assert -0.05 <= h_2.min() < -0.049
    assert 0.049 < h_2.max() <= 0.05
    assert 300.0 <= bandwidth.min() < 303.0
    assert 1980.0 < bandwidth.max() <= 2000.0
    assert set(drawn("force_map.F_pk")) == {38.4}


def test_axes_and_paths_are_independent() -> None:
    x, y = np.log(drawn("friction.v_s")), np.log(drawn("friction.v_s", "y"))
    assert abs(np.corrcoef(x, y)[0, 1]) < 0.06
    assert abs(np.corrcoef(x, np.log(drawn("friction.sigma_1")))[0, 1]) < 0.06


def test_a_case_is_the_same_whatever_is_drawn_beside_it() -> None:
    all_of_them = draw(PLANT, DEFAULT, cases=20, seed=5)
    few = draw(PLANT, DEFAULT[3:5], cases=7, seed=5)
    for case, more in zip(few, all_of_them, strict=False):
        assert case.items() <= more.items()
    assert draw(PLANT, DEFAULT, cases=1, seed=6)[0] != all_of_them[0]


def test_stiction_is_never_below_coulomb_friction() -> None:
    wide = (Variation(path="friction.F_c", kind="log-normal", sigma=2.0),)
    cases = draw(PLANT, wide, cases=200, seed=1)
    raised = [case for case in cases if "plant.y.friction.F_s" in case]
    assert 0 < len(raised) < len(cases)
    for case in raised:
        assert case["plant.y.friction.F_s"] == case["plant.y.friction.F_c"]


def test_a_table_has_no_peak_to_vary() -> None:
    table = load_scenario("circle", {"plant.x.force_map": {"kind": "table", "name": "new-design"}})
    paths = missing(table.plant.model_dump(mode="json"), DEFAULT)
    assert paths == ["force_map.F_pk", "force_map.h_2", "force_map.h_3"]


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        ({"cases": 1}, r"cases: .*got 1; allowed >= 2"),
        ({"cases": 100_000}, r"cases: .*got 100000; allowed .*<= 5000"),
        ({"seed": -1}, "seed"),
        ({"spec": {"x": 0.0}}, r"spec\.x"),
        ({"vary": []}, "vary"),
        ({"vary": [{"path": "mass", "kind": "normal", "sigma": -1.0}]}, r"sigma: .*got -1"),
        ({"vary": [{"path": "mass", "kind": "log-normal", "sigma": 9.0}]}, "at most 3"),
        ({"vary": [{"path": "mass", "kind": "uniform", "low": 2.0, "high": 1.0}]}, "above high"),
        (
            {"vary": [{"path": "mass", "kind": "uniform", "low": -1e308, "high": 1e308}]},
            "too far apart",
        ),
        ({"vary": [{"path": "mass", "kind": "log-uniform", "low": 0.0, "high": 1.0}]}, "logarithm"),
        ({"vary": [{"path": "mass", "kind": "uniform", "sigma": 1.0}]}, "low and high"),
        ({"vary": [{"path": "trajectory.laps", "kind": "value", "value": 1.0}]}, "path"),
        ({"vary": [{"path": "mass", "kind": "value", "value": 1.0}] * 2}, "varied twice"),
    ],
)
def test_nonsense_is_refused_by_name(request_: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read_request(request_)


@pytest.mark.parametrize("path", ["friction.mu", "friction.enabled", "resonance.sigma"])
def test_what_is_no_number_of_the_plant_is_refused(path: str) -> None:
    with pytest.raises(ConfigError, match=r"vary\.0\.path"):
        draw(PLANT, (Variation(path=path, kind="log-normal", sigma=0.1),), cases=2, seed=1)


def test_interval_of_a_share() -> None:
    half = probability(150, 300)
    assert (half.low, half.share, half.high) == pytest.approx((0.4437, 0.5, 0.5563), abs=1e-4)
    none = probability(0, 300)
    assert (none.low, none.high) == pytest.approx((0.0, 0.01264), abs=1e-5)
