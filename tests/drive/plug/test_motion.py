"""Motions on a virtual drive through the server: one moves it, anyone may stop it."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli.main import main
from motionlab.config.drive import load_drive
from motionlab.config.named_configs import data_root
from motionlab.drive.commissioning import currents, seal, shaking
from motionlab.drive.commissioning.record import ORDER, CommissioningRecord
from motionlab.drive.lease import SECONDS
from motionlab.drive.plug import friction_step
from motionlab.drive.virtual.process import VirtualDrive
from motionlab.errors import BAD_INPUT, DONE, FAILED
from motionlab.server.settings import Settings
from tests.drive.link.rig import SLOW, linked
from tests.paths import ROOT
from tests.processes import children_of
from tests.server.live import API, until
from tests.server.openapi import Contract
from tests.server.servers import PATIENCE, Server
from tests.simulated import play

DRIVE = f"{API}/drive"
SHORT = {
    "trajectory.radius": 0.002,
    "trajectory.frequency": 1.0,
    "trajectory.laps": 1,
    "trajectory.lead_in": 0.5,
}
MOTION = {"scenario": "circle", "variant": "B", "set": SHORT}
GAINS = "variants.B.controller.x"
FIRST, SECOND = 2000, 2200
OF_B = (
    {f"{GAINS}.k_d": 0.0},
    {f"{GAINS}.k_d": 2000.0, "variants.B.controller.disturbance_observer.enabled": False},
)
SCHEDULE = [
    {"time": 1.0, "set": OF_B[0] | {"variants.A.controller.x.k_p": 2e5}},
    {"time": 1.1, "set": OF_B[1]},
]
LONG = MOTION | {"set": SHORT | {"trajectory.laps": 30}}
BEFORE = ("drives", "identity", "encoders")
DONE_BEFORE = {"at": 0.0, "holds": True, "text": "done"}
SIMULATED_ONLY = ("position", "velocity", "acceleration", "friction", "bristle", "thrust")


@pytest.fixture(scope="module")
def virtual() -> Iterator[VirtualDrive]:
    with VirtualDrive(priority=70, slow=SLOW) as drive:
        yield drive


@pytest.fixture(scope="module")
def linked_server(virtual: VirtualDrive) -> Iterator[Server]:
    server = Server(Settings(drive=linked(virtual)))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        for _ in range(2):  # the loop may have to be compiled first
            with contextlib.suppress(AssertionError):
                until(lambda: client.get(DRIVE).json()["step"] not in {"", "compiling"})
    yield server
    server.stop()


@pytest.fixture
def anyone(linked_server: Server, contract: Contract) -> Iterator[httpx.Client]:
    """Return a client without the lease."""
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    with httpx.Client(base_url=linked_server.url, event_hooks=hooks, timeout=PATIENCE) as client:
        yield client
        client.post(f"{DRIVE}/stop")


class Operator:
    """Who holds the lease, with a heartbeat until the block ends."""

    def __init__(self, client: httpx.Client) -> None:
        self.client = client
        self._silent = threading.Event()

    def __enter__(self) -> Operator:
        self.until(lambda status: status["holder"] is None)
        answer = self.client.post(f"{DRIVE}/lease", json={"holder": "operator"})
        self.lease = {"Lease": answer.json()["lease"]}
        self._beating = threading.Thread(target=self._beat)
        self._beating.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.fall_silent()
        self.client.delete(f"{DRIVE}/lease", headers=self.lease)

    def fall_silent(self) -> None:
        self._silent.set()
        self._beating.join()

    def _beat(self) -> None:
        while not self._silent.wait(SECONDS / 4):
            self.client.put(f"{DRIVE}/lease", headers=self.lease)

    def until(self, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Wait for a state of the drives, and return it."""
        found: dict[str, Any] = {}

        def looks() -> bool:
            found.update(self.client.get(DRIVE).json())
            return holds(found)

        until(looks)
        return found

    def arm(self) -> None:
        """Have the drives hold their position, whatever was before."""
        status = self.until(lambda status: status["state"] != "offline" or status["problem"] != "")
        if status["state"] in {"fault", "offline"}:
            self.client.post(f"{DRIVE}/reset", headers=self.lease)
        self.until(lambda status: status["state"] == "ready" and status["loop"]["phase_locked"])
        body = {**MOTION, "confirm": True}
        until(lambda: self._armed(body))
        self.until(lambda status: status["state"] in {"holding", "fault"})

    def _armed(self, body: dict[str, Any]) -> bool:
        answer = self.client.post(f"{DRIVE}/arm", json=body, headers=self.lease)
        if answer.status_code == 200:
            return True
        assert "not yet in phase" in answer.json()["detail"]  # the machine was held up just now
        return False

    def begin(self, motion: dict[str, Any]) -> str:
        """Begin a motion and return the path of its session, once it is being recorded."""
        answer = self.client.post(f"{DRIVE}/motions", json=motion, headers=self.lease)
        assert answer.status_code == 201, answer.text
        path = answer.headers["location"]
        until(lambda: self.client.get(path).json()["tick"] > 0)
        return path


@pytest.fixture
def operator(anyone: httpx.Client) -> Iterator[Operator]:
    with Operator(anyone) as operator:
        yield operator


def found(findings: dict[str, Any], *taken: dict[str, Any]) -> dict[str, Any]:
    """Return a document as this server would have written it."""
    path = data_root() / "commissioning.key"
    document = {"link": "Virtual drive", "serials": [1, 2, 3, 4, 5, 6]}
    record = CommissioningRecord.model_validate(
        document | {"findings": findings, "taken": list(taken)}
    )
    key = seal.read_key(path) or seal.make_key(path)
    return seal.sealed(record, key).model_dump(mode="json")


def ended(client: httpx.Client, path: str) -> dict[str, Any]:
    """Return a session that has come to its end."""
    until(lambda: client.get(path).json()["state"] in {"finished", "stopped"})
    until(lambda: client.get(path).json()["run"] is not None)
    return client.get(path).json()


def kept(client: httpx.Client, run: str) -> dict[str, Any]:
    """Return a run whose recording is complete."""
    until(lambda: client.get(f"{API}/runs/{run}").json()["state"] == "complete")
    return client.get(f"{API}/runs/{run}").json()


def test_a_motion_is_recorded_as_a_run_on_drives(operator: Operator, anyone: httpx.Client) -> None:
    operator.arm()
    path = operator.begin(MOTION | {"set": SHORT | {"schedule": SCHEDULE}})
    for call, body in (
        ("play", {}),
        ("pause", None),
        ("step", {"ticks": 1}),
        ("reset", None),
        ("undo", None),
        ("push", {"axis": "x", "force": 1.0}),
    ):
        assert anyone.post(f"{path}/{call}", json=body).status_code == 409, call
    changes = {"set": {"variants.B.controller.x.k_p": 2.1e5}}
    refused = anyone.patch(f"{path}/parameters", json=changes)
    assert refused.json()["detail"] == "'operator' controls the drives: take control first"
    mass = {"set": {"plant.x.mass": 3.0}}
    refused = anyone.patch(f"{path}/parameters", json=mass, headers=operator.lease)
    assert (refused.status_code, refused.json()["errors"][0]["loc"]) == (422, "set.plant.x.mass")
    answer = anyone.patch(f"{path}/parameters", json=changes, headers=operator.lease)
    assert answer.status_code == 200, answer.text
    changed = {"tick": answer.json()["tick"], **changes}
    assert changed["tick"] > 0
    again = anyone.post(f"{DRIVE}/motions", json=MOTION, headers=operator.lease)
    assert again.json()["detail"] == "not possible while the link is moving"
    session = ended(anyone, path)
    assert session["state"] == "finished", anyone.get(DRIVE).json()["fault"]
    assert session["drive"] == "Virtual drive"
    run = kept(anyone, session["run"])
    assert (run["kind"], run["name"]) == (
        "drive",
        "circle B on Virtual drive, k_p x 210 N/mm, radius 2 mm and 4 more",
    )
    assert run["ticks"] == session["ends"]
    assert [{key: event[key] for key in changed} for event in run["events"]] == [changed]
    assert [{key: change[key] for key in changed} for change in session["changes"]] == [changed]
    assert changes["set"].keys() <= {each["path"] for each in run["differences"]}
    assert 0 < run["metrics"]["B.x.max_abs_following_error"] < 100e-6
    for metrics in (run["result"], anyone.get(f"{path}/metrics").json()):
        found = metrics["variants"]["B"]["axes"]["x"]
        assert found["max_current"] > 0.1
        assert found["max_abs_position_error"] is found["max_abs_force"] is None
    listed = anyone.get(f"{API}/runs", params={"q": "kind:drive"}).json()["runs"]
    assert run["id"] in {each["id"] for each in listed}
    refused = anyone.post(f"{API}/runs/{run['id']}/replay")
    assert "measured on drives" in refused.json()["detail"]
    check_the_schedule(anyone, run)
    names = [f"B.x.{name}" for name in (*SIMULATED_ONLY, "following_error")]
    text = anyone.get(
        f"{API}/runs/{run['id']}/telemetry", params={"format": "csv", "columns": ",".join(names)}
    ).text
    *_, row = csv.DictReader(text.splitlines())
    last = {name.partition(" ")[0]: value for name, value in row.items()}
    assert {last[f"B.x.{name}"] for name in SIMULATED_ONLY} <= {"", "nan", "NaN"}
    assert abs(float(last["B.x.following_error"])) < 100e-6


def check_the_schedule(client: httpx.Client, run: dict[str, Any]) -> None:
    """Hold a run against the simulation of its scenario, with its schedule and its changes."""
    scenario, path = run["scenario_document"], f"{API}/runs/{run['id']}/telemetry"
    assert [event["set"] for event in scenario["schedule"]] == list(OF_B)
    (change,) = run["events"]
    assert change["tick"] < FIRST
    made = {"time": change["tick"] * run["period"], "set": change["set"]}
    simulated = play(scenario | {"schedule": [*scenario["schedule"], made]})
    names = ("following_error", "pd_force")
    columns = {"format": "csv", "columns": ",".join(f"B.x.{name}" for name in names)}
    table = client.get(path, params=columns).text.splitlines()
    recorded = np.genfromtxt(table, delimiter=",", skip_header=1)[:, -2:].T
    expected = np.stack([simulated.channel("B", name, "x") for name in names])
    for error, force in (recorded, expected):
        proportional = np.isclose(force, change["set"][f"{GAINS}.k_p"] * error, rtol=1e-4)
        assert (proportional | np.isnan(error))[FIRST:SECOND].all()
        assert not proportional[[FIRST - 1, SECOND]].any()
    for first, end in ((FIRST // 2, FIRST), (FIRST, SECOND), (SECOND, run["ticks"])):
        found, simulated_rms = (
            np.sqrt(np.nanmean(values[0, first:end] ** 2)) for values in (recorded, expected)
        )
        assert found == pytest.approx(simulated_rms, rel=0.2)


@pytest.mark.parametrize("how", ["drive", "session"])
def test_anyone_stops_a_motion(operator: Operator, anyone: httpx.Client, how: str) -> None:
    operator.arm()
    path = operator.begin(LONG)
    for call in ("disarm", "reset", "motions", "arm"):
        answer = anyone.post(
            f"{DRIVE}/{call}", json={**MOTION, "confirm": True}, headers={"Lease": "not it"}
        )
        assert answer.status_code in {409, 422}, call
    assert anyone.get(DRIVE).json()["state"] == "moving"
    stop = f"{DRIVE}/stop?by=Eve%0A" if how == "drive" else f"{path}/stop"
    assert anyone.post(stop).status_code == 200
    status = operator.until(lambda status: status["state"] in {"ready", "fault"})
    assert status["state"] == "ready", status["fault"]
    cause, by = ("STOP", "Eve") if how == "drive" else ("STOP of the session", "")
    assert {**status["stopped"], "at": 0} == {"at": 0, "cause": cause, "by": by}
    session = ended(anyone, path)
    assert session["state"] == "stopped"
    events = kept(anyone, session["run"])["events"]
    assert [event["kind"] for event in events] == ["stop"]
    answer = anyone.post(f"{DRIVE}/motions", json=MOTION, headers=operator.lease)
    assert answer.json()["detail"] == "not possible while the link is ready"  # never by itself


@pytest.mark.parametrize("first", ["drive", "session"])
def test_a_stop_of_drive_and_session_has_its_name(
    operator: Operator, anyone: httpx.Client, first: str
) -> None:
    operator.arm()
    path = operator.begin(LONG)
    calls = [f"{DRIVE}/stop?by=Eve", f"{path}/stop"]
    for call in calls if first == "drive" else reversed(calls):
        assert anyone.post(call).status_code == 200
    status = operator.until(lambda status: status["state"] in {"ready", "fault"})
    assert (status["stopped"]["cause"], status["stopped"]["by"]) == ("STOP", "Eve")


def test_a_session_that_is_deleted_is_noted_as_the_stop(
    operator: Operator, anyone: httpx.Client
) -> None:
    operator.arm()
    path = operator.begin(LONG)
    assert anyone.delete(path).status_code == 204
    status = operator.until(lambda status: status["state"] in {"ready", "fault"})
    assert status["stopped"]["cause"] == "end of the session"


def test_who_falls_silent_is_stopped_then_free(operator: Operator, anyone: httpx.Client) -> None:
    operator.arm()
    path = operator.begin(LONG)
    operator.fall_silent()
    status = operator.until(lambda status: status["state"] != "moving")
    assert status["state"] in {"stopping", "ready"}, status["fault"]
    assert ended(anyone, path)["state"] == "stopped"
    operator.until(lambda status: status["state"] == "ready" and status["holder"] is None)


def test_the_command_line(
    anyone: httpx.Client, linked_server: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ["--server", linked_server.url]
    changes = [f"--set={path}={value}" for path, value in SHORT.items()]
    run = ["drive", "run", "circle", "--variant", "B", *changes]
    with Operator(anyone) as operator:
        operator.arm()
        assert main([*run, "--arm", *at]) == FAILED
        assert "'operator' controls the drives" in capsys.readouterr().err
        assert main(["drive", "disarm", *at]) == FAILED
        path = operator.begin(LONG)
        assert main(["drive", "stop", *at]) == DONE  # without the lease
        assert ended(anyone, path)["state"] == "stopped"
    operator.until(lambda status: status["holder"] is None and status["state"] == "ready")
    assert main([*run, *at]) == FAILED
    assert "while the link is ready" in capsys.readouterr().err
    assert main([*run, "--arm", "--json", *at]) == DONE
    told = json.loads(capsys.readouterr().out)
    assert told["state"] == "finished"
    assert kept(anyone, told["run"])["kind"] == "drive"
    operator.until(lambda status: status["state"] == "ready" and status["holder"] is None)
    assert main(["drive", "status", *at]) == DONE
    assert capsys.readouterr().out.startswith("Virtual drive (virtual drive): ready\n")
    assert main(["drive", "reset", *at]) == DONE
    nowhere = ["--server", "http://127.0.0.1:9"]
    assert main(["drive", "stop", *nowhere]) == FAILED
    assert "does not answer" in capsys.readouterr().err


@pytest.mark.realtime
def test_gains_are_tuned_on_the_drives(
    anyone: httpx.Client,
    linked_server: Server,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with Operator(anyone) as operator:  # and so the drives are up
        operator.until(lambda status: status["state"] == "ready")
    answers = iter(["y", "y", "n"])
    monkeypatch.setattr("builtins.input", lambda _: next(answers))
    line = ["drive", "tune", "circle", "--axis", "x", "--server", linked_server.url]
    changes = [f"--set={path}={value}" for path, value in SHORT.items()]
    assert main([*line, *changes]) == DONE
    out = capsys.readouterr().out
    assert out.count("\nrun r-") == 2
    assert "beyond every motion made" in out
    assert "best so far:" in out
    operator.until(lambda status: status["state"] == "ready" and status["holder"] is None)


def test_the_example_runs_a_then_b(operator: Operator, linked_server: Server) -> None:
    operator.arm()  # and so the drives are up
    operator.fall_silent()
    operator.client.delete(f"{DRIVE}/lease", headers=operator.lease)
    operator.until(lambda status: status["state"] == "ready" and status["holder"] is None)
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "drive_ab.py"],
        env=os.environ | {"LAB": linked_server.url, "CHANGES": json.dumps(SHORT)},
        capture_output=True,
        text=True,
        check=True,
    )
    first, second = done.stdout.splitlines()
    assert first.startswith("A finished: largest error on x ")
    assert second.startswith("B finished: largest error on x ")


def test_changes_that_are_taken_bring_the_link_up_with_them(
    operator: Operator,
    anyone: httpx.Client,
    linked_server: Server,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    place = f"{DRIVE}/commissioning"
    operator.arm()
    change = {"path": "x.offset", "now": 0.0, "then": 0.0012}
    load: dict[str, Any] = {"json": found({}, change), "headers": operator.lease}
    assert "while the link is holding" in anyone.put(place, **load).json()["detail"]
    anyone.post(f"{DRIVE}/disarm", headers=operator.lease)
    before = operator.until(lambda status: status["state"] == "ready")["axes"][0]["position"]
    wrong = anyone.post(f"{place}/encoders/changes", json=[change], headers=operator.lease)
    assert "not the changes that" in wrong.json()["detail"]
    assert anyone.put(place, **load).json()["record"]["taken"] == [change]
    status = operator.until(lambda status: status["state"] == "ready")
    assert status["axes"][0]["position"] - before == pytest.approx(0.0012, abs=20e-6)
    file = tmp_path / "drive.toml"
    file.write_text(anyone.get(f"{DRIVE}/configuration").text)
    assert load_drive(file).x.offset == 0.0012
    document = {"link": "Virtual drive", "findings": {}}
    assert anyone.put(place, json=document, headers=operator.lease).json()["record"]["taken"] == []
    status = operator.until(lambda status: status["state"] == "ready")
    assert status["axes"][0]["position"] == pytest.approx(before, abs=20e-6)

    wrong = {"at": 0.0, "holds": False, "text": "x: offset wrong", "changes": [change]}
    document = found(dict.fromkeys((*BEFORE, "currents"), DONE_BEFORE) | {"commutation": wrong})
    anyone.put(place, json=document, headers=operator.lease)
    operator.fall_silent()
    operator.until(lambda status: status["holder"] is None)
    at = ["--server", linked_server.url]
    assert main(["drive", "commission", "currents", "--take", *at]) == FAILED
    assert "Phase currents, one by one shows no change to take" in capsys.readouterr().err
    assert main(["drive", "commission", "commutation", "--take", *at]) == DONE
    assert capsys.readouterr().out == "taken: x.offset 0 -> 0.0012\n"
    status = anyone.get(DRIVE).json()
    assert status["state"] == "ready"
    assert status["axes"][0]["position"] - before == pytest.approx(0.0012, abs=20e-6)
    assert main(["drive", "commission", "commutation", "--take", *at]) == FAILED
    assert main(["drive", "commission", "nothing", "--take", *at]) == BAD_INPUT
    assert "is none of drives, identity" in capsys.readouterr().err


def test_steps_with_torque(
    operator: Operator,
    anyone: httpx.Client,
    linked_server: Server,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(currents, "RAMP", 0.05)
    monkeypatch.setattr(currents, "HOLD", 0.1)
    place, step = f"{DRIVE}/commissioning", f"{DRIVE}/commissioning/currents"
    operator.arm()
    anyone.post(f"{DRIVE}/disarm", headers=operator.lease)
    operator.until(lambda status: status["state"] == "ready" and status["loop"]["phase_locked"])
    document = found(dict.fromkeys(BEFORE, DONE_BEFORE))
    loaded = anyone.put(place, json=document, headers=operator.lease).json()
    assert [each["state"] for each in loaded["steps"]][2:5] == ["done", "now", "waiting"]
    for body in (None, {}, {"confirm": False}, {"confirm": 1}, {"confirm": "true"}):
        answer = anyone.post(step, json=body, headers=operator.lease)
        assert answer.status_code == 422, body
        assert "confirm" in answer.json()["errors"][0]["loc"]

    confirmed = {"json": {"confirm": True}, "headers": operator.lease}
    until(lambda: anyone.post(step, **confirmed).status_code == 200)
    for call in ("arm", "motions", "reset", "commissioning/drives"):
        body = None if call in {"reset", "commissioning/drives"} else MOTION
        body = body and body | ({"confirm": True} if call == "arm" else {})
        answer = anyone.post(f"{DRIVE}/{call}", json=body, headers=operator.lease)
        assert "while the step currents goes on" in answer.json()["detail"], call
    operator.until(lambda status: status["state"] == "testing")
    assert anyone.post(f"{DRIVE}/stop").status_code == 200
    until(lambda: anyone.get(place).json()["running"] is None)
    assert anyone.get(DRIVE).json()["state"] == "ready"
    finding = anyone.get(place).json()["steps"][3]["finding"]
    assert (finding["holds"], finding["text"]) == (False, "ended before its end: STOP")

    until(lambda: anyone.post(step, **confirmed).status_code == 200)
    operator.until(lambda status: status["state"] == "testing")
    operator.fall_silent()
    operator.until(lambda status: status["holder"] is None)
    told = anyone.get(place).json()["steps"][3]["finding"]["text"]
    assert told == "ended before its end: control of the drives ended"
    assert anyone.get(DRIVE).json()["state"] == "ready"

    at = ["--server", linked_server.url]
    assert main(["drive", "commission", "nothing", "--confirm", *at]) == BAD_INPUT
    assert "is none of drives, identity" in capsys.readouterr().err
    assert main(["drive", "commission", "homing", "--confirm", *at]) == FAILED
    assert "Phase currents, one by one comes first" in capsys.readouterr().err
    operator.until(lambda status: status["holder"] is None)
    assert main(["drive", "commission", "currents", "--confirm", *at]) == DONE
    assert "all 6 follow, each alone" in capsys.readouterr().out
    assert main(["drive", "commission", *at]) == DONE
    told = capsys.readouterr().out
    assert "4 currents     Phase currents, one by one" in told
    assert "5 commutation  Commutation offset         torque now" in told


def test_friction_is_identified_from_a_recorded_run(
    operator: Operator, anyone: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(friction_step, "SPEEDS", (0.01, 0.03, 0.06))
    monkeypatch.setattr(friction_step, "DISTANCES", (0.003, 0.006, 0.012))
    place = f"{DRIVE}/commissioning"
    operator.arm()
    anyone.post(f"{DRIVE}/disarm", headers=operator.lease)
    operator.until(lambda status: status["state"] == "ready" and status["loop"]["phase_locked"])
    before = (*BEFORE, "currents", "commutation", "homing", "hold")
    document = found(dict.fromkeys(before, DONE_BEFORE))
    anyone.put(place, json=document, headers=operator.lease)
    confirmed = {"json": {"confirm": True}, "headers": operator.lease}
    until(lambda: anyone.post(f"{place}/friction", **confirmed).status_code == 200)
    until(lambda: anyone.get(place).json()["running"] is None)
    finding = anyone.get(place).json()["steps"][7]["finding"]
    assert finding["run"], finding["text"]
    run = kept(anyone, finding["run"])
    assert run["kind"] == "drive"
    assert {f"{axis} {name}" for axis in "xy" for name in ("F_c", "F_s", "v_s", "sigma_2")} == {
        row["name"] for row in finding["rows"]
    }
    (stiction,) = (row for row in finding["rows"] if row["name"] == "x F_s")
    assert float(stiction["found"].split()[0]) == pytest.approx(3.59, rel=0.02)
    assert stiction["expected"] == "3.591 N"
    assert anyone.get(DRIVE).json()["state"] == "ready"


@pytest.mark.realtime
def test_a_response_is_measured_from_a_recorded_run_of_each_axis(
    operator: Operator, anyone: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shaking, "SLIDES", 8)  # 5, and some to spare: cycles may be late
    monkeypatch.setattr(shaking, "LOWEST", 5.0)
    place = f"{DRIVE}/commissioning"

    def running() -> Any:
        return anyone.get(place).json()["running"]

    operator.arm()
    anyone.post(f"{DRIVE}/disarm", headers=operator.lease)
    operator.until(lambda status: status["state"] == "ready" and status["loop"]["phase_locked"])
    before = (*BEFORE, "currents", "commutation", "homing", "hold", "friction")
    anyone.put(place, json=found(dict.fromkeys(before, DONE_BEFORE)), headers=operator.lease)
    confirmed = {"json": {"confirm": True}, "headers": operator.lease}
    until(lambda: anyone.post(f"{place}/response", **confirmed).status_code == 200)
    until(lambda: running() is None or "y: " in str(running()))
    until(lambda: running() is None)
    finding = anyone.get(place).json()["steps"][8]["finding"]
    assert finding["run"] and finding["holds"], finding["text"]
    assert kept(anyone, finding["run"])["kind"] == "drive"
    rows = {row["name"]: row for row in finding["rows"]}
    for axis in "xy":
        row = rows[f"{axis} crossover"]
        here, there = (float(row[key].split()[0]) for key in ("found", "expected"))
        assert here == pytest.approx(there, rel=0.05)
        row = rows[f"{axis} mass"]
        here, there = (float(row[key].split()[0]) for key in ("found", "expected"))
        assert here == pytest.approx(there, rel=0.03)
    assert not any("mode" in name for name in rows)
    assert anyone.get(DRIVE).json()["state"] == "ready"


def test_a_document_that_was_forged_is_refused(operator: Operator, anyone: httpx.Client) -> None:
    place = f"{DRIVE}/commissioning"
    operator.arm()
    anyone.post(f"{DRIVE}/disarm", headers=operator.lease)
    operator.until(lambda status: status["state"] == "ready")
    true = found(dict.fromkeys(BEFORE, DONE_BEFORE))
    assert anyone.put(place, json=true, headers=operator.lease).status_code == 200
    kept = anyone.get(place).json()["record"]
    change = {"path": "x.offset", "now": 0.0, "then": 0.05}
    for forged in (
        {key: value for key, value in true.items() if key != "seal"},
        true | {"taken": [change]},
        true | {"findings": dict.fromkeys(ORDER, DONE_BEFORE)},
        true | {"serials": [1, 2, 3, 4, 5, 7]},
    ):
        answer = anyone.put(place, json=forged, headers=operator.lease)
        assert answer.status_code == 422
        assert answer.json()["errors"][0]["loc"] == "seal"
    assert anyone.get(place).json()["record"] == kept
    assert anyone.get(DRIVE).json()["axes"][0]["limits"]["offset"] == 0.0


def test_what_a_loop_that_stands_still_says_has_its_age(
    operator: Operator, anyone: httpx.Client
) -> None:
    operator.arm()
    assert anyone.get(DRIVE).json()["known"]
    loops = children_of(os.getpid(), "motionlab.drive.link.process")
    try:
        for loop in loops:
            os.kill(loop, signal.SIGSTOP)
        status = operator.until(lambda status: not status["known"])
        later = operator.until(lambda now: now["age"] > status["age"] + 0.5)
        assert later["loop"]["age"] == pytest.approx(later["age"], abs=1e-3)
    finally:
        for loop in loops:
            os.kill(loop, signal.SIGCONT)
    operator.until(lambda status: status["known"] and status["state"] in {"fault", "ready"})


def test_drives_of_another_identity(virtual: VirtualDrive) -> None:
    config = linked(virtual)
    first, *others = config.nodes
    stranger = first.model_copy(update={"product": 0x5002})
    server = Server(Settings(drive=config.model_copy(update={"nodes": (stranger, *others)})))
    try:
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
            until(lambda: client.get(DRIVE).json()["problem"] != "")
            status = client.get(DRIVE).json()
    finally:
        server.stop()
    assert status["problem"] == "nodes.0.product: drive 1 is 0x5001, 0x5002 expected"
    answers = [drive["answers"]["product"] for drive in status["drives"]]
    assert answers == 6 * [0x5001]
    assert status["drives"][0]["product"] == 0x5002
    assert status["state"] == "offline"
