"""The part of a run that a study reads."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from motionlab.errors import ConfigError
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.studies.friction.documents import FrictionModelsRequest
from motionlab.studies.friction.record import plan as plan_friction
from motionlab.studies.friction.select import select
from motionlab.studies.minute.documents import MinuteRequest
from motionlab.studies.record.options import add_columns, add_part
from motionlab.studies.record.part import Part, PartOptions, kept_run, part_of, without_gaps
from motionlab.studies.response.documents import ResponseRequest
from motionlab.studies.response.measure import measure, plan
from tests.studies.friction.one_axis_machine import Machine, recorded, sines
from tests.studies.identify.measured_runs import imported
from tests.studies.test_response import rig

SECONDS = 4.0


@pytest.fixture(scope="module", autouse=True)
def _data(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        yield


@pytest.fixture(scope="module")
def run(_data: None, tmp_path_factory: pytest.TempPathFactory) -> RunDetail:
    t = np.arange(round(SECONDS * 1000)) / 1000
    channels = {"time [s]": t, "x_ist [mm]": np.sin(t)}
    return kept_run(imported(tmp_path_factory.mktemp("rig"), channels))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"start": 4.0}, "record.start: lies after the end of the run; got 4.0; allowed < 4 s"),
        ({"start": 2.0, "end": 1.0}, "record.end: is before the start; got 1.0; allowed > 2 s"),
        ({"end": 0.5}, "record.end: leaves too short a part; got 0.5; allowed >= 1 s"),
        ({"start": 3.5}, "record.start: leaves too short a part; got 0.5; allowed >= 1 s"),
        ({}, "run: is longer than this study reads: choose a part by start and end; got 4.0; "),
    ],
)
def test_a_part_out_of_limits_names_the_field_that_makes_it_so(
    run: RunDetail, options: dict[str, float], text: str
) -> None:
    with pytest.raises(ConfigError) as error:
        part_of(PartOptions(**options), run, loc="record.", seconds_min=1.0, samples_max=3000)
    assert str(error.value).startswith(text)


def test_the_longest_stretch_without_a_gap_is_read(run: RunDetail) -> None:
    part = part_of(PartOptions(start=1.0), run)
    samples = np.ones((2, part.samples))
    assert without_gaps(part, samples) == (part, [])
    samples[0, 500] = samples[1, 600] = np.nan
    stretch, (note,) = without_gaps(part, samples)
    assert stretch == Part(run, 1601, 4000)
    assert note == (
        "the run lacks 2 samples from 1.5 s to 1.601 s: its longest stretch without a gap is "
        "read, 1.601 s to 4 s"
    )
    with pytest.raises(ConfigError, match=r"lacks 2 samples .* got 2\.399; allowed >= 2\.5 s"):
        without_gaps(part, samples, 2.5)


def test_every_study_has_the_same_names() -> None:
    parser = argparse.ArgumentParser()
    add_part(parser)
    add_columns(parser, position="p_c", force="force_column", normal_force="n_c")
    text = "--from 1 --to 2 --position-column p --force-column f --normal-force-column n"
    options = vars(parser.parse_args(text.split()))
    assert options == {
        **{"start": 1.0, "end": 2.0},
        **{"p_c": "p", "force_column": "f", "n_c": "n"},
    }
    for model in (FrictionModelsRequest, MinuteRequest, ResponseRequest):
        assert issubclass(model, PartOptions)


def test_a_gap_does_not_refuse_a_response(tmp_path: Path) -> None:
    rig(tmp_path / "whole.csv")
    lines = (tmp_path / "whole.csv").read_text().splitlines()
    (tmp_path / "gap.csv").write_text("\n".join([*lines[:3000], *lines[3050:]]))
    options = ImportOptions()
    _, kept = import_file(tmp_path / "gap.csv", options, library=library(), name="gap")
    assert kept is not None
    request = {"run": kept.id, "axis": "x", "lines": 40}
    document = measure(plan(ResponseRequest.model_validate(request)))
    assert "lacks 50 samples" in document.warnings[0]
    assert len(document.frequency) > 15


def test_a_signed_normal_force_is_doubted_and_its_magnitude_is_not(tmp_path: Path) -> None:
    record = recorded(Machine("lugre-load", mu=0.03), sines([(0.03, 0.3, 2), (0.003, 0.4, 4)]))
    record["preload [N]"] *= np.where(np.arange(len(record["preload [N]"])) % 4000 < 2000, 1, -1)
    own = {"position_column": "slide", "force_column": "push", "normal_force_column": "preload"}
    kept = imported(tmp_path, record, "slide=", "push=", "preload=")
    request = FrictionModelsRequest.model_validate({"run": kept, **own})
    assert any("preload is negative in" in note for note in select(plan_friction(request)).notes)
    sized = request.model_copy(update={"normal_force_magnitude": True})
    document = select(plan_friction(sized))
    assert document.notes == []
    (loaded,) = (model for model in document.models if model.name == "lugre-load")
    assert loaded.parameters["mu"].value == pytest.approx(0.03, rel=0.1)
