"""``motionlab montecarlo`` and ``POST /montecarlo``: one document, recipes, what is refused."""

from __future__ import annotations

import json
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.studies.montecarlo.cases import plan, run_cases
from motionlab.studies.montecarlo.document import MonteCarloDocument
from motionlab.studies.montecarlo.request import read_request
from tests.service.live import API, until

SET = {"trajectory.frequency": 2.0, "trajectory.radius": 0.005}
BODY: dict[str, Any] = {"cases": 12, "set": SET, "spec": {"x": 3e-5, "y": 4e-5}}
COMMAND = [
    *("montecarlo", "--cases", "12", "--spec", "x=3e-5", "--spec", "y=4e-5"),
    *(part for path, value in SET.items() for part in ("--set", f"{path}={value}")),
]


@pytest.fixture(scope="module")
def found() -> MonteCarloDocument:
    return run_cases(plan(read_request(BODY)))


def test_the_job_ends_with_what_the_command_prints(
    client: httpx.Client, capsys: pytest.CaptureFixture[str], found: MonteCarloDocument
) -> None:
    response = client.post(f"{API}/montecarlo", json=BODY)
    assert response.status_code == 202, response.text
    location = response.headers["location"]
    until(lambda: client.get(location).json()["state"] in {"done", "failed"})
    report = client.get(location).json()
    assert report["error"] is None
    assert report["kind"] == "monte-carlo"
    assert main([*COMMAND, "--json"]) == 0
    assert report["result"] == json.loads(capsys.readouterr().out) == found.model_dump(mode="json")


def test_the_worst_case_can_be_run_again_to_the_last_bit(found: MonteCarloDocument) -> None:
    worst = found.worst[-1]
    prepared = prepare(load_scenario("circle", SET | worst.set))
    again = document(prepared, run(prepared))["variants"][worst.variant]["axes"][worst.axis]
    assert again["max_abs_following_error"] == worst.value


def test_a_case_is_printed_as_options_of_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*COMMAND, "--case", "3"]) == 0
    options = capsys.readouterr().out.split()
    assert "trajectory.radius=0.005" in options
    assert main(["run", "circle", *options, "--json"]) == 0
    ran = json.loads(capsys.readouterr().out)["variants"]["B"]["axes"]["y"]
    peaks = run_cases(plan(read_request(BODY))).variants["B"].axes["y"].peaks
    assert ran["max_abs_following_error"] == peaks[3]


def test_quantiles_are_those_of_the_cases(found: MonteCarloDocument) -> None:
    for variant in found.variants.values():
        for axis in variant.axes.values():
            peaks = np.array(axis.peaks, dtype=float)
            spread = axis.metrics["max_abs_following_error"]
            assert spread is not None
            assert spread.cases == len(peaks) == found.cases
            assert (spread.min, spread.max) == (peaks.min(), peaks.max())
            assert spread.q50 == np.median(peaks)
            assert spread.min <= spread.q05 <= spread.q50 <= spread.q95 <= spread.max


def test_share_that_meets_the_spec_needs_both_axes(found: MonteCarloDocument) -> None:
    for variant in found.variants.values():
        x, y = (np.array(variant.axes[axis].peaks, dtype=float) for axis in ("x", "y"))
        assert variant.meets is not None
        assert variant.meets.share == np.mean((x <= 3e-5) & (y <= 4e-5))


def test_bands_lie_one_in_another_and_hold_every_peak(found: MonteCarloDocument) -> None:
    for variant in found.variants.values():
        for axis in variant.axes.values():
            assert axis.band is not None
            rows = np.array(list(axis.band.model_dump().values()))
            assert rows.shape == (7, len(found.time))
            assert (np.diff(rows, axis=0) >= 0.0).all()
            spread = axis.metrics["max_abs_following_error"]
            assert spread is not None
            assert np.abs(rows).max() == pytest.approx(spread.max, rel=1e-4)


def test_improvement_is_of_each_case(found: MonteCarloDocument) -> None:
    a, b = (np.array(found.variants[name].axes["x"].peaks, dtype=float) for name in "AB")
    improvement = found.improvement["x"]["max_abs_following_error"]
    assert improvement is not None
    assert improvement.q50 == pytest.approx(np.median(1.0 - b / a))


def test_progress_ends_a_study() -> None:
    def enough(share: float) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_cases(plan(read_request(BODY)), enough)


def test_a_plant_that_cannot_follow_counts_against_the_spec() -> None:
    heavy = [{"path": "friction.F_c", "kind": "uniform", "low": 1.0, "high": 60.0}]
    some = run_cases(plan(read_request(BODY | {"vary": heavy, "cases": 30, "spec": {"x": 1.0}})))
    assert 0 < some.infeasible < 30
    assert some.variants["A"].axes["x"].peaks.count(None) == some.infeasible
    assert some.variants["A"].meets is not None
    assert some.variants["A"].meets.share == pytest.approx(1.0 - some.infeasible / 30)


def test_a_draw_out_of_range_names_case_and_number() -> None:
    wild = [{"path": "amplifiers.gain", "kind": "normal", "sigma": 5.0}]
    with pytest.raises(ConfigError, match=r"case \d+: plant\.x\.amplifiers\.gain.*vary it less"):
        run_cases(plan(read_request(BODY | {"vary": wild})))


def test_too_much_is_refused(client: httpx.Client) -> None:
    body = {"scenario": "fig5", "cases": 5000}
    response = client.post(f"{API}/montecarlo", json=body)
    assert response.status_code == 422
    assert response.json()["errors"][0]["loc"] == "cases"
    nonsense = client.post(f"{API}/montecarlo", json={"cases": 0})
    assert nonsense.status_code == 422
    assert nonsense.json()["errors"][0]["value"] == 0
    assert main(["montecarlo", "--case", "400"]) == 2
