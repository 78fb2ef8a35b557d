"""A drive link that nobody answers: its calls, its lease, and what it says is wrong."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from motionlab.config.drive import DriveConfig, load_drive
from motionlab.drive.lease import SECONDS
from motionlab.drive.link.bring_up import BringUp
from motionlab.drive.link.carrier import Carrier, LinkError
from motionlab.drive.link.cycle import HEARTBEAT
from motionlab.server.app import create_app
from motionlab.server.settings import Settings
from tests.paths import ROOT
from tests.processes import children_of, runs
from tests.server.live import API, until
from tests.server.openapi import Contract, body_examples
from tests.server.servers import PATIENCE, Server
from tests.server.test_stop import without_threads

DRIVE = f"{API}/drive"
LOOP = "motionlab.drive.link.process"
ARM = {"scenario": "circle", "variant": "A", "confirm": True}


def link_to(**changes: Any) -> DriveConfig:
    """Return the shipped link with another bus: nobody answers at port 9."""
    config = load_drive(ROOT / "configs" / "drives" / "virtual.toml")
    bus = config.link.model_copy(update={"port": 9} | changes)
    return config.model_copy(update={"link": bus})


@pytest.fixture(scope="module")
def linked() -> Iterator[Server]:
    server = Server(Settings(drive=link_to()))
    yield server
    server.stop()


@pytest.fixture
def drive(linked: Server, contract: Contract) -> Iterator[httpx.Client]:
    """Return a client of the calls of drives, whose lease is free and whose answers are checked."""
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    with httpx.Client(base_url=linked.url, event_hooks=hooks, timeout=PATIENCE) as client:
        until(lambda: client.get(DRIVE).json()["holder"] is None)
        yield client


def refused(answer: httpx.Response) -> str:
    """Return why something is not possible now."""
    assert answer.status_code == 409, answer.text
    return answer.json()["detail"]


def take(client: httpx.Client, holder: str = "me") -> dict[str, str]:
    """Take the lease and return it as a header."""
    answer = client.post(f"{DRIVE}/lease", json={"holder": holder})
    assert answer.status_code == 201, answer.text
    assert answer.json()["seconds"] == SECONDS
    return {"Lease": answer.json()["lease"]}


def test_without_a_link_there_is_nothing(client: httpx.Client, contract: Contract) -> None:
    calls = [
        (method, path)
        for path, methods in contract.document["paths"].items()
        for method in methods
        if path.startswith(DRIVE)
    ]
    assert len(calls) == 15
    for method, path in calls:
        example = (
            body_examples(contract.document, operation["operationId"])
            if ("requestBody" in (operation := contract.document["paths"][path][method]))
            else [None]
        )
        answer = client.request(method, path, json=example[0], headers={"Lease": "x"})
        assert answer.status_code == 404, path
        assert "--drive FILE" in answer.json()["detail"]
    assert client.get(f"{API}/health").json()["drive"] is False


def test_the_document_is_complete(contract: Contract) -> None:
    document = create_app(Settings(drive=link_to())).openapi()
    assert document == contract.document  # the same with a link
    for path, methods in document["paths"].items():
        for operation in methods.values() if path.startswith(DRIVE) else ():
            assert operation["summary"]
            assert operation["description"]
            if "requestBody" in operation:
                assert body_examples(document, operation["operationId"])


def test_nobody_answers(linked: Server, drive: httpx.Client) -> None:
    until(lambda: drive.get(DRIVE).json()["problem"] != "")
    status = drive.get(DRIVE).json()
    assert status["state"] == "offline"
    assert status["problem"] == "no answer within 500 ms: check cable, power and address"
    assert status["fault"] is None
    assert httpx.get(f"{linked.url}{API}/health").json()["drive"] is True


def test_one_holds_the_lease(drive: httpx.Client) -> None:
    held = take(drive, "Ada")
    assert drive.get(DRIVE).json()["holder"] == "Ada"
    for lease in ("x", ""):
        for answer in (
            drive.post(f"{DRIVE}/arm", json=ARM, headers={"Lease": lease}),
            drive.post(f"{DRIVE}/motions", json={"variant": "A"}, headers={"Lease": lease}),
            drive.post(f"{DRIVE}/disarm", headers={"Lease": lease}),
            drive.post(f"{DRIVE}/reset", headers={"Lease": lease}),
            drive.put(f"{DRIVE}/lease", headers={"Lease": lease}),
            drive.delete(f"{DRIVE}/lease", headers={"Lease": lease}),
        ):
            assert refused(answer) == "'Ada' controls the drives: take control first"
    assert (
        refused(drive.post(f"{DRIVE}/lease", json={"holder": "Bob"})) == "'Ada' controls the drives"
    )
    assert drive.get(DRIVE).json()["asking"] is None
    assert drive.post(f"{DRIVE}/lease/request", json={"holder": "Bob"}).status_code == 204
    assert drive.get(DRIVE).json()["asking"] == "Bob"
    for call in ("/arm", "/motions", "/disarm", "/reset"):
        answer = drive.post(DRIVE + call, json=ARM)
        assert answer.status_code == 422
        assert answer.json()["errors"][0]["loc"] == "Lease"
    assert drive.put(f"{DRIVE}/lease", headers=held).status_code == 204
    assert drive.delete(f"{DRIVE}/lease", headers=held).status_code == 204
    until(lambda: drive.get(DRIVE).json()["holder"] is None)
    nobody = drive.post(f"{DRIVE}/lease/request", json={"holder": "Bob"})
    assert refused(nobody) == "no one controls the drives: take control"
    take(drive, "Bob")
    assert drive.get(DRIVE).json()["asking"] is None


@pytest.mark.parametrize("holder", ["", "  ", "\u00a0", "\u200b", "a\u202eb", "\x1b[2J", "x" * 41])
def test_a_holder_has_a_name_that_is_seen(drive: httpx.Client, holder: str) -> None:
    answer = drive.post(f"{DRIVE}/lease", json={"holder": holder})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["loc"] == "holder"


def test_the_lease_ends_without_a_heartbeat(drive: httpx.Client) -> None:
    held = take(drive)
    for _ in range(6):
        time.sleep(SECONDS / 4)
        assert drive.put(f"{DRIVE}/lease", headers=held).status_code == 204
    until(lambda: drive.get(DRIVE).json()["holder"] is None)
    assert "no one controls the drives" in refused(drive.put(f"{DRIVE}/lease", headers=held))
    take(drive, "another")


def test_a_stop_needs_no_thread_of_requests(linked: Server, drive: httpx.Client) -> None:
    with without_threads(linked):
        assert drive.post(f"{DRIVE}/stop").status_code == 200


def test_anyone_may_stop(drive: httpx.Client) -> None:
    assert drive.post(f"{DRIVE}/stop").status_code == 200
    take(drive)
    status = drive.post(f"{DRIVE}/stop", params={"by": "\n" + 500 * "ä"})  # no name refuses a stop
    assert status.status_code == 200
    assert status.json()["stopped"] is None  # nothing had torque


def test_arming_is_meant(drive: httpx.Client) -> None:
    held = take(drive)
    for confirm in ({}, {"confirm": False}, {"confirm": "yes"}, {"confirm": 1}):
        body = {"scenario": "circle", "variant": "A"} | confirm
        answer = drive.post(f"{DRIVE}/arm", json=body, headers=held)
        assert answer.status_code == 422, confirm
        assert answer.json()["errors"][0]["loc"] == "confirm"


def test_what_drives_cannot_do_is_refused(drive: httpx.Client) -> None:
    held = take(drive)
    until(lambda: drive.get(DRIVE).json()["problem"] != "")
    assert "while the link is offline" in refused(
        drive.post(f"{DRIVE}/arm", json=ARM, headers=held)
    )
    answer = drive.post(f"{DRIVE}/motions", json={"scenario": "circle"}, headers=held)
    assert answer.status_code == 422
    assert "drives run one at a time" in answer.json()["detail"]
    body = {"scenario": "circle", "variant": "C"}
    answer = drive.post(f"{DRIVE}/motions", json=body, headers=held)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["loc"] == "variant"


def test_reset_tries_again(drive: httpx.Client, linked: Server) -> None:
    until(lambda: drive.get(DRIVE).json()["problem"] != "")
    held = take(drive)
    assert drive.post(f"{DRIVE}/reset", headers=held).status_code == 200
    until(lambda: drive.get(DRIVE).json()["step"] == "finding drives")
    (loop,) = children_of(os.getpid(), LOOP)
    os.kill(loop, signal.SIGKILL)
    until(lambda: "has ended" in drive.get(DRIVE).json()["problem"])
    assert refused(drive.post(f"{DRIVE}/reset", headers={"Lease": "x"}))
    held = take(drive) if drive.get(DRIVE).json()["holder"] is None else held
    assert drive.post(f"{DRIVE}/reset", headers=held).status_code == 200
    until(lambda: "no answer" in drive.get(DRIVE).json()["problem"])
    (again,) = children_of(os.getpid(), LOOP)
    assert again != loop


def test_a_loop_without_drives_outlives_a_silent_server_but_no_dead_one() -> None:
    code = (
        "import sys, time; from motionlab.config.drive import DriveConfig as Config;"
        "from motionlab.drive.link.link import DriveLink;"
        "link = DriveLink(Config.model_validate_json(sys.argv[1]));"
        "exec('while not link.problem: time.sleep(0.1)');"
        "print('offline', flush=True);"
        "time.sleep(600)"
    )
    command = [sys.executable, "-c", code, link_to().model_dump_json()]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as server:
        try:
            assert server.stdout is not None
            server.stdout.readline()
            (loop,) = children_of(server.pid, LOOP)
            server.send_signal(signal.SIGSTOP)
            time.sleep(3 * HEARTBEAT / 2e9)
            assert children_of(server.pid, LOOP) == [loop]
        finally:
            server.kill()
    until(lambda: not runs(loop))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"carrier": "ethernet", "interface": "none0"}, "link.interface = 'none0': "),
        ({"address": "1.2.3.4.5"}, "link.address = '1.2.3.4.5': "),
    ],
    ids=["no such card", "no address"],
)
def test_a_bus_that_is_not_there(
    changes: dict[str, Any], expected: str, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO, logger="motionlab"), contextlib.ExitStack() as ended:
        server = Server(Settings(drive=link_to(**changes)))
        ended.callback(server.stop)
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as drive:
            until(lambda: drive.get(DRIVE).json()["problem"] != "")
            status = drive.get(DRIVE).json()
    told = [record.getMessage() for record in caplog.records]
    assert told[0].startswith("drive link: compiling the loop")
    assert f"drive link: {status['problem']}" in told
    assert expected in status["problem"]
    assert status["state"] == "offline"


def test_an_address_where_nobody_is() -> None:
    config = link_to(address="203.0.113.1", port=34980)
    with contextlib.closing(Carrier(config.link)) as carrier:
        with pytest.raises(LinkError, match=r"^no answer within 500 ms"):
            BringUp(carrier, config).bring_up()
