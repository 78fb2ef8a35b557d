"""Stability margins among the metrics of runs."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.library import index as indexes
from motionlab.library.database import index_url
from motionlab.library.library import Library
from motionlab.library.new_run import live_run, new_run
from motionlab.library.run import Event, new_id
from motionlab.library.search import parse
from motionlab.library.spool import Spool
from motionlab.library.stability_margins import margins_of, stability_margins
from motionlab.loop.document import loop_document
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document, metadata
from motionlab.simulation.run import run as simulate
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import stream_columns
from tests.library.sample_runs import made_by

SHORT = {"trajectory.laps": 1, "trajectory.for_ever": False}
GAIN = "variants.B.controller.x.k_p"
STIFFER = 4e5  # N/m


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario("circle", SHORT)


@pytest.fixture
def library(tmp_path: Path):
    library = Library(tmp_path)
    yield library
    library.close()


def test_they_are_the_worst_of_the_loop_document(scenario: Scenario) -> None:
    margins = stability_margins(scenario)
    assert len(margins) == 8
    for variant, of_variant in loop_document(scenario).variants.items():
        for axis, loop in of_variant.axes.items():
            for name in ("gain_margin", "phase_margin"):
                wanted = getattr(loop.worst, name).value
                assert margins[f"{variant}.{axis}.{name}"] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "without"),
    [
        ({"variants.A.controller.compensation.law": "published-k"}, {"A.x", "A.y"}),
        ({GAIN: 0.0, "variants.B.controller.x.k_d": 0.0}, {"B.x"}),
        ({GAIN: 1e9}, {"B.x"}),
    ],
)
def test_a_loop_without_margins_has_none(changes: dict[str, object], without: set[str]) -> None:
    margins = stability_margins(load_scenario("circle", changes))
    assert {name[:3] for name in margins} == {"A.x", "A.y", "B.x", "B.y"} - without
    assert all(math.isfinite(value) for value in margins.values())


def test_a_kept_simulation_has_them_as_they_are_at_its_end(library: Library) -> None:
    later = [{"time": 0.1, "set": {GAIN: STIFFER}}]
    prepared = prepare(load_scenario("circle", {**SHORT, "schedule": later}))
    recording = simulate(prepared)
    kept = library.keep(prepared, recording, document(prepared, recording))
    stiffer = stability_margins(load_scenario("circle", {**SHORT, GAIN: STIFFER}))
    assert stiffer.items() <= kept.metrics.items()
    (listed,) = library.index.page(parse("B.x.gain_margin>1dB"), sort="B.x.phase_margin").runs
    assert listed.metrics == kept.metrics
    assert library.index.histogram(parse(""), "B.x.gain_margin").total == 1


def test_a_live_run_has_them_with_the_last_change(library: Library, scenario: Scenario) -> None:
    recording = simulate(prepare(scenario))
    run = live_run(scenario, new_id(), time.time())
    channels = stream_columns(list(scenario.variants))
    spool = Spool(library.spools, run, channels, metadata(scenario))
    spool.append(0, np.stack([values[:400] for _, _, values in recorder.columns(recording)]))
    spool.note(Event(tick=100, kind="change", set={GAIN: STIFFER}))
    spool.end(complete=True)
    library.index.put(run)
    kept = library.finish(run.id)
    assert kept is not None
    stiffer = stability_margins(load_scenario("circle", {**SHORT, GAIN: STIFFER}))
    assert stiffer.items() <= kept.metrics.items()


def test_drives_and_measurements_have_none(scenario: Scenario) -> None:
    run = new_run("simulation", scenario, {}).model_copy(update={"ticks": 10})
    assert len(margins_of(run)) == 8
    assert margins_of(run.model_copy(update={"kind": "drive"})) == {}
    assert margins_of(run.model_copy(update={"kind": "measurement"})) == {}
    assert margins_of(run.model_copy(update={"scenario_document": None})) == {}


def test_runs_of_an_earlier_index_get_them(
    tmp_path: Path, scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = [
        new_run(kind, scenario, {}).model_copy(
            update={"ticks": 10, "metrics": {"B.x.max_abs_following_error": 1e-6}}
        )
        for kind in ("simulation", "live", "drive", "simulation")
    ]
    made_by(index_url(tmp_path), "0007", *old)
    monkeypatch.setattr(indexes, "_MARGINS_AT_ONCE", 2)
    library = Library(tmp_path)
    assert library.index.page(parse("B.x.gain_margin>0")).total == 0
    assert library.index.margins_due() == [old[3].id, old[1].id]
    assert library.add_margins()
    assert library.index.page(parse("B.x.gain_margin>0")).total == 2
    library.index.drop(old[0].id)
    assert not library.add_margins()
    kept = library.get(old[3].id)
    assert kept.metrics == old[3].metrics | stability_margins(scenario)
    assert library.get(old[2].id) == old[2]
    library.close()
