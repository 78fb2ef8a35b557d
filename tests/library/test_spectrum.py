"""Spectra of a kept run: of which samples, beside which loop; the command."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from motionlab.analysis.spectrum import spectrum
from motionlab.cli.main import main
from motionlab.errors import BAD_INPUT, DONE, FAILED
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.simulation.result import document as result_of
from motionlab.studies.spectrum import SpectrumOptions, document, run_spectra
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import Played, play

ERROR = "B.x.following_error"
CHANGE = {"time": 6.0, "set": {"variants.B.controller.x.k_p": 150e3}}


@pytest.fixture(scope="module")
def played() -> Played:
    return play("circle", {"trajectory.laps": 2, "schedule": [CHANGE]})


@pytest.fixture(scope="module")
def run(played: Played) -> Iterator[RunDetail]:
    result = result_of(played.prepared, played.recording)
    kept = library().keep(played.prepared, played.recording, result)
    yield kept
    library().delete(kept.id)


def test_it_is_that_of_the_recorded_samples(run: RunDetail, played: Played) -> None:
    (taken,), period = run_spectra(run.id, [ERROR], 3000, 9000, SpectrumOptions(averages=4))
    samples = played.recording.variants["B"].channel("following_error", "x")[3000:9000]
    own = spectrum(samples.astype(float), period=CONTROL_PERIOD, window="hann", averages=4)
    assert period == CONTROL_PERIOD
    assert np.array_equal(taken.spectrum.density, own.density)
    assert taken.loop is not None
    speed = np.abs(played.prepared.reference.velocity[3000:9000, 0])
    assert taken.loop.velocity == pytest.approx(float(np.median(speed)), rel=1e-6)


def test_its_loop_is_the_one_in_effect(run: RunDetail) -> None:
    """A scheduled change counts from its tick on; a stretch with one inside has no one loop."""
    found = {}
    for start, stop in ((3000, 12000), (12000, None), (3000, None)):
        (taken,), _ = run_spectra(run.id, [ERROR], start, stop, SpectrumOptions())
        found[start, stop] = taken
    assert found[3000, None].loop is None
    assert "change at 6 s" in found[3000, None].note
    before, after = found[3000, 12000].loop, found[12000, None].loop
    assert before is not None
    assert after is not None
    assert after.gain[0] > 1.05 * before.gain[0]


def test_other_columns_have_no_loop(run: RunDetail) -> None:
    taken, _ = run_spectra(run.id, ["A.x.velocity", ERROR], 3000, 9000, SpectrumOptions())
    assert taken[0].loop is None
    assert taken[0].note == "only a following error has a loop"
    assert taken[1].loop is not None


def test_the_command_prints_a_table_a_document_and_every_bin(
    run: RunDetail, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    column = "A.x.following_error"
    every = tmp_path / "spectrum.csv"
    of = ["spectrum", run.id, "--column", column, "--from", "1.5", "--to", "4.5"]
    of += ["--averages", "1"]
    options = SpectrumOptions(averages=1)
    assert main([*of, "--out", str(every)]) == DONE
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["window", "hann"] in lines
    assert ["stop", "9001"] in lines
    assert any({"frequency", "amplitude", "rms"} <= set(line) for line in lines)
    assert main([*of, "--json"]) == DONE
    taken, period = run_spectra(run.id, [column], 3000, 9001, options)
    own = document(taken, options, period=period)
    assert json.loads(capsys.readouterr().out) == own.model_dump(mode="json")
    with every.open() as file:
        rows = list(csv.reader(file))
    assert rows[0][1:] == ["frequency [Hz]", "density", "amplitude", "cumulative RMS"]
    assert len(rows) == 1 + len(taken[0].spectrum.frequency)
    assert float(rows[-1][4]) == pytest.approx(taken[0].spectrum.rms, rel=1e-6)


def test_what_cannot_be_is_refused(run: RunDetail, capsys: pytest.CaptureFixture[str]) -> None:
    cases = {
        "no column of that name": ["--column", "B.x.error"],
        "--from: is not in the run": ["--column", ERROR, "--from", "100"],
        "averages: leaves segments": ["--column", ERROR, "--averages", "900"],
        "window: is not one": ["--column", ERROR, "--window", "square"],
        "too few or too many": ["--column", ERROR, "--from", "3", "--to", "2"],
    }
    for told, options in cases.items():
        assert main(["spectrum", run.id, *options]) == BAD_INPUT
        assert told in capsys.readouterr().err
    assert main(["spectrum", "r-aaaaaaaaaaaa", "--column", ERROR]) == FAILED
