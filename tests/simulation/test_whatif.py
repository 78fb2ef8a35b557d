"""What-if runs from a stored state are what the same changes give when they are scheduled there."""

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.simulation import whatif
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD

GAIN = {"variants.B.controller.x.k_p": 312000.0, "plant.x.friction.F_s": 4.0}
LIMP = {f"variants.B.controller.{axis}.{k}": 0.0 for axis in "xy" for k in ("k_p", "k_d")}
LIMP |= {"variants.B.controller.compensation.law": "off"}


@pytest.fixture(autouse=True)
def _nothing_is_soon(monkeypatch):
    monkeypatch.setattr(whatif, "SOON", 0)


def changed_run(changes, *, base=None, exact=False, work_max=600.0):
    source = load_scenario("circle", base).model_dump(mode="json")
    changed = prepare(load_scenario(source, changes))
    extent = whatif.Extent(exact, work_max)
    return changed, whatif.run_changed(changed, source, changes, extent)


def test_a_stored_state_gives_the_bits_of_a_scheduled_change():
    changed, recording = changed_run(GAIN)
    start, stop = changed.window
    begin = start - changed.reference.period
    assert recording.first_tick == begin > 0
    assert recording.ticks == stop - begin
    event = {"time": begin * CONTROL_PERIOD, "set": GAIN}
    scheduled = run(prepare(load_scenario("circle", {"schedule": [event]})))
    for name, record in recording.variants.items():
        whole = scheduled.variants[name].samples[:, :, begin:stop]
        assert np.array_equal(record.samples, whole)
    assert np.array_equal(recording.references, scheduled.references[:, :, begin:stop])


def test_its_document_is_that_of_its_window():
    changed, recording = changed_run(GAIN)
    begin = recording.first_tick
    event = {"time": begin * CONTROL_PERIOD, "set": GAIN}
    prepared = prepare(load_scenario("circle", {"schedule": [event]}))
    expected = document(prepared, run(prepared))
    result = document(changed, recording)
    for key in ("window", "variants", "comparison"):
        assert result[key] == expected[key]


@pytest.mark.parametrize(
    ("changes", "base", "exact"),
    [
        (GAIN, None, True),
        ({"seed": 7}, None, False),
        ({"trajectory.radius": 0.01}, None, False),
        ({"variants.C": {"label": "C", "controller": "pd"}}, None, False),
        (GAIN, LIMP | {"trajectory.laps": 4}, False),
    ],
    ids=["exact", "seed", "motion", "new variant", "diverged before"],
)
def test_what_no_stored_state_can_tell_runs_from_the_start(changes, base, exact):
    changed, recording = changed_run(changes, base=base, exact=exact)
    assert (recording.first_tick, recording.ticks) == (0, changed.reference.ticks)


def test_a_variant_that_diverges_after_the_state_is_told_of():
    changed, recording = changed_run(LIMP)
    diverged = recording.variants["B"].diverged
    assert diverged is not None
    assert diverged.tick >= recording.first_tick > 0
    samples = recording.variants["B"].samples
    failed = diverged.tick - recording.first_tick
    assert np.isnan(samples[:, :, failed:]).all()
    assert np.isfinite(samples[:, :, : failed - 1]).all()
    assert document(changed, recording)["variants"]["B"]["diverged"]["time"] == diverged.time


def test_what_is_too_long_never_runs_from_the_start():
    changed, recording = changed_run(GAIN, exact=True, work_max=20.0)
    assert recording.first_tick == changed.window[0] - changed.reference.period
    with pytest.raises(ConfigError, match="too large for a what-if") as caught:
        changed_run({"seed": 7}, work_max=20.0)
    (error,) = caught.value.errors
    assert (error.value, error.range, error.unit) == (21.0, "<= 20", "s")


def test_what_is_soon_done_runs_from_the_start(monkeypatch):
    monkeypatch.undo()
    _, recording = changed_run(GAIN)
    assert recording.first_tick == 0
