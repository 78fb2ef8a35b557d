"""Reversals of a kept run: the numbers of its recording, on the command line and as a document."""

from __future__ import annotations

import json
from collections.abc import Iterator

import numpy as np
import pytest

from motionlab.analysis.glitches import glitches
from motionlab.cli.main import main
from motionlab.errors import DONE, FAILED
from motionlab.library.library import library
from motionlab.library.recorded import run_glitches
from motionlab.library.run import RunDetail
from motionlab.simulation.result import document
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import Played, play

TWO_LAPS = {"trajectory.laps": 2}


@pytest.fixture(scope="module")
def played() -> Played:
    return play("circle", TWO_LAPS)


@pytest.fixture(scope="module")
def run(played: Played) -> Iterator[RunDetail]:
    result = document(played.prepared, played.recording)
    kept = library().keep(played.prepared, played.recording, result)
    yield kept
    library().delete(kept.id)


def test_they_are_those_of_the_recording(run: RunDetail, played: Played) -> None:
    found = run_glitches(run.id)
    assert list(found.axes) == ["x", "y"]
    for index, (axis, each) in enumerate(found.axes.items()):
        assert each.count == 50e-9
        assert list(each.variants) == ["A", "B"]
        for name, variant in each.variants.items():
            error = played.recording.variants[name].channel("following_error", axis)
            own = glitches(
                played.prepared.reference.velocity[:, index],
                error.astype(float),
                count=each.count,
                period=CONTROL_PERIOD,
            )
            assert len(own) == 4
            assert [row.time for row in variant.rows] == [g.tick * CONTROL_PERIOD for g in own]
            assert [row.height for row in variant.rows] == [g.height for g in own]
            assert variant.mean.height == pytest.approx(np.mean([abs(g.height) for g in own]))


def test_the_aligned_errors_begin_at_nothing_and_reach_the_height(run: RunDetail) -> None:
    for axis in run_glitches(run.id).axes.values():
        for variant in axis.variants.values():
            aligned = variant.aligned
            before = round(-aligned.start / aligned.step)
            assert abs(np.mean(aligned.mean[:before])) < 1e-9
            assert max(aligned.mean) == pytest.approx(variant.mean.height, rel=0.1)
            assert np.all(np.array(aligned.low) <= aligned.mean)
            assert np.all(np.array(aligned.high) >= aligned.mean)


def test_a_motion_one_way_has_none() -> None:
    played = play("stair-y-50mm", {})
    kept = library().keep(
        played.prepared, played.recording, document(played.prepared, played.recording)
    )
    assert "x" not in run_glitches(kept.id).axes
    library().delete(kept.id)


def test_the_command_prints_a_table_and_a_document(
    run: RunDetail, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["glitches", run.id]) == DONE
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    heads = lines.index(["rows", "time", "direction", "height", "delay", "rise", "duration"])
    assert lines[heads + 1] == ["s", "um", "ms", "ms", "ms"]
    assert [line[:5] for line in lines[heads + 2 : heads + 4]] == [
        ["x", "A", "2.251", "1", "36.52"],
        ["x", "A", "3.751", "-1", "-36.51"],
    ]
    assert ["height", "um", "36.52"] in [line[:3] for line in lines[:heads]]
    assert main(["glitches", run.id, "--json"]) == DONE
    assert json.loads(capsys.readouterr().out) == run_glitches(run.id).model_dump(mode="json")
    assert main(["glitches", "r-aaaaaaaaaaaa"]) == FAILED
    assert "no run 'r-aaaaaaaaaaaa'" in capsys.readouterr().err
