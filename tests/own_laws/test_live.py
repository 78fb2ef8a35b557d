"""A law of one's own whose file changes while a server runs: live again, or the former version."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import ANY

import httpx
import pytest

from motionlab.own_laws.template import template
from tests.library.served import API, PATIENCE, SERVE

MINE = template("mine")
LAW = {"variants.B.controller.compensation.law": "mine"}
SELECT = "    force = select(seen.v_ref > 0.0, force, select(seen.v_ref < 0.0, -force, 0.0))"
HALF = MINE.replace("seen.friction.F_c", "0.5 * seen.friction.F_c")


COUNTER = MINE.replace('"mine"', '"counter"').replace(
    "@compiled",
    """class State(NamedTuple):
    n: Lanes  # ticks
    kept: Lanes  # ticks

@compiled""",
)
COUNTER = COUNTER.replace(SELECT, "    force = 1e-3 * state.n + 1e-6 * state.kept")
COUNTER = COUNTER.replace(", state  #", ", State(state.n + 1.0, state.kept + 1.0)  #")
COUNTER = COUNTER.replace("step=", "State=State, step=")


class Lab:
    """A server with a folder of laws, and a session whose controller B has one of them."""

    def __init__(self, client: httpx.Client, folder: Path) -> None:
        self.client = client
        self.file = folder / "mine.py"
        answer = client.post(f"{API}/sessions", json={"scenario": "circle"}).raise_for_status()
        self.session = answer.headers["location"]
        client.patch(f"{self.session}/parameters", json={"set": LAW}).raise_for_status()

    def events(self) -> list[dict[str, Any]]:
        events = self.client.get(self.session).raise_for_status().json()["events"]
        return [each for each in events if each["kind"] == "law"]

    def entry(self) -> dict[str, Any]:
        laws = self.client.get(f"{API}/laws").raise_for_status().json()["laws"]
        return next(law for law in laws if law["name"] == "mine")

    def move(self, where: str) -> httpx.Response:
        return self.client.post(f"{API}/laws/mine/{where}", headers={"Person": "Anna"})

    def played(self, law: str, ticks: int = 400) -> str:
        """Return the address of another session, after some ticks with a law in B."""
        address = self.client.post(f"{API}/sessions", json={"scenario": "circle"})
        place = address.headers["location"]
        change = {"variants.B.controller.compensation.law": law}
        self.client.patch(f"{place}/parameters", json={"set": change}).raise_for_status()
        self.client.post(f"{place}/step", json={"ticks": ticks}).raise_for_status()
        return place

    def last(self, session: str, column: str) -> float:
        """Return the latest sample of a session."""
        query = {"format": "csv", "columns": column}
        answer = self.client.get(f"{session}/telemetry", params=query).raise_for_status()
        return float(answer.text.splitlines()[-1].split(",")[-1])

    def error(self, law: str = "mine") -> float:
        change = {"variants.B.controller.compensation.law": law}
        body = {"scenario": "circle", "set": change | {"trajectory.laps": 1}}
        answer = self.client.post(f"{API}/simulate", json=body).raise_for_status().json()
        return answer["variants"]["B"]["axes"]["x"]["max_abs_following_error"]

    def save(self, text: str) -> dict[str, Any]:
        """Save the file, wait for what comes of it, and return that event."""
        before = len(self.events())
        self.file.write_text(text)
        until(lambda: len(self.events()) > before)
        return self.events()[-1]


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder, data = tmp_path_factory.mktemp("laws"), tmp_path_factory.mktemp("data")
    (folder / "mine.py").write_text(MINE)
    (folder / "counter.py").write_text(COUNTER)
    (folder / "bad.py").write_text(template("bad").replace("seen.friction.F_c", "seen.v / seen.v"))
    (folder / "broken.py").write_text("while True: pass\n1 +\n")
    environment = os.environ | {"MOTIONLAB_DATA": str(data)}
    told = data / "stderr.txt"
    with told.open("wb") as stderr:
        command = [sys.executable, *SERVE, "--laws", str(folder)]
        process = subprocess.Popen(command, env=environment, stderr=stderr)
    try:
        until(lambda: "Serving" in told.read_text() or process.poll() is not None)
        url = re.search(r"Serving (http://[0-9.:]+)", told.read_text())
        assert url is not None, told.read_text()
        with httpx.Client(base_url=url[1], timeout=PATIENCE, trust_env=False) as client:
            yield Lab(client, folder)
    finally:
        process.terminate()
        process.wait(60)


@pytest.fixture(autouse=True)
def as_before(lab: Lab) -> Iterator[None]:
    """Give each test the law as it was first."""
    yield
    if lab.entry()["text"] != MINE or lab.entry()["problem"]:
        lab.file.write_text(MINE)
        until(lambda: lab.entry()["text"] == MINE and not lab.entry()["problem"])


def test_a_broken_file_is_named_and_the_others_are_taken(lab: Lab) -> None:
    bad, broken = lab.client.get(f"{API}/laws").json()["refused"]
    assert "broken.py:2: broken: SyntaxError" in broken
    assert "bad.py: bad: gives a force that is nan" in bad
    law = {"variants.B.controller.compensation.law": "bad"}  # nor do workers have it
    answer = lab.client.post(f"{API}/simulate", json={"scenario": "circle", "set": law})
    assert answer.status_code == 422
    assert lab.entry()["own"] and lab.entry()["file"] == "mine.py"
    assert lab.entry()["text"] == MINE


def test_a_new_version_is_live_in_sessions_and_in_what_ifs_and_so_is_the_former(lab: Lab) -> None:
    whole = lab.error()
    event = lab.save(HALF)
    assert (event["law"], event["reason"]) == ("mine", "")
    assert lab.entry()["text"] == HALF
    half = lab.error()
    assert half > whole
    lab.save(MINE)
    assert lab.error() == whole


def test_no_exact_what_if_and_no_margins_of_the_former_version_are_kept(lab: Lab) -> None:
    """Feedback in the law: its text decides both, and nothing else of the question does."""
    exact = {"scenario": "circle", "set": LAW, "columns": ["B.x.following_error"], "exact": True}

    def answers() -> tuple[bytes, Any]:
        curves = lab.client.post(f"{API}/whatif", json=exact).raise_for_status().content
        loop = lab.client.post(f"{API}/loop", json={"scenario": "circle", "set": LAW}).json()
        return curves, loop["variants"]["B"]

    whole, *_ = [answers() for _ in range(4)]  # from every worker
    event = lab.save(MINE.replace("seen.friction.F_c", "seen.friction.F_c + 2e4 * seen.error"))
    assert event["reason"] == ""
    for _ in range(4):
        curves, loop = answers()
        assert curves != whole[0]
        assert loop != whole[1]


def test_a_session_has_it_from_a_tick_on_and_the_event_has_the_jump_in_force(lab: Lab) -> None:
    estimate = "B.x.friction_estimate"
    session = lab.played("mine")
    while not 0.2 < abs(whole := lab.last(session, estimate)) < 1.0:
        lab.client.post(f"{session}/step", json={"ticks": 400}).raise_for_status()
    lab.save(HALF)
    event = lab.client.get(session).json()["events"][-1]
    assert event["jump"] == {"B": {"x": pytest.approx(-0.5 * whole, rel=1e-4), "y": ANY}}
    assert event["version"] == lab.entry()["version"]
    lab.client.post(f"{session}/step", json={"ticks": 1}).raise_for_status()
    assert lab.last(session, estimate) == pytest.approx(0.5 * whole, rel=1e-5)
    assert lab.client.get(session).json()["tick"] == event["tick"] + 1


def test_what_a_law_resets_begins_at_zero_and_the_rest_stays(lab: Lab) -> None:
    session = lab.played("counter", 1000)
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(0.999 + 0.000999)
    file = lab.file.with_name("counter.py")
    file.write_text(COUNTER.replace("State=State,", 'State=State, resets=("n",),'))
    until(lambda: lab.client.get(session).json()["events"][-1]["kind"] == "law")
    jump = lab.client.get(session).json()["events"][-1]["jump"]["B"]
    assert jump == {"x": pytest.approx(-1.0, rel=1e-4), "y": pytest.approx(-1.0, rel=1e-4)}
    lab.client.post(f"{session}/step", json={"ticks": 1}).raise_for_status()
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(0.001, rel=1e-4)


def test_back_and_forward_take_versions_without_the_file(lab: Lab) -> None:
    first = lab.entry()
    whole = lab.error()
    lab.save(HALF)
    half = lab.error()
    answer = lab.move("back").raise_for_status().json()
    assert (answer["text"], answer["newer"]) == (MINE, True)
    assert answer["version"] == answer["versions"] - 1 >= 1
    assert lab.file.read_text() == HALF
    assert lab.error() == whole
    event = lab.events()[-1]
    assert (event["by"], event["version"], event["reason"]) == ("Anna", answer["version"], "")
    while lab.move("back").is_success:
        pass
    refused = lab.move("back")
    assert (refused.status_code, lab.entry()["version"]) == (409, 1)
    assert "version 1 of law mine is the first" in refused.json()["detail"]
    while lab.move("forward").is_success:
        pass
    assert lab.entry()["text"] == HALF and not lab.entry()["newer"]
    assert lab.error() == half
    lab.move("back").raise_for_status()
    event = lab.save(HALF)  # takes the file again
    assert event["version"] == lab.entry()["versions"]
    assert lab.entry()["text"] == HALF and first["own"]


@pytest.mark.parametrize("name", ["residual-k", "mine@before", "no-law"])
def test_only_laws_of_files_that_are_watched_go_back(lab: Lab, name: str) -> None:
    assert lab.client.post(f"{API}/laws/{name}/back").status_code == 404


def test_the_version_before_runs_beside_the_present_one(lab: Lab) -> None:
    whole = lab.error()
    assert lab.save(HALF)["reason"] == ""
    assert lab.entry()["before"] == "mine@before"
    assert lab.error("mine@before") == whole != lab.error()
    session = lab.played("mine", 1)
    old = {"variants.A.controller.compensation.law": "mine@before"}
    lab.client.patch(f"{session}/parameters", json={"set": old}).raise_for_status()
    lab.client.post(f"{session}/step", json={"ticks": 800}).raise_for_status()
    before = lab.last(session, "A.x.friction_estimate")
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(0.5 * before, rel=1e-5)
    lab.save(HALF.replace("0.5 *", "0.25 *"))  # A becomes what B was
    jump = lab.client.get(session).json()["events"][-1]["jump"]
    assert jump["A"]["x"] == pytest.approx(-0.5 * before, rel=1e-3)
    assert jump["B"]["x"] == pytest.approx(-0.25 * before, rel=1e-3)


def test_a_recording_keeps_the_texts_of_both(lab: Lab) -> None:
    lab.save(HALF)
    session = lab.played("mine")
    old = {"variants.A.controller.compensation.law": "mine@before"}
    lab.client.patch(f"{session}/parameters", json={"set": old}).raise_for_status()
    lab.client.post(f"{session}/step", json={"ticks": 100}).raise_for_status()
    quarter = HALF.replace("0.5 *", "0.25 *")
    lab.save(quarter)
    lab.client.post(f"{session}/step", json={"ticks": 100}).raise_for_status()
    run = lab.client.get(session).json()["run"]
    lab.client.delete(session).raise_for_status()
    until(lambda: lab.client.get(f"{API}/runs/{run}").json().get("state") != "recording")
    events = lab.client.get(f"{API}/runs/{run}").json()["events"]
    texts = [each["texts"] for each in events if each["texts"]]
    assert texts == [
        {"mine": HALF},
        {"mine@before": MINE},
        {"mine": quarter, "mine@before": HALF},
    ]


def test_a_law_costs_time_and_a_version_is_measured_anew(lab: Lab) -> None:
    cost = lab.client.get(f"{API}/laws/mine/cost").raise_for_status().json()
    assert 0.0 <= cost["ns"] < 1e5
    assert cost["share"] == pytest.approx(1e-9 * cost["ns"] / 5e-4, abs=1e-6)
    assert lab.entry()["cost"] == cost
    lab.save(HALF)
    assert lab.entry()["cost"] is None
    lab.move("back").raise_for_status()
    assert lab.entry()["cost"] == cost
    assert lab.client.get(f"{API}/laws/none/cost").status_code == 404


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (MINE.replace("Estimate(", "Estimate(("), "SyntaxError"),
        (MINE.replace("seen.friction.F_c", "seen.v / seen.v"), "nan"),
        (MINE.replace('"1", default=1', '"1", default=5'), "is outside of its range"),
        (MINE.replace("@compiled", "while True:\n    pass\n@compiled"), "an endless loop"),
        (f"import os\nos._exit(1)\n{MINE}", "ends the process that runs it"),
    ],
    ids=["syntax", "nan", "parameter", "loop", "exit"],
)
def test_what_cannot_be_taken_leaves_the_former_version(lab: Lab, text: str, reason: str) -> None:
    before = lab.error()
    event = lab.save(text)
    assert reason in event["reason"] and "mine.py" in event["reason"]
    assert reason in lab.entry()["problem"]
    assert lab.entry()["text"] == text
    assert lab.error() == before


def test_a_file_that_goes_leaves_the_law(lab: Lab) -> None:
    before = lab.error()
    lab.file.unlink()
    time.sleep(0.5)
    assert lab.error() == before
    assert lab.save(HALF)["reason"] == ""
