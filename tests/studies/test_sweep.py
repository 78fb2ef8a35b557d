"""Sweeps: each case as its run alone gives it, by command, by call, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.executors.executor import current
from motionlab.simulation import batch as module
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run as run_alone
from motionlab.studies.sweep.documents import SweepDocument
from motionlab.studies.sweep.request import read_request
from motionlab.studies.sweep.run import plan, run
from tests.server.live import API, until

SHORT = {"trajectory.laps": 2}
GAIN = "variants.B.controller.x.k_p"
PEAK = "max_abs_following_error"


def sweep(*grid: dict[str, Any], **rest: Any) -> SweepDocument:
    return run(plan(read_request({"set": SHORT, "grid": list(grid)} | rest)))


def metrics_alone(changes: dict[str, Any]) -> dict[str, Any]:
    prepared = prepare(load_scenario("circle", SHORT | changes))
    return document(prepared, run_alone(prepared))["variants"]


def test_each_case_has_the_metrics_of_its_run_alone() -> None:
    gains = {"path": GAIN, "values": [200300, 300e3]}
    trajectories = {"path": "trajectory.frequency", "start": 0.5, "stop": 1.0, "count": 2}
    found = sweep(gains, {"path": "plant", "values": ["nominal", "matched"]}, trajectories)
    assert found.shape == [2, 2, 2]
    assert [field.unit for field in found.fields] == ["N/m", "", "Hz"]
    cases = plan(read_request({"grid": [gains, trajectories]})).cases
    assert cases[1] == {GAIN: 200300, "trajectory.frequency": 1.0}  # the last field is fastest
    for case in (1, 6):
        at = np.unravel_index(case, found.shape)
        changes = {f.path: f.values[i] for f, i in zip(found.fields, at, strict=True)}
        for name, variant in metrics_alone(changes).items():
            for axis, metrics in variant["axes"].items():
                for metric, values in found.variants[name].axes[axis].metrics.items():
                    value = metrics.get(metric)
                    assert values[case] == (value and float(f"{value:.7g}")), (case, name, metric)


def test_cases_in_parcels_are_those_of_one_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = {"path": GAIN, "start": 1e5, "stop": 1e6, "count": 5, "scale": "log"}
    whole = sweep(grid)
    monkeypatch.setattr(module, "_TOGETHER", 2)
    assert sweep(grid) == whole
    peaks = whole.variants["B"].axes["x"].metrics[PEAK]
    assert whole.fields[0].values[::4] == [1e5, 1e6]
    best = next(b for b in whole.best if (b.variant, b.axis, b.metric) == ("B", "x", PEAK))
    assert best.case == int(np.argmin(np.array(peaks)))
    assert peaks[4] is not None and peaks[0] is not None and peaks[4] < 0.2 * peaks[0]


def test_a_list_takes_values_together() -> None:
    found = sweep(
        {"path": "seed", "values": [1, 2, 3]},
        {"path": "plant.x.mass", "values": [5.0, 6.0, 7.0]},
        combine="list",
    )
    assert (found.shape, found.cases) == ([3], 3)
    alone = metrics_alone({"seed": 3, "plant.x.mass": 7.0})["B"]["axes"]["x"][PEAK]
    assert found.variants["B"].axes["x"].metrics[PEAK][2] == float(f"{alone:.7g}")


def test_fields_below_what_the_scenario_leaves_out_can_be_swept() -> None:
    start, end = {"path": "window.start", "values": [1.0]}, {"path": "window.end", "values": [3.0]}
    found = sweep(start, end, combine="list")
    window = {"window": {"start": 1.0, "end": 3.0}}
    alone = metrics_alone(window)["A"]["axes"]["x"][PEAK]
    assert found.variants["A"].axes["x"].metrics[PEAK] == [float(f"{alone:.7g}")]


def test_cases_that_diverge_or_cannot_be_followed_are_named() -> None:
    found = sweep({"path": "divergence_error", "values": [1e-3, 1e-5]})
    assert (found.variants["A"].diverged, found.variants["B"].diverged) == ([1], [])
    assert found.variants["A"].axes["x"].metrics[PEAK][1] is None
    found = sweep({"path": "trajectory.frequency", "values": [0.5, 50.0]})
    assert found.infeasible == [1]
    assert found.variants["A"].axes["y"].metrics[PEAK][1] is None


@pytest.mark.parametrize(
    ("grid", "said"),
    [
        ([], "grid"),
        ([{"path": GAIN}], "needs values, or start, stop and count"),
        ([{"path": GAIN, "values": [1.0], "count": 3}], "not both"),
        ([{"path": GAIN, "start": 0.0, "stop": 1.0, "count": 3, "scale": "log"}], "above 0"),
        ([{"path": GAIN, "values": [1.0]}] * 2, "is swept twice"),
        (
            [{"path": f"plant{end}", "values": ["matched"]} for end in ("", ".base")],
            "plant.base is swept twice, also as plant",
        ),
        ([{"path": GAIN, "start": -1e308, "stop": 1e308, "count": 3}], "too wide a range"),
        ([{"path": "seed", "start": 1, "stop": 2, "count": 3}], "whole numbers, and the range"),
        ([{"path": GAIN, "values": [1.0, None]}], "values.1: must be a number, a name or true or"),
        ([{"path": GAIN, "values": [1.0, -5.0, 2.0]}], f"grid.0.values.1: {GAIN}: is out of range"),
        ([{"path": f"plant.{a}.mass", "start": 1, "stop": 2, "count": 101} for a in "xy"], "10201"),
        ([{"path": "plant.x.mas", "values": [1.0]}], "did you mean 'mass'"),
        ([{"path": GAIN, "values": [-5.0]}], f"grid.0.values.0: {GAIN}: is out of range"),
        (
            [{"path": GAIN, "start": 1.0, "stop": -5.0, "count": 2}],
            f"grid.0.stop: {GAIN}: is out of",
        ),
        ([{"path": "variants", "values": ["A"]}], "grid.0"),
        ([{"path": GAIN, "values": [float("nan")]}], "grid.0"),
    ],
)
def test_what_is_no_sweep_is_refused(grid: list[Any], said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        plan(read_request({"grid": grid}))
    assert said in str(caught.value)


def test_a_set_field_inside_of_a_swept_part_holds_in_each_case() -> None:
    swept = {"path": "plant", "values": ["nominal", "matched"]}
    found = sweep(swept, set=SHORT | {"plant.x.mass": 9.0, "variants.A.label": "mine"})
    alone = metrics_alone({"plant": "matched", "plant.x.mass": 9.0})["B"]["axes"]["x"][PEAK]
    assert found.variants["B"].axes["x"].metrics[PEAK][1] == float(f"{alone:.7g}")
    assert found.best[0].set.keys() == {"plant"}
    swept = {"path": "plant.x.mass", "values": [9.0]}
    again = sweep(swept, set=SHORT | {"plant": "matched"})
    assert again.variants["B"].axes["x"].metrics[PEAK] == [float(f"{alone:.7g}")]


def test_a_range_of_whole_numbers_gives_them_to_a_field_that_takes_nothing_else() -> None:
    laps = {"path": "trajectory.laps", "start": 1, "stop": 4, "count": 3, "scale": "log"}
    seeds = {"path": "seed", "start": 1, "stop": 3, "count": 3}
    planned = plan(read_request({"grid": [laps, seeds], "combine": "list"}))
    assert repr(planned.points) == "[[1, 2, 4], [1, 2, 3]]"


def test_a_refusal_names_the_case_and_its_values() -> None:
    late = {"path": "window.end", "values": [5.0, 8.0]}
    whole = {"path": "window.start", "values": [1.0, 9.0]}
    said = r"grid: case 1: window: .*, with window.start = 9.0, window.e"
    with pytest.raises(ConfigError, match=said):
        plan(read_request({"grid": [whole, late], "combine": "list"}))
    window = {"window": {"start": 1.0, "end": 3.0}}
    late = {"path": "window.end", "values": [5.0, 800.0]}
    with pytest.raises(ConfigError, match=r"cases.1: window.end: lies after.*window.end = 800"):
        run(plan(read_request({"set": window, "grid": [late]})))
    laps = {"path": "trajectory.laps", "values": [2, 1000]}
    said = (
        r"grid.0.values.1: case 1: trajectory: is too long.*, with trajectory.laps = 1000; got .* s"
    )
    with pytest.raises(ConfigError, match=said):
        plan(read_request({"grid": [laps]}))


def test_the_time_of_each_case_counts() -> None:
    seconds = {"path": "trajectory.duration", "values": [0.1, 100.0]}
    point = {"trajectory": {"kind": "point", "duration": 0.05}}
    planned = plan(read_request({"set": point, "grid": [seconds]}))
    assert planned.seconds == pytest.approx(2 * 100.1)


def test_metrics_that_no_field_moves_have_no_best_case(capsys: pytest.CaptureFixture[str]) -> None:
    short = ["--set", "trajectory.laps=2"]
    assert main(["sweep", "circle", *short, "--grid", f"{GAIN}=2e5,4e5"]) == 0
    said = capsys.readouterr().out
    assert "\nB.x.k_p, N/m " in said
    assert "um in every case\n" in said[said.index("best for A x") :]
    assert f"at {GAIN} = 400000" in said[said.index("best for B x") :]


def test_the_first_results_come_before_the_last_cases() -> None:
    sizes = [part.stop - part.start for part in current().parts(10_000, 1000)]
    assert sizes[:4] == [64, 128, 256, 512]
    assert sum(sizes) == 10_000
    assert max(sizes) == 1000


def test_a_value_of_no_kind_is_one_error() -> None:
    with pytest.raises(ConfigError) as caught:
        read_request({"scenario": 3, "grid": [{"path": "seed", "values": [None]}]})
    assert [error.loc for error in caught.value.errors] == ["scenario", "grid.0.values.0"]
    assert "scenario: must be a name or a table; got 3" in str(caught.value)


def test_a_list_of_unequal_lengths_is_refused() -> None:
    lists = [{"path": "seed", "values": [1, 2]}, {"path": "plant.x.mass", "values": [5.0]}]
    with pytest.raises(ConfigError, match=r"as many values of each field, not \[2, 1\]"):
        read_request({"grid": lists, "combine": "list"})


def test_the_command_prints_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "gains.csv"
    command = ["sweep", "circle", "--set", "trajectory.laps=2", "--grid", f"{GAIN}=2e5:4e5:3"]
    assert main([*command, "--out", str(table)]) == 0
    assert "k_p, N/m" in capsys.readouterr().out
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert [row[GAIN] for row in rows] == ["200000.0", "300000.0", "400000.0"]
    assert main([*command, "--json"]) == 0
    found = SweepDocument(**json.loads(capsys.readouterr().out))
    assert float(rows[1][f"B.x.{PEAK}"]) == found.variants["B"].axes["x"].metrics[PEAK][1]
    assert main(["sweep", "--grid", f"{GAIN}=1:2"]) == 2
    assert "PATH=FROM:TO:COUNT" in capsys.readouterr().err


def test_a_job_gives_what_the_command_prints(client: httpx.Client) -> None:
    body = {"set": SHORT, "grid": [{"path": GAIN, "start": 2e5, "stop": 4e5, "count": 3}]}
    accepted = client.post(f"{API}/sweep", json=body)
    assert accepted.status_code == 202
    job = accepted.headers["location"]
    until(lambda: client.get(job).json()["state"] == "done")
    report = client.get(job).json()
    assert report["kind"] == "sweep"
    assert SweepDocument(**report["result"]) == run(plan(read_request(body)))
    many = {"path": "plant.x.mass", "start": 5, "stop": 6, "count": 10_000}
    refused = client.post(f"{API}/sweep", json={"grid": [many]})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["range"] == "<= 100000"


@pytest.mark.parametrize(
    ("request_", "loc", "field"),
    [
        ({"grid": [{"path": GAIN, "values": [1.0, -5.0]}]}, "grid.0.values.1", GAIN),
        (
            {"grid": [{"path": "plant.x.mass", "start": 5, "stop": -1, "count": 3}]},
            "grid.0.stop",
            "plant.x.mass",
        ),
        (
            {
                "grid": [
                    {"path": "seed", "values": [1, 2]},
                    {"path": "trajectory.laps", "values": [2, 1000]},
                ],
                "combine": "list",
            },
            "grid.1.values.1",
            "case 1: trajectory",
        ),
        (
            {
                "grid": [
                    {"path": "window.start", "values": [1.0, 9.0]},
                    {"path": "window.end", "values": [5.0, 8.0]},
                ],
                "combine": "list",
            },
            "grid",
            "case 1: window",
        ),
        (
            {
                "grid": [{"path": "trajectory.laps", "start": 2, "stop": 2000}],
                "combine": "random",
                "samples": 4,
            },
            "grid.0",
            "case 0: trajectory",
        ),
    ],
)
def test_a_refused_case_is_a_place_in_the_request(
    client: httpx.Client, request_: dict[str, Any], loc: str, field: str
) -> None:
    answer = client.post(f"{API}/sweep", json=request_)
    assert answer.status_code == 422
    error = answer.json()["errors"][0]
    assert (error["loc"], error["message"].rpartition(": ")[0]) == (loc, field)
