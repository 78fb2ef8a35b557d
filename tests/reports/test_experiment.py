"""Reports that simulate their run: what they hold, how large it is, and which runs cannot."""

from __future__ import annotations

import base64
import gzip
import json
import math
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionlab.analysis.comparison_options import Comparing
from motionlab.config.load import load_scenario
from motionlab.lanes import model_hash, module_hash
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.reports.experiment import NUMBERS_MAX, Experiment, experiments, program
from motionlab.reports.predicted_rows import predicted_rows
from motionlab.reports.run_reports import comparison_report, run_report
from motionlab.simulation.lane_run import Known, lane_run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from tests.library.test_replay import keep
from tests.reports.test_report import DATA, Page, check_nothing_is_loaded

ADDED_MAX = 400_000
"""Bytes that a report takes more for it."""


def kept(name: str, **changes: Any) -> RunDetail:
    prepared = prepare(load_scenario(name, changes))
    recording = run(prepared)
    return library().keep(prepared, recording, document(prepared, recording))


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A page as large as the built one."""
    (tmp_path / "assets").mkdir()
    (tmp_path / "report.js").write_text(f"'{'x' * 23_000}';")
    module = gzip.compress(f'"{module_hash()}"'.encode() + np.random.default_rng(1).bytes(17_000))
    (tmp_path / "assets" / "kernel-1.wasm.gz").write_bytes(module)
    monkeypatch.setattr("motionlab.reports.experiment.page_root", lambda: tmp_path)
    return tmp_path


def experiment(run: RunDetail, room: int = NUMBERS_MAX) -> Experiment | str:
    return experiments({"": run}, room)[""]


def numbers_of(own: Experiment | str) -> tuple[dict[str, Any], np.ndarray]:
    """Return the head of a run's numbers, and the inputs from their residuals."""
    assert isinstance(own, Experiment)
    content = zlib.decompress(base64.b64decode(own.numbers))
    (length,) = struct.unpack_from("<I", content)
    head = json.loads(content[8 : 8 + length])
    place = head["arrays"]["inputs"]
    rows, ticks = place["shape"]
    start = 8 + length + 8 * place["first"]
    residuals = np.frombuffer(content, np.uint8, 8 * rows * ticks, start)
    return head, restored(head["orders"], residuals.reshape(rows, 8, ticks))


def restored(orders: list[int], planes: np.ndarray) -> np.ndarray:
    """Undo `predicted_rows`, number by number."""
    rows = np.zeros((len(orders), planes.shape[2]))
    for row, order, bytes_of in zip(rows, orders, planes, strict=True):
        weights = [(-1.0) ** (j + 1) * math.comb(order, j) for j in range(1, order + 1)]
        for k, coded in enumerate(np.ascontiguousarray(bytes_of.T).view("<u8")[:, 0].tolist()):
            prediction = 0.0
            for j, weight in enumerate(weights if k >= order else (), start=1):
                prediction += weight * float(row[k - j])
            bits = struct.unpack("<q", struct.pack("<d", prediction))[0]
            bits += (coded >> 1) ^ -(coded & 1)
            row[k] = struct.unpack("<d", struct.pack("<Q", bits & (2**64 - 1)))[0]
    return rows


@given(st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=40))
def test_rows_come_back_to_the_last_bit(values: list[float]) -> None:
    rows = np.array([values, np.sin(np.arange(len(values)) / 50.0)])
    orders, residuals = predicted_rows(rows)
    planes = residuals.view(np.uint8).reshape(2, 8, len(values))
    assert restored(orders, planes).tobytes() == rows.tobytes()


def test_its_inputs_are_those_of_the_run() -> None:
    own = experiment(keep())
    head, inputs = numbers_of(own)
    assert isinstance(own, Experiment)
    prepared = prepare(load_scenario(keep().scenario_document or {}))
    expected = lane_run(prepared, None, prepared.reference.ticks, Known()).inputs
    assert expected is not None
    assert inputs.tobytes() == expected.tobytes()
    assert head["result"]["model"] == model_hash()
    assert own.begin == 0.0
    gains = {each.path: each.value for sliders in own.sliders.values() for each in sliders}
    switches = {path for each in own.switches.values() for s in each for path in s.values}
    assert set(gains) | switches == set(head["copies"])
    assert gains["variants.B.controller.x.k_p"] == 200_300.0


@pytest.mark.parametrize("name", ["circle", "fig5"])
def test_a_report_holds_it_within_its_bound(name: str, built: Path) -> None:
    own = kept(name)
    whole = run_report(own.id)
    page = Page(whole)
    check_nothing_is_loaded(page)
    assert {"A k_p x", "B k_d y"} <= {
        value for key, value in page.attributes if key == "aria-label"
    }
    (built / "report.js").unlink()
    without = run_report(own.id)
    assert len(whole) - len(without) < ADDED_MAX
    assert not Page(without).scripts
    assert b"script-src" not in without
    scripts = sum(len(script) for script in page.scripts)
    assert 100_000 < scripts < ADDED_MAX


def test_a_comparison_holds_the_inputs_of_both_once(built: Path) -> None:
    first, second = kept("circle"), kept("circle", **{"variants.B.controller.x.k_p": 3e5})
    whole = comparison_report(first.id, second.id, Comparing(exact=True))
    page = Page(whole)
    check_nothing_is_loaded(page)
    labels = {value for name, value in page.attributes if name == "aria-label"}
    assert {"1 A k_p x", "2 B k_d y"} <= labels
    one, _, two = (len(script) for script in page.scripts if DATA.fullmatch(script))
    assert two < 10_000
    assert one > 100_000
    names = {"data-column", "data-less"}
    sources = {(name, value) for name, value in page.attributes if name in names}
    assert ("data-column", "2 B.x.following_error") in sources
    assert ("data-less", "1 B.x.following_error") in sources
    by_arc = Page(comparison_report(first.id, second.id, Comparing(exact=True, align="reference")))
    assert "The curves remain those recorded" in by_arc.whole
    assert "data-column" not in dict(by_arc.attributes)
    (built / "report.js").unlink()
    without = comparison_report(first.id, second.id, Comparing(exact=True))
    assert len(whole) - len(without) < ADDED_MAX


def test_variants_of_other_letters_are_those_compared(built: Path) -> None:
    assert built
    first, second = keep(), keep()
    how = Comparing(exact=True, variants={"A": "B", "B": "A"}, only=["B.x.following_error"])
    page = Page(comparison_report(first.id, second.id, how))
    columns = [value for name, value in page.attributes if name == "data-column"]
    assert set(columns) == {"1 B.x.following_error", "2 A.x.following_error"}


def test_a_long_run_begins_near_its_window() -> None:
    own = experiment(kept("fig5"))
    head, _ = numbers_of(own)
    assert isinstance(own, Experiment)
    window = head["windows"][0]
    assert 0 < head["first"] < window["start"] < window["end"] <= head["stop"]
    assert own.begin == head["first"] * head["period"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"kind": "live"}, "recorded live"),
        ({"state": "partial"}, "incomplete"),
        ({"model": "0" * 32}, "Another version"),
        ({"duration": 1000.0}, "more than 400 s"),
        ({"maps": {"plant.x.force_map": {}}}, "has changed"),
    ],
)
def test_a_run_that_cannot_be_simulated_says_why(
    change: dict[str, Any], reason: str, built: Path
) -> None:
    assert program() is not None, built
    own = keep().model_copy(update=change)
    sentence = experiment(own)
    assert isinstance(sentence, str)
    assert reason in sentence


def test_diverged_and_large_runs_say_so() -> None:
    diverged = kept("circle", divergence_error=1e-5)
    assert experiment(diverged) == "A variant diverged."
    assert "more than 1 kB" in str(experiment(keep(), room=1000))


def test_switches_are_those_that_change_something() -> None:
    own = experiment(keep())
    assert isinstance(own, Experiment)
    names = {
        variant: {each.name: each.on for each in all_} for variant, all_ in own.switches.items()
    }
    both = {"feedforward": False, "disturbance observer": False}
    assert names == {"A": both, "B": both | {"compensation": True}}  # the law of A adds nothing
    for switch in own.switches["B"]:
        assert [path.split()[1] for path in switch.values] == ["x", "y"]
        assert set(switch.values.values()) == {(0.0, 1.0)}
    scheduled = experiment(kept("fig5"))
    assert isinstance(scheduled, Experiment)
    assert not any(scheduled.switches.values())


def test_a_page_of_other_sources_is_not_used(built: Path) -> None:
    (built / "assets" / "kernel-1.wasm.gz").write_bytes(gzip.compress(b'"another"'))
    assert program() is None
    assert not Page(run_report(keep().id)).scripts
