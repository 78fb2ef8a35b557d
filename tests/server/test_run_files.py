"""Runs as files over REST: exported, imported."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
import pytest
import scipy.io
from mcap.reader import make_reader

from motionlab.config.named_configs import data_root
from motionlab.exchange.selection import FORMATS
from motionlab.library.library import library
from motionlab.library.run import RunDetail, new_id
from motionlab.server.settings import Settings
from motionlab.telemetry import recorder
from motionlab.telemetry.recorder import ROWS, parquet_writer
from tests.server.conftest import MakeServer
from tests.server.live import API, until
from tests.server.servers import PATIENCE, Server
from tests.simulated import SHORT, play

LONG = 83  # row groups of 65,536 ticks: 45 min
COLUMNS = "x.position_reference,A.x.following_error"


@pytest.fixture(scope="module")
def run() -> Iterator[RunDetail]:
    """Return a kept run."""
    from motionlab.simulation.result import document

    played = play("circle", SHORT)
    result = document(played.prepared, played.recording)
    kept = library().keep(played.prepared, played.recording, result)
    yield kept
    library().delete(kept.id)


def test_its_margins_are_searched_sorted_and_counted(client: httpx.Client, run: RunDetail) -> None:
    margin = 20 * np.log10(run.metrics["B.x.gain_margin"])

    def listed(search: str) -> list[str]:
        query = {"q": search, "sort": "-B.x.phase_margin"}
        found = client.get(f"{API}/runs", params=query).raise_for_status().json()["runs"]
        return [each["id"] for each in found]

    assert run.id in listed(f"B.x.gain_margin>{margin - 0.01}dB B.x.phase_margin>1deg")
    assert run.id not in listed(f"B.x.gain_margin>{margin + 0.01}dB")
    query = {"metric": "B.x.gain_margin", "q": f'name:"{run.name}"'}
    spread = client.get(f"{API}/runs/histogram", params=query).raise_for_status().json()
    assert spread["least"] <= run.metrics["B.x.gain_margin"] <= spread["greatest"]
    refused = client.get(f"{API}/runs", params={"q": "B.x.gain_margin>6deg"})
    assert refused.status_code == 422
    assert "one of dB" in refused.text


def test_its_reversals_are_measured(client: httpx.Client, run: RunDetail) -> None:
    axes = client.get(f"{API}/runs/{run.id}/glitches").raise_for_status().json()["axes"]
    for each in axes.values():
        a, b = (each["variants"][name]["mean"]["height"] for name in ("A", "B"))
        assert a > 20 * b > 0
    assert set(axes) == {"x", "y"}
    assert client.get(f"{API}/runs/r-aaaaaaaaaaaa/glitches").status_code == 404


def test_its_spectra_are_those_of_its_samples(client: httpx.Client, run: RunDetail) -> None:
    names = ["A.x.following_error", "B.x.following_error"]
    part = {"columns": ",".join(names), "from": 200, "to": 1400, "averages": 2}
    answer = client.get(f"{API}/runs/{run.id}/spectrum", params=part)
    of_run = answer.raise_for_status().json()
    with library().files.open(run.id) as file:
        table = file.read(names)
    columns = [
        {"name": name, "unit": "m", "values": table[name].to_pylist()[200:1400]} for name in names
    ]
    velocity = of_run["columns"][0]["loop"]["velocity"]
    body = {
        "period": run.period,
        "columns": columns,
        "averages": 2,
        "scenario": run.scenario_document,
        "velocity": velocity,
    }
    of_samples = client.post(f"{API}/spectrum", json=body).raise_for_status().json()
    for one, other in zip(of_run["columns"], of_samples["columns"], strict=True):
        assert one["density"] == other["density"]
        assert one["peaks"] == other["peaks"]
        assert one["loop"] == other["loop"]
        assert (one["start"], one["stop"], one["bins"]) == (200, 1400, 400)
    part = {"columns": names[0], "low": 100, "high": 200, "points": 10}
    (column,) = client.get(f"{API}/runs/{run.id}/spectrum", params=part).json()["columns"]
    assert 100 <= column["frequency"][0] < column["frequency"][-1] <= 200
    assert len(column["frequency"]) <= 10


def test_missing_samples_are_said_and_too_many_refused(client: httpx.Client) -> None:
    values = [None, *np.random.default_rng(1).standard_normal(99).tolist(), None, 1.0]
    body = {"period": 0.01, "averages": 1, "columns": [{"name": "c", "unit": "1"}]}
    body["columns"][0]["values"] = values
    (column,) = client.post(f"{API}/spectrum", json=body).raise_for_status().json()["columns"]
    assert (column["start"], column["stop"], column["missing"]) == (1, 100, 3)
    assert column["loop"] is None
    for change, told in (
        ({"columns": [body["columns"][0] | {"values": [None] * 100}]}, "samples"),
        ({"averages": 50}, "averages"),
        ({"low": 90.0}, "low"),
        ({"columns": [body["columns"][0] | {"values": [0] * 40_000}] * 2}, "columns"),
    ):
        answer = client.post(f"{API}/spectrum", json=body | change)
        assert answer.status_code == 422, answer.text
        assert told in answer.text


def test_the_formats_offered_can_be_written(client: httpx.Client, run: RunDetail) -> None:
    formats = client.get(f"{API}/runs/storage").raise_for_status().json()["formats"]
    assert {"csv", "parquet", "mat", "mcap"} <= set(formats)
    for format in FORMATS:
        part = {"format": format, "columns": COLUMNS, "to": 10}
        answer = client.get(f"{API}/runs/{run.id}/telemetry", params=part)
        assert (answer.status_code == 200) is (format in formats), answer.text


@pytest.mark.parametrize("format", ["csv", "parquet", "mat", "mcap"])
def test_a_download_of_each_format(client: httpx.Client, run: RunDetail, format: str) -> None:
    part = {"format": format, "columns": COLUMNS, "from": 100, "to": 300}
    answer = client.get(f"{API}/runs/{run.id}/telemetry", params=part)
    assert answer.status_code == 200, answer.text
    name = f'attachment; filename="{run.id}_0.05-0.1495s.{format}"'
    assert answer.headers["content-disposition"] == name
    content = io.BytesIO(answer.content)
    with library().files.open(run.id) as file:
        wanted = file.read(["A.x.following_error"])["A.x.following_error"].to_numpy()[100:300]
    match format:
        case "csv":
            found = pa_csv.read_csv(content)["A.x.following_error [m]"].to_numpy()
        case "parquet":
            found = pq.read_table(content)["A.x.following_error"].to_numpy()
        case "mat":
            found = scipy.io.loadmat(content)["run"][0, 0]["A_x_following_error"].ravel()
        case _:
            messages = list(make_reader(content).iter_messages("/A/x"))
            assert messages[0][2].log_time == round(run.created * 1e6) * 1000 + 50_000_000
            found = np.concatenate([np.frombuffer(m.data[1:], "<f4") for _, _, m in messages])
    np.testing.assert_array_equal(np.asarray(found).astype(np.float32), wanted)


def test_everything_is_parquet_when_nothing_is_asked_for(
    client: httpx.Client, run: RunDetail
) -> None:
    answer = client.get(f"{API}/runs/{run.id}/telemetry")
    table = pq.read_table(io.BytesIO(answer.content))
    assert table.num_rows == run.ticks
    assert table.column_names[2:] == [column["name"] for column in run.columns]
    assert table.schema.metadata[b"run"].decode() == run.id


@pytest.mark.parametrize(
    ("query", "loc"),
    [
        ({"format": "xlsx"}, "format"),
        ({"columns": "A.x.nothing"}, "columns.0"),
        ({"columns": "A.x.K,A.x.K"}, "columns.1"),
        ({"from": 10_000_000}, "from"),
        ({"from": 7, "to": 7}, "from"),
        ({"from": -1}, "from"),
    ],
)
def test_a_selection_of_nothing(
    client: httpx.Client, run: RunDetail, query: dict[str, str | int], loc: str
) -> None:
    answer = client.get(f"{API}/runs/{run.id}/telemetry", params=query)
    assert answer.status_code == 422
    assert [error["loc"] for error in answer.json()["errors"]] == [loc]


def test_a_run_that_is_none(client: httpx.Client) -> None:
    for unknown in ("r-aaaaaaaaaaaa", "..", "x"):
        assert client.get(f"{API}/runs/{unknown}/telemetry").status_code == 404


@pytest.fixture(scope="module")
def long_run(run: RunDetail) -> Iterator[tuple[RunDetail, list[float]]]:
    """Return a run of 45 min of three channels, and the values that they repeat."""
    wave = np.random.default_rng(1).standard_normal(ROWS).astype(np.float32)
    names = ["x.position_reference", "A.x.following_error", "B.x.following_error"]
    columns = [each for each in run.columns if each["name"] in names]
    with library().files.open(run.id) as file:
        schema = pa.schema([file.schema_arrow.field(name) for name in ("tick", "time", *names)])

    def write(part: str) -> None:
        with parquet_writer(Path(part), schema) as writer:
            for first in range(0, LONG * ROWS, ROWS):
                ticks = np.arange(first, first + ROWS)
                arrays = [pa.array(each) for each in (ticks, ticks * 0.0005, wave, -wave, wave)]
                writer.write_batch(pa.RecordBatch.from_arrays(arrays, schema=schema))

    about = {"id": new_id(), "ticks": LONG * ROWS, "columns": columns}
    kept = library().keep_file(run.model_copy(update=about), write)
    yield kept, wave.tolist()
    library().delete(kept.id)


@pytest.mark.parametrize("format", ["csv", "parquet", "mcap"])
def test_a_recording_beyond_memory_is_downloaded_whole(
    make_server: MakeServer, long_run: tuple[RunDetail, list[float]], format: str, tmp_path: Path
) -> None:
    run, wave = long_run
    server = make_server(Settings(memory_max=10_000_000))
    file = tmp_path / f"run.{format}"
    address = f"{server.url}{API}/runs/{run.id}/telemetry"
    with (
        httpx.stream("GET", address, params={"format": format}, timeout=PATIENCE) as answer,
        file.open("wb") as into,
    ):
        assert answer.status_code == 200, answer.read()
        for chunk in answer.iter_bytes():
            into.write(chunk)
    assert not list(data_root().glob("motionlab-scratch-*"))
    if format == "mcap":
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert set(summary.statistics.channel_message_counts.values()) == {LONG * ROWS}
        return
    found = recorder.read(str(file))
    assert list(found) == ["tick", "time", *(each["name"] for each in run.columns)]
    np.testing.assert_array_equal(found["tick"].values, np.arange(LONG * ROWS))
    whole = np.tile(np.array(wave, np.float32), LONG)
    for column, sign in zip(list(found.values())[2:], (1, -1, 1), strict=True):
        np.testing.assert_array_equal(column.values, sign * whole)


def test_what_is_written_in_memory_is_refused_beyond_it(
    make_server: MakeServer, long_run: tuple[RunDetail, list[float]]
) -> None:
    run, _ = long_run
    server = make_server(Settings(memory_max=10_000_000))
    address = f"{server.url}{API}/runs/{run.id}/telemetry"
    for part in ({"format": "mat"}, {"columns": "twice=2 * A.x.following_error"}):
        answer = httpx.get(address, params=part, timeout=PATIENCE)
        assert answer.status_code == 422, part
        (error,) = answer.json()["errors"]
        assert error["bounds"] == {"maximum": 10_000_000}
        file = f"FILE.{part.get('format', 'parquet')}"
        assert f"motionlab export {run.id} {file}" in error["message"]
    part = {"format": "mat", "to": 1000}
    assert httpx.get(address, params=part, timeout=PATIENCE).status_code == 200


def test_a_download_leaves_recordings_room_on_the_disk(
    server: Server, long_run: tuple[RunDetail, list[float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    from motionlab.server import file_download

    monkeypatch.setattr(file_download, "_LONG", 1_000_000_000)
    monkeypatch.setattr(file_download, "FREE_LEAST", 10**18)
    answer = httpx.get(f"{server.url}{API}/runs/{long_run[0].id}/telemetry", timeout=PATIENCE)
    assert answer.status_code == 507
    assert "free" in answer.json()["detail"]


# -- import ---------------------------------------------------------------------------------------

CSV = "time [s],x_ref [mm],x_act [mm]\n" + "".join(
    f"{i / 2000},{i / 10},{i / 10 - 0.001}\n" for i in range(100)
)


def upload(client: httpx.Client, content: str | bytes, **query: Any) -> httpx.Response:
    headers = {"content-type": "application/octet-stream"}
    address = f"{API}/runs/import"
    data = content.encode() if isinstance(content, str) else content
    return client.post(address, params=query, content=data, headers=headers)


def test_a_measurement_is_previewed_corrected_and_kept(client: httpx.Client) -> None:
    before = client.get(f"{API}/runs").json()["total"]
    preview = upload(client, CSV, preview=True)
    assert preview.status_code == 200
    assert preview.json()["columns"][1]["channel"] == "x.position_reference"
    assert preview.json()["columns"][1]["first"] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert preview.json()["channels"]["M.x.thrust"] == "N"
    assert preview.json()["units"]["N"] == ["N", "mN", "kN"]
    assert client.get(f"{API}/runs").json()["total"] == before
    mapping = ["x_ref=y.position_reference", "x_act=M.y.position_measured[um]"]
    answer = upload(client, CSV, name="rig 7", map=mapping)
    assert answer.status_code == 201
    document = answer.json()
    assert document["derived"] == ["M.y.following_error"]
    assert answer.headers["location"] == f"{API}/runs/{document['run']}"
    run = client.get(answer.headers["location"]).json()
    assert (run["kind"], run["name"], run["variants"]) == ("measurement", "rig 7", ["M"])
    assert run["result"]["import"]["columns"] == document["columns"]
    found = client.get(f"{API}/runs", params={"q": "kind:measurement rig M.y.max>1mm"}).json()
    assert [entry["id"] for entry in found["runs"]] == [run["id"]]
    window = {"columns": "M.y.position_measured", "points": 10}
    assert client.get(f"{answer.headers['location']}/window", params=window).status_code == 200
    table = client.get(f"{answer.headers['location']}/telemetry")
    values = pq.read_table(io.BytesIO(table.content))["M.y.position_measured"].to_numpy()
    np.testing.assert_allclose(values, [(i / 10 - 0.001) * 1e-6 for i in range(100)], rtol=1e-5)
    client.delete(answer.headers["location"])


def test_two_files_are_one_body(client: httpx.Client) -> None:
    second = "time [s],force [N]\n0,1\n0.01,2\n0.02,3\n"
    answer = upload(client, CSV + second, preview=True, first_bytes=len(CSV), offset=0.005)
    assert answer.status_code == 200
    document = answer.json()
    assert (document["merged"]["rows"], document["merged"]["offset"]) == (3, 0.005)
    assert "force [N]" in [column["column"] for column in document["columns"]]
    kept = upload(client, CSV + second, first_bytes=len(CSV), offset=0.005)
    assert kept.status_code == 201
    client.delete(kept.headers["location"])
    for query, loc, why in (
        ({"offset": 1.0}, "offset", "is of two files"),
        ({"align": "x"}, "align", "is of two files"),
        ({"first_bytes": len(CSV)}, "first_bytes", "leaves nothing"),
        ({"first_bytes": 10}, "file", ""),
        ({"first_bytes": len(CSV), "align": "x=y"}, "align", "no column of that name"),
        ({"first_bytes": len(CSV), "align": ""}, "align", "name one of each as A=B, or give"),
    ):
        body = CSV + second if "first_bytes" in query and "align" in query else CSV
        refused = upload(client, body, **query)
        assert refused.status_code == 422
        (error,) = refused.json()["errors"]
        assert error["loc"] == loc
        assert why in error["message"]


@pytest.mark.parametrize(
    ("content", "query", "loc", "why"),
    [
        ("nothing at all", {}, "file", "no line of numbers"),
        (CSV.replace("0.001,", "zero,"), {}, "file", "line 4, column"),
        (CSV, {"map": "x_ref"}, "map.0", "is no mapping"),
        (CSV, {"map": "x_ref=A.x.thrust"}, "map.0", "no channel of that name"),
        (CSV, {"map": "nothing=time"}, "map.0", "no column of that name"),
        (CSV, {"map": ["x_ref=x.position_reference", "x_act=M.x.thrust"]}, "map.1", "another unit"),
        (CSV, {"decimal": "comma"}, "file", "no line of numbers"),
        (CSV, {"delimiter": "dot"}, "delimiter", ""),
        (CSV, {"rate": -1}, "rate", "out of range"),
        (CSV, {"rate": "nan"}, "rate", ""),
        ("x\n1\n2\n", {}, "file", "no column of time"),
        (b"PAR1" + bytes(100), {}, "file", "is no Parquet file"),
    ],
)
def test_an_import_that_is_refused(
    client: httpx.Client, content: str | bytes, query: dict[str, Any], loc: str, why: str
) -> None:
    answer = upload(client, content, **query)
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert error["loc"] == loc
    assert why in error["message"]


def test_uploads_have_a_bound_of_their_own(make_server: MakeServer) -> None:
    server = make_server(Settings(body_max=1000, upload_max=len(CSV)))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        assert len(CSV) > 1000
        assert upload(client, CSV, preview=True).status_code == 200
        assert upload(client, CSV + "\n", preview=True).status_code == 413

        def pieces() -> Iterator[bytes]:
            yield CSV.encode()
            yield b"more"

        answer = client.post(f"{API}/runs/import", content=pieces())
        assert answer.status_code == 413


def test_what_uploads_hold_is_given_back(server: Server, client: httpx.Client) -> None:
    for content in (CSV, "nothing"):
        upload(client, content, preview=True)
    memory = server.app.state.memory
    before = memory._taken
    upload(client, CSV, preview=True)
    assert memory._taken == before


def test_its_circle_is_as_round_as_its_recording(client: httpx.Client, run: RunDetail) -> None:
    found = client.post(f"{API}/views/ballbar", json={"run": run.id}).raise_for_status().json()
    with library().files.open(run.id) as file:
        names = [f"{axis}.position_reference" for axis in "xy"]
        names += [f"A.{axis}.following_error" for axis in "xy"]
        x, y, e_x, e_y = (file.read([name])[name].to_numpy()[-6000:] for name in names)
    F = np.hypot(x.astype(float) - e_x, y.astype(float) - e_y) - 0.015
    way = found["variants"]["A"]["directions"]["ccw"]
    assert way["simulated"] is False
    assert way["F_max"] == pytest.approx(F.max(), abs=5e-9)
    assert way["F_min"] == pytest.approx(F.min(), abs=5e-9)
    assert found["variants"]["A"]["directions"]["cw"]["simulated"] is True
    body = {"scenario": "circle", "set": SHORT}
    other = client.post(f"{API}/views/ballbar", json=body).raise_for_status().json()
    again = other["variants"]["A"]["directions"]["ccw"]["F_max"]
    assert again == pytest.approx(way["F_max"], abs=2e-9)


def test_its_friction_is_that_of_its_recording(client: httpx.Client, run: RunDetail) -> None:
    body = {"run": run.id, "start": 0.0, "end": 2.0}
    found = client.post(f"{API}/views/friction", json=body).raise_for_status().json()
    with library().files.open(run.id) as file:
        names = ("B.x.friction", "B.x.friction_estimate")
        true, estimate = (file.read([name])[name].to_numpy()[:4000].astype(float) for name in names)
    figures = found["axes"]["x"]["variants"]["B"]["figures"]
    assert figures["mismatch_max"] == pytest.approx(np.abs(estimate - true).max(), rel=1e-6)
    assert (found["note"], found["end"]) == ("", 2.0)


def test_positioning_is_of_a_cycle_or_of_rests(client: httpx.Client, run: RunDetail) -> None:
    body: dict[str, Any] = {"targets": 2, "runs": 2, "low": -0.01, "high": 0.01}
    found = client.post(f"{API}/views/positioning", json=body).raise_for_status().json()
    assert found["simulated"] is True
    assert [len(each["up"]) for each in found["variants"]["A"]["targets"]] == [2, 2]
    refused = {
        "rests at no target": {"run": run.id},
        "is of a run": body | {"start": 1.0},
        "leaves no room": body | {"high": 0.2},
        "too long for a view": body | {"targets": 50, "runs": 10},
    }
    for told, wrong in refused.items():
        answer = client.post(f"{API}/views/positioning", json=wrong)
        assert (answer.status_code, told in answer.text.lower()) == (422, True), answer.text


def test_a_view_that_cannot_be_is_refused_by_name(client: httpx.Client) -> None:
    square = client.post(f"{API}/views/ballbar", json={"scenario": "rhombus"})
    assert square.status_code == 422
    assert "is no circle" in square.json()["detail"]
    late = {"scenario": "circle", "end": 100.0}
    assert client.post(f"{API}/views/ballbar", json=late).status_code == 422
    missing = {"run": "r-aaaaaaaaaaaa"}
    assert client.post(f"{API}/views/ballbar", json=missing).status_code == 404


def test_its_contour_and_its_cost_are_those_of_its_recording(
    client: httpx.Client, run: RunDetail
) -> None:
    body = {"run": run.id, "start": 1.0, "end": 3.0}
    found = client.post(f"{API}/views/contouring", json=body).raise_for_status().json()
    cost = client.post(f"{API}/views/cost", json=body).raise_for_status().json()
    names = [f"B.{axis}.following_error" for axis in "xy"]
    names += [f"B.x.current_{phase}" for phase in "abc"] + ["B.x.thrust"]
    with library().files.open(run.id) as file:
        read = file.read(names)
        e_x, e_y, i_a, i_b, i_c, thrust = (
            read[name].to_numpy()[2000:6000].astype(float) for name in names
        )
    figures = found["variants"]["B"]["figures"]
    assert figures["tracking_max"] == pytest.approx(np.hypot(e_x, e_y).max(), rel=1e-6)
    assert figures["contour_max"] <= figures["tracking_max"]
    x = cost["variants"]["B"]["x"]
    assert x["current_peak"] == max(np.abs(each).max() for each in (i_a, i_b, i_c))
    assert x["force_rms"] == pytest.approx(np.sqrt(np.mean(thrust**2)), rel=1e-6)
    assert x["balance"]["residual"] == pytest.approx(0.0, abs=1e-3 * x["friction_work"])
    one_axis = client.post(f"{API}/views/contouring", json={"scenario": "stair-y-500nm"})
    assert one_axis.status_code == 422
    (error,) = one_axis.json()["errors"]
    assert error["loc"] == "trajectory"
    assert "one axis only" in error["message"]


def test_unfinished_uploads_leave_memory_to_others(make_server: MakeServer) -> None:
    server = make_server(Settings(memory_max=8_000_000, upload_max=2_000_000))
    sent, over = threading.Event(), threading.Event()

    def unfinished() -> Iterator[bytes]:
        yield 1_500_000 * b"1"
        sent.set()
        assert over.wait(PATIENCE)

    def upload(content: Any) -> int:
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
            path = f"{API}/runs/import?preview=true"
            return client.post(path, content=content).status_code

    with ThreadPoolExecutor(1) as clients:
        first = clients.submit(upload, unfinished())
        assert sent.wait(PATIENCE)
        until(lambda: server.app.state.uploads.taken == 1_500_000)
        try:
            assert upload(1_000_000 * b"1") == 429
            assert server.app.state.memory.taken < 3_000_000
        finally:
            over.set()
        first.result(PATIENCE)
    until(lambda: server.app.state.uploads.taken == 0)
