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

import httpx
import pytest

from motionlab.own_laws.template import template
from tests.library.served import API, PATIENCE, SERVE

MINE = template("mine")
LAW = {"variants.B.controller.compensation.law": "mine"}
HALF = MINE.replace("seen.friction.F_c", "0.5 * seen.friction.F_c")


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

    def error(self) -> float:
        body = {"scenario": "circle", "set": LAW | {"trajectory.laps": 1}}
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
    lab.save(MINE.replace("seen.friction.F_c", "seen.friction.F_c + 2e4 * seen.error"))
    for _ in range(4):
        curves, loop = answers()
        assert curves != whole[0]
        assert loop != whole[1]


def test_a_session_that_plays_has_it_from_a_tick_on(lab: Lab) -> None:
    played = lab.client.post(f"{API}/sessions", json={"scenario": "circle"}).headers["location"]
    lab.client.patch(f"{played}/parameters", json={"set": LAW}).raise_for_status()
    estimate = "B.x.friction_estimate"

    def last() -> float:
        lab.client.post(f"{played}/step", json={"ticks": 400}).raise_for_status()
        query = {"format": "csv", "columns": estimate}
        text = lab.client.get(f"{played}/telemetry", params=query).raise_for_status().text
        return abs(float(text.splitlines()[-1].split(",")[-1]))

    whole = last()
    while not 0.2 < (whole := last()) < 1.0:
        pass
    lab.save(HALF)
    assert last() == pytest.approx(0.5 * whole, rel=1e-5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (MINE.replace("Estimate(", "Estimate(("), "SyntaxError"),
        (MINE.replace("seen.friction.F_c", "seen.v / seen.v"), "nan"),
        (MINE.replace('"1", default=1', '"1", default=0.5'), "restart the server to take it"),
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
