"""Numbers for the kernel in the page: run by the server's kernel they give the server's result."""

from __future__ import annotations

import asyncio
import json
import struct
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import HTTPException, Response
from numpy.typing import NDArray

from motionlab.analysis.metrics import holds_within
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.layout import INPUT_ROWS, SAMPLE_ROWS, Inputs
from motionlab.kernel.tick import run_lanes
from motionlab.lanes import WIDTH, model_hash, module_hash
from motionlab.laws import LAWS, OWN
from motionlab.server.routes.whatif_lanes import WhatIfLanesRequest, _at_once, what_if_lanes
from motionlab.server.settings import Settings
from motionlab.simulation.lane_run import Known, Obstacle, lane_run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.whatif import Extent, run_changed
from motionlab.timing import to_ticks

Array = NDArray[np.float64]
K_P = {"variants.B.controller.x.k_p": 210000.0}
NOISY = {
    "trajectory.laps": 1,
    "load.noise": 0.5,
    "load.x": 2.0,
    "plant.x.encoder.noise": 5e-9,
    "plant.y.amplifiers.ripple_amplitude": 0.01,
}


def answer(client: httpx.Client, **body: Any) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return the head and the arrays."""
    response = client.post("/api/v1/whatif/lanes", json=body)
    assert response.status_code == 200, response.text
    (length,) = struct.unpack_from("<I", response.content)
    head = json.loads(response.content[8 : 8 + length])
    numbers = np.frombuffer(response.content, "<f8", offset=8 + length)
    arrays = {
        name: numbers[place["first"] :][: np.prod(place["shape"])].reshape(place["shape"])
        for name, place in head.get("arrays", {}).items()
    }
    return head, arrays


def replayed(head: dict[str, Any], arrays: dict[str, Array]) -> NDArray[np.float32]:
    """Run what the page would run, shape (variants, channels, axes, ticks)."""
    first, ticks = head["first"], head["stop"] - head["first"]
    inputs = np.zeros((ticks, INPUT_ROWS, len(AXES)))
    for (name, axis), values in zip(head["rows"], arrays["inputs"], strict=True):
        if name in Inputs._fields:
            inputs[:, Inputs._fields.index(name), AXES.index(axis)] = values
    ends = [*head["epochs"][1:], head["stop"]]
    starts = [max(tick, first) for tick in head["epochs"]]
    samples = np.empty((len(head["tabled"]), ticks, SAMPLE_ROWS, WIDTH), dtype=np.float32)
    for variant, tabled in enumerate(head["tabled"]):
        tables = arrays["tables"] if tabled else None
        state = np.tile(arrays["state"][variant], WIDTH // 2)
        for lanes, start, end in zip(arrays["lanes"], starts, ends, strict=True):
            part = slice(start - first, end - first)
            parameters = np.tile(lanes[variant], WIDTH // 2)
            laws = laws_of(parameters)
            run_lanes(parameters, state, inputs[part], samples[variant, part], tables, laws)
    return samples[..., : len(AXES)].transpose(0, 2, 3, 1)


@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("circle", {"trajectory.laps": 1, **K_P}),
        ("circle", NOISY),
        ("circle", {"trajectory.laps": 1, "plant.force_map": "new-design"}),
        ("circle-matched", {"trajectory.laps": 1, "schedule": [{"time": 2.0001, "set": K_P}]}),
        ("stair-y-500nm", {}),
        ("fig5", K_P),
    ],
)
def test_its_numbers_give_the_run(
    client: httpx.Client, scenario: str, changes: dict[str, Any]
) -> None:
    head, arrays = answer(client, scenario=scenario, set=changes)
    prepared = prepare(load_scenario(scenario, changes))
    recording = run_changed(prepared, scenario, changes, Extent(False, 600.0))
    assert (head["first"], head["stop"]) == (
        recording.first_tick,
        recording.first_tick + recording.ticks,
    )
    assert head["how"] == ("window" if recording.first_tick else "whole")
    for found, (name, record) in zip(
        replayed(head, arrays), recording.variants.items(), strict=True
    ):
        assert np.array_equal(found, record.samples), name
    rows = {tuple(row): values for row, values in zip(head["rows"], arrays["inputs"], strict=True)}
    for references, row in zip(recording.references, head["references"].values(), strict=True):
        for values, axis in zip(references, AXES, strict=True):
            assert np.array_equal(rows.get((row, axis), np.zeros(len(values))), values)
    result = document(prepared, recording)
    assert head["result"].items() <= result.items()
    assert head["result"]["model"] == model_hash()
    assert head["module"] == module_hash()
    windows = [
        {edge: to_ticks(each["window"][edge]) for edge in ("start", "end")}
        for each in (result, *result["segments"])
    ]
    listed = [head["windows"][i] for i in (0, *head["segments"])]
    assert [{edge: each[edge] for edge in ("start", "end")} for each in listed] == windows
    for window, each in zip(listed, (result, *result["segments"]), strict=True):
        span = (window["start"], window["end"])
        for name, variant in each["variants"].items():
            own = window["variants"][name]
            warnings = len(variant["notes"]) - len(own["notes"])
            assert own.items() <= (variant | {"notes": variant["notes"][warnings:]}).items()
        assert window["holds"] == {
            axis: [list(hold) for hold in holds_within(prepared.reference, AXES.index(axis), span)]
            for axis in head["moving"]
        }


def test_what_is_known_is_not_sent_again(client: httpx.Client) -> None:
    table = {"plant.force_map": "new-design"}
    head, arrays = answer(client, scenario="circle", set=table)
    assert arrays.keys() == {"lanes", "state", "inputs", "tables"}
    again, fewer = answer(client, scenario="circle", set=table | K_P, **head["keys"])
    assert (again["keys"], fewer.keys()) == (head["keys"], {"lanes", "state"})
    assert not np.array_equal(fewer["lanes"], arrays["lanes"])
    model = {f"variants.A.controller.model.{axis}.force_map": "new-design" for axis in AXES}
    for change, other in (({"load.x": 1.0}, "inputs"), (model, "tables")):
        head, arrays = answer(client, scenario="circle", set=table | change, **again["keys"])
        assert arrays.keys() == {"lanes", "state", other}
        assert head["keys"][other] != again["keys"][other]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"trajectory.laps": 40, "seed": 2}, "more than 60 s"),
        ({"plant.x.force_map": "new-design"}, "one axis"),
    ],
)
def test_what_only_the_server_can_run_says_so(
    client: httpx.Client, changes: dict[str, Any], words: str
) -> None:
    head, _ = answer(client, scenario="circle", set=changes)
    assert words in head["obstacle"]


@pytest.mark.parametrize(
    "changes",
    [
        {"variants.B.controller.x.k_p": -1.0},
        {"plant.x.mass": 0.001},
        {"trajectory.frequency": 30.0},
    ],
)
def test_refusals_are_those_of_the_what_if(client: httpx.Client, changes: dict[str, Any]) -> None:
    body = {"scenario": "circle", "set": changes}
    answers = [client.post(f"/api/v1/{path}", json=body) for path in ("whatif", "whatif/lanes")]
    assert answers[0].status_code == answers[1].status_code == 422
    assert answers[0].json()["errors"] == answers[1].json()["errors"]


def while_compiling(body: WhatIfLanesRequest) -> Response:
    """Return the answer of a server that has no kernel yet."""

    class NotReady:
        ready = False

    request = SimpleNamespace(
        app=SimpleNamespace(
            state=SimpleNamespace(settings=SimpleNamespace(bounds=Settings()), workers=NotReady())
        )
    )
    with ThreadPoolExecutor() as thread:  # this one may have a loop of the browser's driver
        answer = what_if_lanes(request, body)  # pyright: ignore[reportArgumentType]
        return thread.submit(asyncio.run, answer).result()


def test_nobody_waits_for_the_kernel_to_be_compiled() -> None:
    body = WhatIfLanesRequest(scenario="circle", set=K_P)
    assert bytes(while_compiling(body).body) == _at_once(body, Settings())


def test_a_server_without_a_kernel_runs_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(*_: Any) -> None:
        raise AssertionError("it runs")

    monkeypatch.setattr("motionlab.simulation.whatif._state", run)
    answer = while_compiling(WhatIfLanesRequest(scenario="fig5", set=K_P))
    assert b"is being compiled" in bytes(answer.body)


def test_a_server_without_a_kernel_computes_two_answers_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    body = WhatIfLanesRequest(scenario="circle", set=K_P)
    ends = threading.Event()
    begun = threading.Semaphore(0)

    def slow(*_: Any, **__: Any) -> bytes:
        begun.release()
        ends.wait()
        return b""

    monkeypatch.setattr("motionlab.server.routes.whatif_lanes._numbers", slow)
    with ThreadPoolExecutor() as threads:
        two = [threads.submit(while_compiling, body) for _ in range(2)]
        try:
            for _ in two:
                begun.acquire()
            third = threads.submit(while_compiling, body)
            begun_too = begun.acquire(timeout=0.5)
        finally:
            ends.set()
        with pytest.raises(HTTPException) as refusal:
            third.result()
    assert not begun_too
    assert refusal.value.status_code == 503
    assert refusal.value.headers == {"Retry-After": "1"}
    assert while_compiling(body).status_code == 200


def test_a_law_of_ones_own_is_the_servers_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(load_scenario("circle"))
    monkeypatch.setitem(OWN, "lugre-observer", LAWS["lugre-observer"])
    with pytest.raises(Obstacle, match="lugre-observer is of a file of one's own"):
        lane_run(prepared, None, 100, Known())
