"""``motionlab view``: what is asked of a test cycle, and what is not of a view."""

from __future__ import annotations

import json

import pytest

from motionlab.analysis.views.positioning import PositioningCycle, measured_scenario, positioning
from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.recorded import of_recording
from motionlab.simulation.run import run

CYCLE = {"axis": "y", "targets": 3, "runs": 2, "dwell": 0.3, "low": -0.01, "high": 0.02}


def test_a_test_cycle_is_the_one_that_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    options = [text for name, value in CYCLE.items() for text in (f"--{name}", f"{value}")]
    words = ["view", "positioning", "circle-matched", *options, "--instrument", "encoder"]
    assert main([*words, "--set", "variants.A.controller.x.k_p=150000.0", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    asked = PositioningCycle.model_validate(CYCLE | {"instrument": "encoder"})
    changes = {"variants.A.controller.x.k_p": 150_000.0}
    prepared = prepare(measured_scenario(load_scenario("circle-matched", changes), asked))
    recorded = of_recording(run(prepared), prepared, 0, prepared.reference.ticks)
    assert found == positioning(recorded, asked).model_dump(mode="json")
    targets = found["variants"]["B"]["targets"]
    assert [targets[0]["place"], targets[-1]["place"]] == [-0.01, 0.02]
    assert len(targets) == 3
    assert all(len(target["up"]) == len(target["down"]) == 2 for target in targets)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ballbar", "circle", "--targets", "3"], "--targets: is of the view positioning"),
        (["positioning", "circle", "--from", "1"], "--from: is of a run"),
        (["positioning", "circle", "--targets", "1"], "targets"),
        (["positioning", "circle", "--targets", "50", "--runs", "50"], "too many samples"),
        (["positioning", "circle", "--low", "0.02", "--high", "0.01"], "high"),
        (["roundness", "circle"], "no such VIEW; got 'roundness'"),
    ],
)
def test_what_is_not_of_a_view_is_refused(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["view", *words])
    except SystemExit as end:
        code = end.code  # of argparse
    assert code == 2
    assert said in capsys.readouterr().err
