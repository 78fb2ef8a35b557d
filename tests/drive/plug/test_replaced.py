"""A drive is replaced: what was found on the drives of before does not count for others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from motionlab.cli.main import main
from motionlab.drive.virtual.process import VirtualDrive
from motionlab.errors import DONE, FAILED
from motionlab.server.settings import Settings
from tests.drive.link.rig import SLOW, linked
from tests.drive.plug.test_motion import BEFORE, DONE_BEFORE, DRIVE, MOTION, Operator, found
from tests.server.live import until
from tests.server.servers import PATIENCE, Server

PLACE = f"{DRIVE}/commissioning"
CHANGE = {"path": "x.offset", "now": 0.0, "then": 0.0012}


def machine(port: int, third: int) -> VirtualDrive:
    """Return a virtual drive at a port, with a serial number of its third drive."""
    options = [f"--serials=1,2,{third},4,5,6"]
    return VirtualDrive(priority=70, slow=SLOW, port=port, options=options)


@pytest.fixture
def client() -> Iterator[httpx.Client]:
    """Return a client of a server whose drives are not there yet, with a machine's port."""
    with machine(0, 3) as drive:
        config = linked(drive)
    server = Server(Settings(drive=config))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        client.headers["Port"] = str(drive.port)
        yield client
    server.stop()


def up(operator: Operator) -> None:
    """Bring the drives up, as a person does after a fault."""

    def ready() -> bool:
        status = operator.client.get(DRIVE).json()
        if status["state"] == "fault" or status["problem"]:
            operator.client.post(f"{DRIVE}/reset", headers=operator.lease)
        return status["state"] == "ready" and status["loop"]["phase_locked"]

    until(ready)


def test_a_drive_is_replaced(client: httpx.Client, capsys: pytest.CaptureFixture[str]) -> None:
    port, at = int(client.headers["Port"]), ["--server", str(client.base_url).rstrip("/")]
    arm: dict[str, Any] = {"json": {**MOTION, "confirm": True}}
    with Operator(client) as operator:
        with machine(port, 3):
            up(operator)
            document = found(dict.fromkeys(BEFORE, DONE_BEFORE), CHANGE)
            loaded = client.put(PLACE, json=document, headers=operator.lease)
            assert loaded.status_code == 200, loaded.text
            up(operator)
            before = client.get(DRIVE).json()
            assert before["axes"][0]["limits"]["offset"] == 0.0012
        until(lambda: client.get(DRIVE).json()["state"] == "fault")
        with machine(port, 77):
            up(operator)
            told = "1, 2, 3, 4, 5, 6 commissioned, 1, 2, 77, 4, 5, 6 found"
            # The offset is of the other machine: the link comes up once more without it.
            status = operator.until(
                lambda status: (
                    status["state"] == "ready" and status["axes"][0]["limits"]["offset"] == 0
                )
            )
            assert status["other_drives"].endswith(told)
            up(operator)
            refused = client.post(f"{DRIVE}/arm", headers=operator.lease, **arm)
            assert refused.status_code == 409
            assert told in refused.json()["detail"]
            commissioning = client.get(PLACE).json()
            assert [step["state"] for step in commissioning["steps"][:2]] == ["now", "waiting"]
            assert all(step["finding"] is None for step in commissioning["steps"])
            assert commissioning["record"] == document
            answer = client.put(PLACE, json=document, headers=operator.lease)
            assert "found are 1, 2, 77, 4, 5, 6" in answer.json()["detail"]
            assert main(["drive", "status", *at]) == DONE
            assert told in capsys.readouterr().out
            assert main(["drive", "commission", *at]) == DONE
            shown = capsys.readouterr().out
            assert told in shown
            assert "taken" not in shown

            begun = client.post(f"{PLACE}/drives", headers=operator.lease)
            assert begun.json()["record"]["serials"] == [1, 2, 77, 4, 5, 6]
            assert client.get(DRIVE).json()["other_drives"] == ""
            assert client.post(f"{DRIVE}/arm", headers=operator.lease, **arm).status_code == 200
            client.post(f"{DRIVE}/disarm", headers=operator.lease)
        until(lambda: client.get(DRIVE).json()["state"] == "fault")
        assert main(["drive", "status", *at]) == FAILED
