"""``motionlab montecarlo`` and ``POST /montecarlo``: one document, recipes, what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
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
from motionlab.studies.montecarlo.documents import MonteCarloDocument, read_request
from motionlab.studies.montecarlo.draw import own_value
from tests.server.live import API, until

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


def corner(a_max: float) -> dict[str, Any]:
    points = [[0.0, 0.0], [0.004, 0.0], [0.004, 0.004]]
    limits = {"v_max": 0.1, "a_max": a_max, "j_max": 1000.0}
    return {"kind": "path", "law": "time_optimal", "points": points} | limits


def test_a_case_of_a_time_optimal_path_keeps_the_motion_of_the_study() -> None:
    """A path that names no motor would be planned anew for the case's own, here a lighter one."""
    vary = [{"path": "mass", "kind": "uniform", "low": 5.0, "high": 5.4}]
    changes = {"trajectory": corner(20.0)}
    study = run_cases(plan(read_request({"cases": 2, "set": changes, "vary": vary})))
    worst = study.worst[0]
    prepared = prepare(load_scenario("circle", changes | worst.set))
    again = document(prepared, run(prepared))["variants"][worst.variant]["axes"][worst.axis]
    assert again["max_abs_following_error"] == worst.value
    alone = {key: value for key, value in worst.set.items() if key.startswith("plant.")}
    anew = prepare(load_scenario("circle", changes | alone))
    assert anew.reference.ticks < prepared.reference.ticks


def test_the_options_of_a_case_keep_the_motion_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = tmp_path / "corner.toml"
    keys = (f"{key} = {json.dumps(value)}\n" for key, value in corner(0.5).items())
    scenario.write_text('base = "circle"\n[trajectory]\n' + "".join(keys))
    assert main(["montecarlo", str(scenario), "--case", "1"]) == 0
    options = capsys.readouterr().out.split()
    assert sum(option.startswith("trajectory.planned_for=") for option in options) == 1
    assert main(["run", str(scenario), *options, "--json"]) == 0
    ran = json.loads(capsys.readouterr().out)["variants"]["B"]["axes"]["x"]
    found = run_cases(plan(read_request({"cases": 2}), scenario))
    assert ran["max_abs_following_error"] == found.variants["B"].axes["x"].peaks[1]


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


def test_histograms_count_every_case_in_common_bins(found: MonteCarloDocument) -> None:
    counts = found.histograms["y"]["max_abs_following_error"]
    assert counts is not None
    for name, variant in found.variants.items():
        peaks = np.array(variant.axes["y"].peaks, dtype=float)
        assert counts.counts[name] == np.histogram(peaks, counts.edges)[0].tolist()
        assert sum(counts.counts[name]) == found.cases
    assert found.histograms["y"]["overshoot"] is None  # the circle has no hold


def test_correlations_are_of_ranks_over_the_cases(found: MonteCarloDocument) -> None:
    from scipy.stats import spearmanr

    draws = plan(read_request(BODY)).draws
    told = found.variants["B"].axes["x"].correlations["max_abs_following_error"]
    peaks = np.array(found.variants["B"].axes["x"].peaks, dtype=float)
    names = [(parameter.path, parameter.of) for parameter in found.parameters["x"]]
    own = load_scenario("circle").plant.x.model_dump(mode="json")
    assert len(names) == 2 * 15  # nine numbers, and two of each of three phases
    assert "force_map.F_pk" not in dict(names), "it is the same in every case"
    for (path, of), rho in zip(names, told, strict=True):
        *whole, last = path.split(".")
        item = int(last) if last.isdigit() else None
        key = ".".join(("plant.x", *whole, *([last] if item is None else [])))
        values = np.array([case[key] if item is None else case[key][item] for case in draws])
        if of == "deviation":
            base = own_value(own, ".".join(key.split(".")[2:])).ravel()[item or 0]
            logarithmic = path.startswith("friction") or path == "amplifiers.bandwidth"
            values = np.abs(np.log(values / base) if logarithmic else values - base)
        assert rho == pytest.approx(spearmanr(values, peaks)[0], abs=1e-4)


def test_what_decides_is_found_and_told() -> None:
    """The error of PD alone is the friction that it has to overcome."""
    vary = [
        {"path": "friction.F_c", "kind": "uniform", "low": 1.0, "high": 3.0},
        {"path": "amplifiers.bandwidth", "kind": "uniform", "low": 1000.0, "high": 1100.0},
    ]
    some = run_cases(plan(read_request(BODY | {"vary": vary, "cases": 40})))
    rhos = some.variants["A"].axes["x"].correlations["rms_following_error"]
    friction, _, bandwidth, _ = rhos
    assert friction is not None and bandwidth is not None
    assert friction > 0.9 > some.significant > abs(bandwidth)
    # Student's t of 38 degrees of freedom at 1 - 0.05/8 is 2.629
    assert some.significant == pytest.approx(2.629 / math.sqrt(38 + 2.629**2), abs=1e-3)
    assert some.derived()["max |e| of A x goes with"] == "friction.F_c +1.00"


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
    with pytest.raises(ConfigError, match=r"cases\.\d+: plant\.x\.amplifiers\.gain.*vary it less"):
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
