"""Runs simulated again: the same bits, or where the first other one is and why."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from motionlab.config.load import epochs, load_scenario
from motionlab.errors import NotReplayable
from motionlab.library import replay as module
from motionlab.library.library import library
from motionlab.library.replay import Replay, again, replay
from motionlab.library.run import Event, RunDetail
from motionlab.simulation.change import changed
from motionlab.simulation.prepare import prepare
from motionlab.simulation.record import record
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.simulation.simulation import Simulation, ready, sample_page
from motionlab.telemetry.recorder import parquet_writer, write
from motionlab.telemetry.recording import as_recording
from tests.server.live import API, Live, until
from tests.simulated import SHORT

MASS = "plant.x.mass"
_SEEN: set[str] = set()
_BEGUN: list[float] = []


@pytest.fixture(autouse=True)
def begun() -> None:
    """Note when a test begins: the server is shared."""
    _BEGUN.append(time.time())


def keep(changes: dict[str, Any] | None = None) -> RunDetail:
    prepared = prepare(load_scenario("circle", SHORT | (changes or {})))
    recording = run(prepared)
    return library().keep(prepared, recording, document(prepared, recording))


def replayed(kept: RunDetail) -> Replay:
    with library().files.open(kept.id) as file:
        return replay(again(kept), file)


def ended(live: Live) -> RunDetail:
    """End a session, if it has not stopped, and return its run."""
    live.delete()
    found: list[str] = []

    def kept() -> bool:
        page = live.client.get(f"{API}/runs", params={"q": "kind:live"}).json()["runs"]
        own = [run for run in page if run["created"] >= _BEGUN[-1]]  # not of other tests
        new = [run for run in own if run["id"] not in _SEEN and run["state"] != "recording"]
        found.extend(run["id"] for run in new)
        return bool(found)

    until(kept)
    _SEEN.update(found)
    return library().get(found[0])


def rewrite(kept: RunDetail, change: Any) -> None:
    """Alter the telemetry of a run."""
    path = library().files.path(kept.id)
    table = change(parquet.read_table(path))
    with parquet_writer(path, table.schema) as writer:  # pyright: ignore[reportArgumentType]
        writer.write_table(table, row_group_size=700)


def altered(table: pa.Table, tick: int, column: str, value: float) -> pa.Table:
    values = table[column].to_numpy().copy()
    values[tick] = value
    index = table.schema.get_field_index(column)
    return table.set_column(index, table.schema.field(column), pa.array(values, from_pandas=True))


# -- simulations ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"schedule": [{"time": 0.6, "set": {"variants.B.controller.compensation.enabled": False}}]},
        {"load.noise": 2.0, "load.steps": [{"time": 0.7, "x": 20.0, "y": 5.0}], "seed": 7},
        {"variants.A.controller.x.k_d": 0.0, "variants.A.controller.x.k_p": 9e6},
    ],
    ids=["plain", "schedule", "load", "diverges"],
)
def test_a_simulation_is_identical(changes: dict[str, Any]) -> None:
    kept = keep(changes)
    found = replayed(kept)
    assert all(each.max_change in {0.0, None} for each in found.errors)
    assert found.model_copy(update={"errors": []}) == Replay(
        identical=True,
        channels=108,
        ticks=kept.ticks,
        missing=0,
        first=None,
        samples=0,
        differing=[],
        errors=[],
        reasons=[],
    )


def test_an_altered_sample_is_found() -> None:
    kept = keep()
    rewrite(kept, lambda table: altered(table, 2500, "B.y.velocity", 1.5))
    found = replayed(kept)
    assert not found.identical
    assert found.first is not None
    assert (found.first.tick, found.first.time) == (2500, 1.25)
    assert (found.first.channel, found.first.unit) == ("B.y.velocity", "m/s")
    assert found.first.recorded == 1.5
    assert isinstance(found.first.simulated, float)
    assert found.first.difference == found.first.simulated - 1.5
    assert (found.samples, found.differing) == (1, ["B.y.velocity"])
    assert found.reasons == ["none is known: version, model, processor and maps are the same"]


def test_the_smallest_bit_counts() -> None:
    kept = keep()
    before = parquet.read_table(library().files.path(kept.id))["A.x.thrust"][800].as_py()
    next_one = np.nextafter(np.float32(before), np.float32(np.inf))
    rewrite(kept, lambda table: altered(table, 800, "A.x.thrust", next_one))
    found = replayed(kept)
    assert found.first is not None
    assert (found.first.tick, found.samples) == (800, 1)


def test_a_record_cut_short_is_not_identical() -> None:
    kept = keep()
    rewrite(kept, lambda table: table.slice(0, kept.ticks - 10))
    found = replayed(kept)
    assert (found.identical, found.missing, found.first) == (False, 10, None)
    assert found.reasons == ["the record does not hold every tick and every channel"]


def test_what_is_known_of_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = keep().model_copy(update={"version": "0.0.1", "model": "other"})
    rewrite(kept, lambda table: altered(table, 5, "A.x.thrust", 1.0))
    reasons = replayed(kept).reasons
    assert len(reasons) == 2
    assert reasons[0].startswith("other version: kept with 0.0.1")
    assert reasons[1].startswith("other model's sources: kept with other")
    monkeypatch.setattr(module, "processor", lambda: "z80")
    assert any("z80" in reason for reason in replayed(kept).reasons)


def test_what_cannot_be_simulated_again() -> None:
    kept = keep()
    with pytest.raises(NotReplayable, match="no scenario"):
        again(kept.model_copy(update={"scenario_document": None}))
    with pytest.raises(NotReplayable, match=r"no\.such"):
        again(kept.model_copy(update={"scenario_document": {"no.such": 1}}))


# -- live sessions --------------------------------------------------------------------------------


def test_a_run_kept_beside_laws_that_are_not_here() -> None:
    kept = keep()
    assert kept.scenario_document is not None
    compensation = kept.scenario_document["variants"]["B"]["controller"]["compensation"]
    compensation["root_gain"] = 10.0  # of a law that it does not use
    assert replayed(kept).identical
    compensation["law"] = "mine"
    with pytest.raises(NotReplayable, match="has the law mine, whose file is not here: --laws"):
        again(kept)


def test_a_session_with_all_that_can_happen(client: httpx.Client) -> None:
    schedule = [
        {"time": 0.4, "set": {"plant.y.mass": 9.0}},
        {"time": 0.9, "set": {"load.x": 15.0}},
    ]
    live = Live.create(client, "circle", {"schedule": schedule, "load.noise": 1.0})
    live.step(700)
    live.change({MASS: 7.0, "variants.B.controller.x.k_p": 250_000.0})
    live.do("push", axis="x", force=60.0, duration=0.05)
    live.step(50)
    live.do("push", axis="y", force=-40.0, duration=0.1)
    live.change({"load.y": 12.5})
    live.step(3500)
    live.do("undo")
    live.step(20_000)  # beyond the end of the trajectory
    live.do("stop")
    until(lambda: live.info()["state"] == "stopped")
    kept = ended(live)
    assert [event.kind for event in kept.events] == [
        "change", "push", "push", "change", "change", "stop"
    ]  # fmt: skip
    found = replayed(kept)
    assert found.identical, found
    assert (found.channels, found.ticks) == (108, kept.ticks)
    for event in kept.events:  # each of them counts
        others = [other for other in kept.events if other is not event]
        without = replayed(kept.model_copy(update={"events": others}))
        assert without.first is not None, event
        assert event.tick <= without.first.tick <= event.tick + 4, event


def test_a_scheduled_change_between_the_check_of_a_change_and_its_tick(tmp_path: Path) -> None:
    """It comes on top of the change, which was checked before it."""
    schedule = [{"time": 0.2, "set": {MASS: 9.0}}]
    prepared = prepare(load_scenario("circle", SHORT | {"schedule": schedule}))
    simulation, page = Simulation(prepared, endless=True), sample_page(2)
    columns = np.empty((108, 1000), dtype=np.float32)

    def go(tick: int) -> None:
        while simulation.tick < tick:
            record(simulation, page, columns[:, simulation.tick : tick])

    go(300)
    after, change = changed(simulation.scenario, {MASS: 7.0}, 300)
    made = ready(tuple(epochs(after, 300)))
    go(420)
    simulation.adopt(made)
    assert simulation.scenario.plant.x.mass == 9.0
    go(1000)
    file = tmp_path / "live.parquet"
    write(as_recording(0, columns, {"A": None, "B": None}), str(file), metadata={})
    event = Event(tick=420, checked=300, kind="change", set=change.set)
    facts = {"kind": "live", "events": [event], "ticks": 1000}
    scenario = prepared.scenario.model_dump(mode="json")
    kept = keep().model_copy(update=facts | {"scenario_document": scenario})
    with parquet.ParquetFile(file) as telemetry:
        assert replay(again(kept), telemetry).identical


def test_a_session_changed_while_it_plays(client: httpx.Client) -> None:
    """A scheduled change may come between the check of a change and its tick."""
    schedule = [{"time": 0.02 * k, "set": {"plant.x.mass": 5.0 + 0.01 * k}} for k in range(3, 45)]
    live = Live.create(client, "circle", {"schedule": schedule})
    live.do("play", speed=1.0)
    for k in range(12):
        live.change({"variants.A.controller.x.k_p": 200_000.0 + k, "plant.y.mass": 6.0 + 0.1 * k})
    until(lambda: live.tick > 2200)
    kept = ended(live)
    assert len(kept.events) == 12
    assert all(event.checked is not None for event in kept.events)
    found = replayed(kept)
    assert found.identical, found


def test_a_session_after_a_reset_that_no_check_would_pass(client: httpx.Client) -> None:
    live = Live.create(client)
    live.change(
        {"variants.A.controller.force_limit": 5.0, "load.steps": [{"time": 15.0, "x": 9.0}]}
    )
    live.do("reset")
    live.step(31_000)  # the step lies beyond the end of the trajectory
    kept = ended(live)
    assert replayed(kept).identical
    other = kept.scenario_document or {}
    other["load"]["steps"] = []
    found = replayed(kept.model_copy(update={"scenario_document": other}))
    assert found.first is not None
    assert found.first.tick == 30_000


def test_ticks_that_were_not_recorded_are_simulated(client: httpx.Client) -> None:
    live = Live.create(client)
    live.step(1500)
    live.change({MASS: 7.0})
    live.step(3000)
    kept = ended(live)

    def without(table: pa.Table) -> pa.Table:
        return pa.concat_tables([table.slice(0, 1200), table.slice(2600)])

    rewrite(kept, without)
    found = replayed(kept)
    assert (found.identical, found.ticks, found.missing) == (True, 3100, 1400)
    rewrite(kept, lambda table: altered(table, 1201, "x.load_force", 3.0))
    found = replayed(kept)
    assert found.first is not None
    assert found.first.tick == 2601
