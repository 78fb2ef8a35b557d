"""Sweeps whose cases are drawn or searched: what is drawn, objectives, limits, fronts, refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.library.stability_margins import stability_margins
from motionlab.studies.sweep.documents import SweepDocument
from motionlab.studies.sweep.figures import Criteria, front_of
from motionlab.studies.sweep.report import report
from motionlab.studies.sweep.request import SAMPLINGS, read_request
from motionlab.studies.sweep.run import plan, run

SHORT = {"trajectory.laps": 1}
K_P, K_D = "variants.B.controller.x.k_p", "variants.B.controller.x.k_d"
PEAK = "B.x.max_abs_following_error"
GAINS = [
    {"path": K_P, "start": 1e5, "stop": 1e6, "scale": "log"},
    {"path": K_D, "start": 500.0, "stop": 3000.0},
]


def sweep(**request: Any) -> SweepDocument:
    return run(plan(read_request({"set": SHORT, "grid": GAINS} | request)))


def test_the_best_case_meets_all_limits() -> None:
    gains = {"path": "variants.B.controller.x.k_p", "values": [1e5, 2e6]}
    limit = {"of": "B.x.gain_margin", "at_least": 5.0}
    of_all, within, none = (
        run(plan(read_request({"set": SHORT, "grid": [gains], "limits": limits})))
        for limits in ([], [limit], [limit | {"at_least": 1e3}])
    )
    assert within.limits[0].exceeded == [1]
    assert {each.case for each in of_all.best if each.variant == "B" and each.axis == "x"} == {1}
    assert {each.case for each in within.best if each.variant == "B"} == {0}
    assert none.best == [] and "no case meets all limits" in report(none)


@pytest.mark.parametrize("method", SAMPLINGS)
def test_drawn_cases_fill_the_ranges_and_repeat(method: str) -> None:
    request = {"combine": method, "samples": 64, "grid": GAINS}
    cases = plan(read_request(request)).cases
    assert cases == plan(read_request(request)).cases
    assert cases != plan(read_request(request | {"sampling_seed": 1})).cases
    shares = np.array([[np.log10(case[K_P] / 1e5), (case[K_D] - 500) / 2500] for case in cases])
    assert shares.min() >= 0.0 and shares.max() <= 1.0
    # A Latin hypercube has one case in each of 64 slices; both even ones have 8 in each of 8.
    counts = np.array([np.histogram(column, 8, (0.0, 1.0))[0] for column in shares.T])
    assert (counts == 8).all() == (method != "random")


def test_whole_numbers_and_names_are_drawn_too() -> None:
    grid = [
        {"path": "seed", "start": 1, "stop": 4},
        {"path": "plant", "values": ["nominal", "matched"]},
    ]
    planned = plan(read_request({"grid": grid, "combine": "sobol", "samples": 64}))
    assert sorted(set(planned.points[0])) == [1, 2, 3, 4]
    assert all(type(value) is int for value in planned.points[0])
    assert planned.points[1].count("nominal") == 32


def test_a_drawn_case_has_the_figures_of_its_own() -> None:
    found = sweep(
        combine="latin-hypercube",
        samples=5,
        objectives=[PEAK, "B.worst.gain_margin"],
        limits=[{"of": "B.x.phase_margin", "at_least": 0.9}],
    )
    assert found.shape == [5]
    for case in range(5):
        changes = {field.path: field.values[case] for field in found.fields}
        margins = stability_margins(load_scenario("circle", SHORT | changes))
        worst = min(margins[f"B.{axis}.gain_margin"] for axis in "xy")
        assert found.objectives[1].values[case] == pytest.approx(worst, rel=1e-6)
        met = margins["B.x.phase_margin"] >= 0.9
        assert (case in found.limits[0].exceeded) == (not met)
    peaks = found.variants["B"].axes["x"].metrics["max_abs_following_error"]
    assert found.objectives[0].values == peaks
    assert (found.objectives[0].falls, found.objectives[1].falls) == (True, False)
    assert set(found.front).isdisjoint(found.limits[0].exceeded)


def test_a_front_holds_what_nothing_betters() -> None:
    costs = np.array([[1.0, 5.0], [2.0, 4.0], [2.0, 4.0], [3.0, 4.5], [np.nan, 0.0], [9.0, 0.0]])
    met = np.array([True, True, True, True, True, False])
    assert front_of(costs, met) == [0, 1]
    assert front_of(costs, np.ones(6, dtype=bool)) == [0, 1, 5]
    assert front_of(costs[:, :1], met) == [0]
    assert front_of(costs[:, :0], met) == []


@pytest.mark.parametrize("searcher", ["cma-es", "nsga-ii", "tpe"])
def test_a_search_finds_better_cases_than_as_many_drawn_ones(searcher: str) -> None:
    question: dict[str, Any] = {
        "samples": 96,
        "objectives": [PEAK],
        "limits": [{"of": "B.x.phase_margin", "at_least": 0.8}],
    }
    searched = sweep(combine="search", searcher=searcher, **question)
    assert searched == sweep(combine="search", searcher=searcher, **question)
    random = sweep(combine="random", **question)
    (best,), (drawn,) = searched.front, random.front
    assert best not in searched.limits[0].exceeded
    least, of_drawn = searched.objectives[0].values[best], random.objectives[0].values[drawn]
    assert least is not None and of_drawn is not None and least < of_drawn


def test_searched_cases_that_diverge_are_avoided_not_fatal() -> None:
    found = sweep(
        grid=[{"path": "divergence_error", "start": 1e-6, "stop": 1e-3, "scale": "log"}, GAINS[0]],
        combine="search",
        searcher="nsga-ii",
        samples=64,
        objectives=["A.x.max_abs_following_error"],
    )
    assert 0 < len(found.variants["A"].diverged) < 64
    assert len(found.front) == 1


def test_several_objectives_take_nsga_ii_and_give_a_front() -> None:
    found = sweep(combine="search", samples=96, objectives=[PEAK, "B.x.gain_margin"])
    assert len(found.front) > 5
    peaks, margins = (np.array(each.values, dtype=float) for each in found.objectives)
    assert (np.diff(peaks[found.front]) > 0.0).all()
    assert (np.diff(margins[found.front]) > 0.0).all()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"combine": "sobol"}, "sobol needs samples"),
        ({"samples": 8}, "samples is for cases that are drawn"),
        ({"sampling_seed": 0}, "sampling_seed is for cases that are drawn or searched"),
        ({"combine": "list", "sampling_seed": 3}, "sampling_seed is for cases that are drawn"),
        ({"combine": "sobol", "samples": 8, "searcher": "tpe"}, "searcher is for combine = search"),
        ({"combine": "search", "samples": 8}, "needs objectives"),
        (
            {
                "combine": "search",
                "samples": 8,
                "searcher": "cma-es",
                "objectives": [PEAK, "B.x.rms_force"],
            },
            "cma-es takes one objective",
        ),
        (
            {"combine": "sobol", "samples": 8, "grid": [{**GAINS[0], "count": 4}]},
            "grid.0.count is for a grid",
        ),
        ({"combine": "sobol", "samples": 0}, "samples"),
        ({"combine": "sobol", "samples": 10_001}, "10000"),
        (
            {"combine": "sobol", "samples": 8, "objectives": ["C.x.rms_force"]},
            "names no controller",
        ),
        ({"combine": "sobol", "samples": 8, "objectives": ["B.x.rms"]}, "names no metric"),
        ({"combine": "sobol", "samples": 8, "objectives": ["B.rms_force"]}, "is no metric"),
        ({"combine": "sobol", "samples": 8, "objectives": [PEAK, PEAK]}, "is there twice"),
        (
            {"combine": "sobol", "samples": 8, "objectives": ["B.x.mean_following_error"]},
            "has a sign",
        ),
        ({"combine": "sobol", "samples": 8, "limits": [{"of": PEAK}]}, "needs at_least or at_most"),
        (
            {
                "combine": "sobol",
                "samples": 8,
                "limits": [{"of": PEAK, "at_least": 2.0, "at_most": 1.0}],
            },
            "is above at_most",
        ),
        (
            {"combine": "sobol", "samples": 8, "grid": [{"path": "seed", "start": 1, "stop": 2.5}]},
            "takes whole numbers",
        ),
        (
            {"combine": "sobol", "samples": 8, "grid": [{"path": K_P, "start": -1.0, "stop": 2.0}]},
            "k_p",
        ),
        (
            {
                "combine": "search",
                "samples": 8,
                "searcher": "cma-es",
                "objectives": [PEAK],
                "grid": GAINS[:1],
            },
            "takes two fields or more",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said.replace(".", r"\.")):
        plan(read_request({"set": SHORT, "grid": GAINS} | changes))


@pytest.mark.parametrize("metric", ["rms", "mean_following_error"])
def test_a_refused_objective_lists_what_can_be_one(metric: str) -> None:
    request = {"set": SHORT, "grid": GAINS, "combine": "sobol", "samples": 8}
    with pytest.raises(ConfigError) as refused:
        plan(read_request(request | {"objectives": [f"B.x.{metric}"]}))
    (error,) = refused.value.errors
    assert (error.loc, error.value) == ("objectives.0", metric)
    names = error.range.removeprefix("one of ").split(", ")
    scenario = load_scenario("circle")
    for first in range(0, len(names), 4):
        some = tuple(f"B.x.{name}" for name in names[first : first + 4])
        asked = read_request(request | {"objectives": some})
        assert len(Criteria.of(asked, scenario).objectives) == len(some)
    limit = {"of": "B.x.mean_following_error", "at_most": 1e-6}
    assert len(Criteria.of(read_request(request | {"limits": [limit]}), scenario).limits) == 1


def test_a_searcher_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "optuna", None)
    with pytest.raises(ConfigError, match=r"motionlab\[search\]"):
        sweep(combine="search", samples=8, objectives=[PEAK])


def test_the_command_prints_the_front_and_writes_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "cases.csv"
    words = ["sweep", "circle", "--set", "trajectory.laps=1", "--search", "nsga-ii:32"]
    words += ["--grid", f"{K_P}=1e5:1e6:log", "--grid", f"{K_D}=500:3000"]
    words += ["--objective", PEAK, "--limit", "B.x.gain_margin>=2"]
    assert main([*words, "--out", str(file)]) == 0
    out = capsys.readouterr().out
    assert "the best:" in out and "B.x.gain_margin >= 2: met by" in out
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows) == 32 and "B.x.gain_margin" in rows[0]
    assert main([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (best,) = document["front"]
    assert float(rows[best][K_P]) == document["fields"][0]["values"][best]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--sample", "halton:8"], "METHOD one of random"),
        (["--sample", "sobol"], "is no method and number"),
        (["--search", "sobol:8"], "METHOD one of cma-es"),
        (["--sample", "sobol:8", "--limit", "B.x.gain_margin=2"], "METRIC>=VALUE"),
        (["--sample", "sobol:8", "--list"], "not allowed with"),
    ],
)
def test_wrong_options_are_explained(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["sweep", "circle", "--grid", f"{K_P}=1e5:1e6", *words])
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert said in capsys.readouterr().err
