"""Math channels over REST: checked, in what-ifs, windows, spectra, files of runs and sessions."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray

from motionlab.library.library import library
from motionlab.library.run import RunDetail
from tests.server.live import API
from tests.server.openapi import Contract
from tests.server.servers import PATIENCE, Server
from tests.simulated import SHORT, play

POWER = "power=B.x.thrust * B.x.velocity"
SLOW = "=lowpass(derivative(hypot(B.x.position, B.y.position)), 30)"


@pytest.fixture(scope="module")
def client(contract: Contract) -> Iterator[httpx.Client]:
    """Return a client of a server that begins now: on the folder of data that `run` is kept in."""
    server = Server()
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    try:
        with httpx.Client(base_url=server.url, event_hooks=hooks, timeout=PATIENCE) as client:
            yield client
    finally:
        server.stop()


@pytest.fixture(scope="module")
def run() -> Iterator[RunDetail]:
    """Return a kept run."""
    from motionlab.simulation.result import document

    played = play("circle", SHORT)
    result = document(played.prepared, played.recording)
    kept = library().keep(played.prepared, played.recording, result)
    yield kept
    library().delete(kept.id)


def channel(run: RunDetail, name: str) -> NDArray[np.float32]:
    with library().files.open(run.id) as file:
        return file.read([name])[name].to_numpy().astype(np.float32)


def power(run: RunDetail) -> NDArray[np.float32]:
    force, velocity = (channel(run, name).astype(float) for name in POWER[6:].split(" * "))
    return (force * velocity).astype(np.float32)


def curves(answer: httpx.Response) -> tuple[dict[str, Any], NDArray[np.float32]]:
    """Return head, and minima and maxima of each column."""
    assert answer.status_code == 200, answer.text
    (length,) = struct.unpack_from("<I", answer.content)
    head = json.loads(answer.content[8 : 8 + length])
    values = np.frombuffer(answer.content, "<f4", offset=8 + length)
    return head, values.reshape(len(head["columns"]), 2, head["time"]["count"])


def test_checks_tell_unit_and_steps_or_what_is_wrong(client: httpx.Client, run: RunDetail) -> None:
    columns = [POWER, "=B.x.thrust + B.x.velocity", "=" + "9" * 900]
    for whose in ({"variants": ["A", "B"]}, {"run": run.id}):
        answer = client.post(f"{API}/expressions/check", json={"columns": columns} | whose)
        good, wrong, long = answer.raise_for_status().json()
        assert (good["name"], good["unit"], good["problem"]) == ("power", "W", None)
        assert good["channels"] == ["B.x.thrust", "B.x.velocity"]
        assert [step["op"] for step in good["steps"]] == ["channel", "channel", "multiply"]
        assert wrong["problem"]["start"] == columns[1].index("B.x.velocity")
        assert "not N and m/s" in wrong["problem"]["message"]
        assert "200 are the most" in long["problem"]["message"]
    only_a = client.post(f"{API}/expressions/check", json={"columns": [POWER], "variants": ["A"]})
    assert "no channel" in only_a.json()[0]["problem"]["message"]
    missing = {"columns": [POWER], "run": "r-aaaaaaaaaaaa"}
    assert client.post(f"{API}/expressions/check", json=missing).status_code == 404


def test_a_what_if_has_them(client: httpx.Client) -> None:
    names = ["B.x.thrust", "B.x.velocity", POWER, SLOW]
    body = {"scenario": "circle", "columns": names, "exact": True, "points": 100_000}
    head, whole = curves(client.post(f"{API}/whatif", json=body | {"start": 0.0, "end": 3.0}))
    assert [column["unit"] for column in head["columns"]] == ["N", "m/s", "W", "m/s"]
    low = whole[:, 0]
    np.testing.assert_allclose(low[2], low[0].astype(float) * low[1], rtol=1e-6)
    _, part = curves(client.post(f"{API}/whatif", json=body | {"start": 2.0, "end": 2.5}))
    np.testing.assert_array_equal(part, whole[:, :, 4000:5000])
    answer = client.post(f"{API}/whatif", json=body | {"columns": ["=B.x.thrust + 1"]})
    (error,) = answer.json()["errors"]
    assert (answer.status_code, error["loc"]) == (422, "columns.0")
    assert "character 15: + needs operands of one unit" in answer.text


def test_a_window_of_a_run_has_the_values_of_the_whole(
    client: httpx.Client, run: RunDetail
) -> None:
    url, columns = f"{API}/runs/{run.id}/window", f"A.x.thrust,{POWER},{SLOW}"
    every = {"columns": columns, "points": 500_000}
    head, whole = curves(client.get(url, params=every))
    assert [column["unit"] for column in head["columns"]] == ["N", "W", "m/s"]
    np.testing.assert_array_equal(whole[1, 0], power(run))
    for first, last in ((0, 7), (333, 1000), (run.ticks - 3, run.ticks)):
        _, part = curves(client.get(url, params=every | {"from": first, "to": last}))
        np.testing.assert_array_equal(part, whole[:, :, first:last])
    _, coarse = curves(client.get(url, params={"columns": POWER, "points": 10}))
    assert (coarse[0, 0].min(), coarse[0, 1].max()) == (power(run).min(), power(run).max())
    answer = client.get(url, params={"columns": "A.x.thrust,=nothing(A.x.thrust)"})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["loc"] == "columns.1"


def test_a_spectrum_of_one_is_that_of_its_samples(client: httpx.Client, run: RunDetail) -> None:
    params = {"columns": POWER, "averages": 1}
    answer = client.get(f"{API}/runs/{run.id}/spectrum", params=params)
    (found,) = answer.raise_for_status().json()["columns"]
    column = {"name": POWER, "unit": "W", "values": power(run).tolist()}
    body = {"period": run.period, "columns": [column], "averages": 1}
    (same,) = client.post(f"{API}/spectrum", json=body).raise_for_status().json()["columns"]
    assert found["density"] == same["density"]
    assert found["unit"] == same["unit"] == "W"


def test_files_of_a_run_have_them_by_their_names(client: httpx.Client, run: RunDetail) -> None:
    url = f"{API}/runs/{run.id}/telemetry"
    part = {"columns": f"{POWER},A.x.thrust", "from": 100, "to": 300}
    answer = client.get(url, params=part | {"format": "csv"}).raise_for_status()
    table = pa_csv.read_csv(io.BytesIO(answer.content))
    assert table.column_names == ["tick [1]", "time [s]", "A.x.thrust [N]", "power [W]"]
    np.testing.assert_array_equal(
        table["power [W]"].to_numpy().astype(np.float32), power(run)[100:300]
    )
    answer = client.get(url, params=part | {"columns": f"*,{POWER}"}).raise_for_status()
    schema = pq.read_schema(io.BytesIO(answer.content))
    assert len(schema) == len(run.columns) + 3
    assert schema.field("power").metadata[b"meaning"] == POWER[6:].encode()
    for format in ("mat", "mcap"):
        assert client.get(url, params=part | {"format": format}).status_code == 200
    wrong = part | {"columns": "power=A.x.thrust,power=A.x.friction"}
    assert "comes twice" in client.get(url, params=wrong).text


def test_files_of_a_session_have_them(client: httpx.Client) -> None:
    path = client.post(f"{API}/sessions", json={}).raise_for_status().headers["location"]
    try:
        client.post(f"{path}/step", json={"ticks": 40}).raise_for_status()
        names = "B.x.velocity,B.x.thrust"
        answer = client.get(f"{path}/telemetry", params={"columns": f"{names},{POWER}"})
        table = pq.read_table(io.BytesIO(answer.raise_for_status().content))
        assert table.column_names == ["tick", "time", *names.split(","), "power"]
        velocity, force = (table[name].to_numpy().astype(float) for name in names.split(","))
        np.testing.assert_allclose(table["power"].to_numpy(), force * velocity, rtol=1e-6)
        refused = client.get(f"{path}/telemetry", params={"columns": "=B.x.thrust + 1"})
        assert refused.status_code == 422
    finally:
        client.delete(path)
