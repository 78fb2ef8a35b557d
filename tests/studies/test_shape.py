"""Gains and filters on a measured response: what is proposed, what never is, and its check."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from motionlab.cli.main import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.response.margins import measured_margins
from motionlab.studies.shape.controllers import Controllers, Shape, present
from motionlab.studies.shape.documents import ShapeDocument, ShapeRequest
from motionlab.studies.shape.resonances import significant
from motionlab.studies.shape.search import Limits, Search
from motionlab.studies.shape.shaping import arrays_of, plan, shape

QUICK = {"seconds": 40.0, "lines": 200}
RESONANT = {"scenario": "circle-resonant", "axis": "x", "variant": "A"}


def shaped(**request: Any) -> ShapeDocument:
    return shape(plan(ShapeRequest.model_validate(QUICK | request)))


@pytest.fixture(scope="module")
def proposal() -> ShapeDocument:
    """PD without filters on a motor with a mode at 240 Hz."""
    return shaped(**RESONANT)


def test_a_notch_is_proposed_for_a_mode_that_stands_out(proposal: ShapeDocument) -> None:
    (mode,) = proposal.resonances
    plant = load_scenario("circle-resonant").plant.x
    assert mode.frequency == pytest.approx(plant.resonance.frequency, rel=0.08)
    assert mode.least > 3.0
    assert proposal.filters[0].kind == "notch"
    assert "resonance at" in proposal.filters[0].reason
    assert proposal.filters[0].gain > 0.5
    assert proposal.compliance < -3.0


def test_a_second_measurement_finds_the_margins_that_were_predicted(
    proposal: ShapeDocument,
) -> None:
    check = proposal.check
    assert check is not None
    assert check.holds, check.text
    for name in ("phase_margin", "gain_margin"):
        margin = check.margins[name]
        assert margin.value == pytest.approx(margin.model, rel=0.15)
    phase = check.margins["phase_margin"].value
    assert phase is not None and phase > math.radians(28.0)


def test_no_gain_goes_further_than_the_step(proposal: ShapeDocument) -> None:
    """One click of advice never goes far: betaflight's did, and the machine flew away."""
    for name, before in proposal.before.items():
        assert 0.5 * 0.999 <= proposal.after[name] / before <= 2.0 * 1.001
    small = shaped(**RESONANT, step=1.2, filters=1)
    assert len(small.filters) <= 1
    for name, before in small.before.items():
        assert 1.0 / 1.201 <= small.after[name] / before <= 1.201


def test_a_filter_that_acts_is_never_loosened_however_coherent_the_measurement_is() -> None:
    document = shaped(scenario="circle-resonant", axis="y", variant="B")
    assert np.median(document.response.plant.coherence) > 0.95
    assert not any(".notch." in path for path in document.changes)
    assert all(each.place != "notch" for each in document.filters)


def known_loop(k_p: float, k_d: float) -> tuple[Any, Any]:
    f = np.geomspace(1.0, 700.0, 400)
    s = 2j * np.pi * f
    return f, (k_p + k_d * s) * np.exp(-s * 1e-3) / (10.0 * s**2)


def test_margins_are_read_off_the_open_loop_not_the_closed_one() -> None:
    f, L = known_loop(4e5, 2e3)
    margins = measured_margins(f, L)
    w = 2.0 * np.pi * (margins["crossover"] or 0.0)
    assert abs((4e5 + 2e3j * w) / (10.0 * w**2)) == pytest.approx(1.0, rel=1e-3)
    expected = math.atan(2e3 * w / 4e5) - 1e-3 * w
    assert margins["phase_margin"] == pytest.approx(expected, abs=1e-3)
    closed = L / (1.0 + L)
    mistaken = measured_margins(f, closed)["phase_margin"]
    assert mistaken is not None and mistaken > 1.5 * expected


def search_on(scale: float = 1.0, limits: Limits | None = None) -> tuple[Search, Shape]:
    """A search on the linearised plant of `circle` itself, known to a thousandth."""
    scenario = load_scenario("circle")
    f = np.geomspace(1.0, 700.0, 200)
    controllers = Controllers(scenario, "A", "x", 0.04, f)
    before = present(controllers.config, "x")
    from motionlab.loop.linearise import linearise

    plant = scale * linearise(scenario, "A", "x", v=0.04).plant.response(f)
    deviation = 1e-3 * np.abs(plant)
    limits = limits or Limits(math.radians(30.0), 2.0, 50.0, 0)
    return Search(controllers, plant, deviation, before, limits, progress=lambda _: None), before


def test_a_loop_that_has_become_unstable_is_not_taken_for_one_with_margins() -> None:
    """Far above the stable gains phase and gain margins exist again, on the wrong side."""
    search, before = search_on()
    assert search.keeps(before)
    assert not search.keeps(Shape(1000.0 * before.k_p, 1000.0 * before.k_d, 0.0))


def test_doubt_of_the_measurement_costs_gain() -> None:
    limits = Limits(math.radians(30.0), 2.0, 50.0, 0)
    sure, before = search_on(limits=limits)
    doubtful, _ = search_on(limits=limits)
    doubtful._deviation = 0.15 * np.abs(doubtful._plant)
    best = sure.best([], []).shape
    assert sure.keeps(best)
    assert best.k_p > 2.0 * before.k_p
    assert not doubtful.keeps(best)


def test_a_mode_between_two_lines_fails_its_check_and_is_told_of() -> None:
    """At 80 lines the top of the mode is not seen; the second measurement saves the machine."""
    coarse = shaped(**RESONANT | {"seconds": 30.0, "lines": 80})
    assert coarse.check is None or coarse.check.holds or coarse.check.text != ""
    assert any("more lines" in note for note in coarse.notes) or all(
        each.resolved for each in coarse.resonances
    )


def test_scatter_is_no_resonance() -> None:
    rng = np.random.default_rng(0)
    f = np.geomspace(1.0, 700.0, 120)
    noise = 0.3
    magnitude = f**-2.0 * np.exp(noise * rng.standard_normal(len(f)))
    assert significant(f, magnitude, np.full(len(f), 1.96 * noise)) == []
    peaked = f**-2.0 * (1.0 + 5.0 / (1.0 + ((f - 150.0) / 5.0) ** 2))
    (peak,) = significant(f, peaked, np.full(len(f), 0.05))
    assert peak.frequency == pytest.approx(150.0, rel=0.05)


def kept(changes: dict[str, Any]) -> str:
    motion = {
        "trajectory": {
            "kind": "multisine",
            "axis": "x",
            "velocity": 0.0432,
            "lines": 200,
            "acceleration": 0.08,
        }
    }
    prepared = prepare(load_scenario("circle-resonant", motion | changes))
    return library().keep(prepared, run(prepared), {}, name="to shape").id


def test_a_run_is_shaped_on_and_checked_by_a_second(capsys: pytest.CaptureFixture[str]) -> None:
    first = kept({})
    on_run = {"axis": "x", "variant": "A", "run": first}
    document = shaped(**on_run)
    assert document.check is None
    assert document.changes
    other = shaped(**on_run, second_run=first).check
    assert other is not None
    assert not other.holds
    assert "not of this motor under the proposed controller" in other.text
    second = kept(document.changes)
    checked = shaped(**on_run, second_run=second).check
    assert checked is not None
    assert checked.holds, checked.text
    names = ["--axis", "x", "--variant", "A", "--lines", "200"]
    assert main(["shape", "--run", first, "--second-run", second, *names]) == 0
    text = capsys.readouterr().out
    assert "a second measurement keeps the margins" in text
    assert "--set variants.A.controller.x.k_p=" in text


@pytest.mark.parametrize(
    ("more", "word"),
    [
        ({"variants.A.controller.x.filter_3.poles_frequency": 600.0}, "filter_3"),
        ({"plant.x.mass": 8.0}, "plant.x.mass"),
        ({"trajectory.high": 40.0}, "no gain margin up was measured"),
    ],
)
def test_a_second_run_of_something_else_confirms_nothing(more: dict[str, Any], word: str) -> None:
    on_run = {"axis": "x", "variant": "A", "run": kept({})}
    changes = shaped(**on_run).changes
    checked = shaped(**on_run, second_run=kept(changes | more)).check
    assert checked is not None
    assert not checked.holds
    assert word in checked.text


def test_a_margin_beyond_the_highest_frequency_is_not_taken_for_kept() -> None:
    """The mode at 240 Hz lies beyond: a loop that seems stiff enough would oscillate at it."""
    document = shaped(**RESONANT | {"high": 120.0, "step": 2.08})
    assert document.changes == {}
    (note,) = (each for each in document.notes if "gain margin up" in each)
    assert re.search(r"is not known: up to 1[012]\d(\.\d)? Hz.*shake more above", note)


def test_a_second_run_that_has_nothing_to_check_is_noted() -> None:
    low = kept({"trajectory.high": 120.0})
    document = shaped(axis="x", variant="A", run=low, high=120.0, second_run=low)
    assert (document.changes, document.check) == ({}, None)
    assert any("the second run was not read" in note for note in document.notes)


def test_what_cannot_be_shaped_is_refused() -> None:
    with pytest.raises(ConfigError, match="second_run"):
        shaped(scenario="circle", second_run="r-aaaaaaaaaaaa")
    with pytest.raises(ConfigError, match="its factor is searched"):
        shaped(scenario="circle", variant="A", set={"variants.A.controller.x.k_d": 0.0})


def test_the_plant_of_a_document_is_the_measured_one(proposal: ShapeDocument) -> None:
    f, plant, deviation = arrays_of(proposal.response)
    L = np.array(proposal.response.open.magnitude)
    assert len(f) == len(plant) == len(deviation) == len(L)
    assert (deviation > 0.0).all()
