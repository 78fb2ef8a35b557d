"""Curves of a what-if: over its window, over the whole, over a few ticks of it."""

from __future__ import annotations

import json
import struct
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.server.routes import whatif
from motionlab.server.routes.whatif import WhatIfRequest
from motionlab.server.settings import Settings
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.simulation.whatif import run_changed
from motionlab.timing import CONTROL_PERIOD

ERROR = "B.x.following_error"
CIRCLE = {"scenario": "circle", "columns": [ERROR]}
FIG5 = {"scenario": "fig5", "columns": [ERROR], "set": {"variants.B.controller.x.k_p": 210000.0}}


def asked(client: httpx.Client, **body: Any) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """Return head, minima and maxima."""
    answer = client.post("/api/v1/whatif", json=body)
    assert answer.status_code == 200, answer.text
    (length,) = struct.unpack_from("<I", answer.content)
    head = json.loads(answer.content[8 : 8 + length])
    values = np.frombuffer(answer.content, "<f4", offset=8 + length)
    return head, values.reshape(2, head["time"]["count"])


@pytest.fixture(scope="module")
def error() -> NDArray[np.float32]:
    recording = run(prepare(load_scenario("circle")))
    return recording.variants["B"].channel("following_error", "x").astype(np.float32)


def test_curves_are_of_the_window_unless_a_stretch_is_named(
    client: httpx.Client, error: NDArray[np.float32]
) -> None:
    head, _ = asked(client, **CIRCLE)
    assert head["time"]["start"] == head["result"]["window"]["start"] > 0
    assert head["duration"] == pytest.approx(error.size * CONTROL_PERIOD)
    assert head["period"] == CONTROL_PERIOD
    head, values = asked(client, **CIRCLE, start=0.0, end=1e6, points=20000)
    size = round(head["time"]["step"] / CONTROL_PERIOD)
    assert head["time"]["start"] == 0.0
    assert head["time"]["count"] == -(-error.size // size)
    # No spike is lost, however coarse.
    assert values.min() == error.min()
    assert values.max() == error.max()


def test_a_few_ticks_are_those_of_the_whole(
    client: httpx.Client, error: NDArray[np.float32]
) -> None:
    head, values = asked(client, **CIRCLE, start=5.0, end=5.004)
    assert head["time"] == {"start": 5.0, "step": CONTROL_PERIOD, "count": 8}
    assert np.array_equal(values, np.tile(error[10000:10008], (2, 1)))


def test_the_least_end_that_a_refusal_names_is_taken(client: httpx.Client) -> None:
    body = {**CIRCLE, "start": 5.0, "end": 5.0}
    answer = client.post("/api/v1/whatif", json=body)
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    head, _ = asked(client, **{**body, "end": error["bounds"]["minimum"]})
    assert (error["loc"], head["time"]["count"]) == ("end", 1)


def test_a_long_run_is_read_from_where_it_was_simulated(client: httpx.Client) -> None:
    head, _ = asked(client, **FIG5)
    assert (head["how"], head["time"]["start"]) == ("window", 174.0)
    head, _ = asked(client, **FIG5, start=100.0, end=101.0)
    assert (head["how"], head["time"]["start"], head["time"]["count"]) == ("window", 100.0, 1000)
    head, exact = asked(client, **FIG5, start=89.0, end=91.0, exact=True)
    assert (head["how"], head["time"]["count"]) == ("whole", 1334)
    assert np.abs(exact).max() > 1e-5


class Alone:
    """A call without a server: whatever it holds is there."""

    def hold(self, size: int) -> None:
        assert size >= 0


def test_a_closer_look_needs_no_other_run(monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[Any] = []

    def counted(*arguments: Any) -> Any:
        runs.append(arguments)
        return run_changed(*arguments)

    monkeypatch.setattr(whatif, "run_changed", counted)

    def looked(**body: Any) -> bytes:
        request = WhatIfRequest(exact=True, **(CIRCLE | body))
        return whatif._answer(Alone(), request, Settings())  # pyright: ignore[reportArgumentType]

    stretches = [{"start": 2.0, "end": 2.5}, {"start": 0.0, "end": 10.0, "points": 100}]
    found = [looked(**stretch) for stretch in stretches]
    assert len(runs) == 1
    monkeypatch.setattr(whatif, "_LAST", whatif._Last())
    assert [looked(**stretch) for stretch in reversed(stretches)] == found[::-1]
    assert len(runs) == 2
    # Another column, another value: another run.
    assert looked(columns=["A.x.following_error"]) != found[0]
    changed = looked(set={"variants.B.controller.x.k_p": 300000.0}, start=2.0, end=2.5)
    assert changed != found[0]
    assert len(runs) == 4
    assert looked(set={"variants.B.controller.x.k_p": 300000.0}, start=2.0, end=2.5) == changed
    assert len(runs) == 4


@pytest.mark.parametrize(
    ("stretch", "place"),
    [
        ({"start": 3.0, "end": 2.0}, "end"),
        ({"start": -1.0}, "start"),
        ({"end": "1"}, "end"),
        ({"end": 1e7}, "end"),
    ],
)
def test_a_stretch_that_is_none_is_refused(
    client: httpx.Client, stretch: dict[str, object], place: str
) -> None:
    answer = client.post("/api/v1/whatif", json=CIRCLE | stretch)
    assert answer.status_code == 422
    assert [error["loc"] for error in answer.json()["errors"]] == [place]
