"""Laws of one's own whose declaration changes, and whose file is new, while a server runs."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.own_laws.template import template
from tests.library.served import API, PATIENCE
from tests.own_laws.with_laws import in_process, serving

ONE = template("mine")
COMPENSATION = "variants.B.controller.compensation"
LAW = {f"{COMPENSATION}.law": "mine"}
PARAMETER = 'OFFSET = Parameter("mine_offset", "Force", unit="N", default=0, ge=0, le=9)\nclass'
TWO = (
    ONE.replace("class", PARAMETER, 1)
    .replace(
        "    mine_share: Lanes  # 1", "    mine_offset: Lanes  # N\n    mine_share: Lanes  # 1"
    )
    .replace("    return Estimate(force,", "    return Estimate(force + par.mine_offset,")
    .replace("parameters=(SHARE,)", "parameters=(OFFSET, SHARE)")
)
STATE = "class State(NamedTuple):\n    {}\n\n@compiled"
COUNTS = (
    ONE.replace("@compiled", STATE.format("n: Lanes  # ticks"))
    .replace("return Estimate(force,", "return Estimate(1e-3 * state.n,")
    .replace(", state  #", ", State(state.n + 1.0)  #")
    .replace("step=", "State=State, step=")
)
COUNTS_TWO = (
    COUNTS.replace("    n: Lanes", "    m: Lanes  # ticks\n    n: Lanes")
    .replace("Estimate(1e-3 * state.n,", "Estimate(1e-3 * state.n + 1e-6 * state.m,")
    .replace("State(state.n + 1.0)", "State(state.m + 1.0, state.n + 1.0)")
)


class Lab:
    """A server with a folder of laws."""

    def __init__(self, client: httpx.Client, folder: Path) -> None:
        self.client, self.folder = client, folder
        self.session = self.began()

    def began(self, *changes: dict[str, Any]) -> str:
        """Return the address of another session."""
        answer = self.client.post(f"{API}/sessions", json={"scenario": "circle"})
        address = answer.raise_for_status().headers["location"]
        for change in changes:
            assert self.change(address, change).is_success
        return address

    def change(self, session: str, change: dict[str, Any]) -> httpx.Response:
        return self.client.patch(f"{session}/parameters", json={"set": change})

    def step(self, session: str, ticks: int = 400) -> None:
        self.client.post(f"{session}/step", json={"ticks": ticks}).raise_for_status()

    def compensation(self, session: str, which: str = "scenario") -> dict[str, Any]:
        info = self.client.get(session).raise_for_status().json()
        return info[which]["variants"]["B"]["controller"]["compensation"]

    def events(self) -> list[dict[str, Any]]:
        events = self.client.get(self.session).raise_for_status().json()["events"]
        return [each for each in events if each["kind"] == "law"]

    def save(self, text: str, file: str = "mine.py") -> dict[str, Any]:
        """Save a file, wait for what comes of it, and return that event."""
        before = len(self.events())
        (self.folder / file).write_text(text)
        until(lambda: len(self.events()) > before)
        return self.events()[-1]

    def last(self, session: str, column: str) -> float:
        query = {"format": "csv", "columns": column}
        answer = self.client.get(f"{session}/telemetry", params=query).raise_for_status()
        return float(answer.text.splitlines()[-1].split(",")[-1])

    def laws(self) -> dict[str, Any]:
        return self.client.get(f"{API}/laws").raise_for_status().json()

    def entry(self, name: str = "mine") -> dict[str, Any]:
        return next(law for law in self.laws()["laws"] if law["name"] == name)

    def fields(self) -> dict[str, Any]:
        fields = self.client.get(f"{API}/fields").raise_for_status().json()["fields"]
        start = "variants.*.controller.compensation."
        return {name[len(start) :]: each for name, each in fields.items() if name.startswith(start)}

    def error(self, **values: Any) -> float:
        """Return the largest following error of a run by a worker."""
        changes = {f"{COMPENSATION}.{name}": value for name, value in values.items()}
        body = {"scenario": "circle", "set": changes | {"trajectory.laps": 1}}
        answer = self.client.post(f"{API}/simulate", json=body).raise_for_status().json()
        return answer["variants"]["B"]["axes"]["x"]["max_abs_following_error"]


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("laws")
    (folder / "mine.py").write_text(ONE)
    (folder / "late.py").write_text("1 +\n")
    with serving(folder, tmp_path_factory.mktemp("data")) as client:
        yield Lab(client, folder)


@pytest.fixture(autouse=True)
def as_before(lab: Lab) -> Iterator[None]:
    """Give each test the law as it was first, and a session of its own."""
    lab.client.delete(lab.session).raise_for_status()
    lab.session = lab.began()
    yield
    (lab.folder / "mine.py").write_text(ONE)
    until(lambda: lab.entry()["text"] == ONE and not lab.entry()["problem"])
    time.sleep(0.5)  # its event follows: it is none of the next test


def test_a_parameter_is_added_in_sessions_workers_and_forms(lab: Lab) -> None:
    share = {f"{COMPENSATION}.mine_share": 0.5}
    session = lab.began(LAW, share)
    lab.step(session)
    kept = lab.last(session, "B.x.friction_estimate")
    event = lab.save(TWO)
    assert (event["law"], event["reason"]) == ("mine", "")
    assert lab.compensation(session)["mine_offset"] == 0.0
    assert lab.compensation(session)["mine_share"] == 0.5
    assert lab.compensation(session, "base")["mine_share"] == 1.0
    assert lab.fields()["mine_offset"]["bounds"] == {"minimum": 0, "maximum": 9}
    assert lab.fields()["mine_offset"]["used_with"] == ["mine"]
    lab.step(session, 1)
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(kept, rel=1e-2)
    assert lab.change(session, {f"{COMPENSATION}.mine_offset": 3.0}).is_success
    lab.step(session, 1)
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(kept + 3.0, rel=1e-2)
    assert lab.error(law="mine", mine_offset=3.0) != lab.error(law="mine")
    schemas = lab.client.get("/openapi.json").json()["components"]["schemas"]
    assert "mine_offset" in schemas["CompensationConfig"]["properties"]


def test_a_parameter_that_goes_is_no_field_any_more(lab: Lab) -> None:
    lab.save(TWO)
    session = lab.began(LAW, {f"{COMPENSATION}.mine_offset": 2.0})
    other = ONE.replace("F_c  # N", "F_c * 1.0  # N")
    assert lab.save(other)["reason"] == ""
    # The version before has it still.
    assert lab.fields()["mine_offset"]["used_with"] == ["mine@before"]
    assert lab.compensation(session)["mine_offset"] == 2.0
    assert lab.save(ONE)["reason"] == ""
    assert "mine_offset" not in lab.fields()
    assert "mine_offset" not in lab.compensation(session)
    lab.step(session)
    refused = lab.change(session, {f"{COMPENSATION}.mine_offset": 1.0})
    assert refused.status_code == 422 and "mine_offset: unknown key" in refused.text


def test_the_version_before_runs_with_the_parameters_of_its_own(lab: Lab) -> None:
    plain = lab.error(law="mine")
    lab.save(TWO)
    assert lab.error(law="mine@before", mine_offset=3.0) == plain
    assert lab.error(law="mine", mine_offset=3.0) != plain
    session = lab.began(LAW, {f"{COMPENSATION}.mine_offset": 3.0})
    lab.step(session)
    moved = lab.client.post(f"{API}/laws/mine/back").raise_for_status().json()
    assert moved["parameters"] == ["mine_share"]
    assert lab.error(law="mine") == plain
    lab.step(session, 1)
    back = lab.last(session, "B.x.friction_estimate")
    assert lab.client.post(f"{API}/laws/mine/forward").is_success
    assert lab.compensation(session)["mine_offset"] == 0.0  # it was none meanwhile
    lab.step(session, 1)
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(back, rel=1e-2)


def test_bounds_change_and_what_a_session_has_beyond_them_refuses_them(lab: Lab) -> None:
    narrow = ONE.replace("ge=0, le=2", "ge=0, le=1.2")
    session = lab.began(LAW, {f"{COMPENSATION}.mine_share": 1.5})
    event = lab.save(narrow)
    assert f"{COMPENSATION}.mine_share: is out of range as a session has it" in event["reason"]
    assert "got 1.5; allowed >= 0 and <= 1.2" in event["reason"] and "mine.py" in event["reason"]
    assert lab.fields()["mine_share"]["bounds"]["maximum"] == 2
    lab.step(session)
    assert lab.change(session, {f"{COMPENSATION}.mine_share": 1.1}).is_success
    assert lab.save(narrow.replace("F_c  # N", "F_c * 1.0  # N"))["reason"] == ""
    assert lab.compensation(session)["mine_share"] == 1.1
    assert lab.change(session, {f"{COMPENSATION}.mine_share": 1.5}).status_code == 422
    assert lab.save(ONE)["reason"] == ""
    assert lab.change(session, {f"{COMPENSATION}.mine_share": 1.5}).is_success
    back = lab.client.post(f"{API}/laws/mine/back")  # from which the session's value is too much
    assert back.status_code == 409 and "is out of range as a session has it" in back.text
    assert lab.change(session, {f"{COMPENSATION}.mine_share": 1.0}).is_success


def test_a_default_that_is_not_allowed_any_more_follows(lab: Lab) -> None:
    small = ONE.replace("default=1, ge=0, le=2", "default=0.1, ge=0, le=0.5")
    session = lab.began(LAW)
    assert lab.save(small)["reason"] == ""
    assert lab.compensation(session)["mine_share"] == 0.1
    assert lab.compensation(session, "base")["mine_share"] == 0.1


def test_numbers_of_state_of_the_same_name_stay_wherever_they_are(lab: Lab) -> None:
    lab.save(COUNTS)
    session = lab.began(LAW)
    lab.step(session, 1000)
    assert lab.last(session, "B.x.law_n") == pytest.approx(1000)
    assert lab.save(COUNTS_TWO)["reason"] == ""
    lab.step(session, 1)
    assert lab.last(session, "B.x.law_n") == pytest.approx(1001)
    assert lab.last(session, "B.x.friction_estimate") == pytest.approx(1.0, rel=1e-4)
    other = lab.began(LAW)
    lab.step(other, 5)
    assert lab.last(other, "B.x.law_m") == pytest.approx(5)


def test_a_new_file_is_a_law_at_once_and_stays_when_it_goes(lab: Lab) -> None:
    file = lab.folder / "fresh.py"
    event = lab.save(template("fresh"), file.name)
    assert (event["law"], event["version"], event["reason"]) == ("fresh", 1, "")
    assert lab.entry("fresh")["own"] and lab.entry("fresh")["parameters"] == ["fresh_share"]
    assert lab.change(lab.session, {f"{COMPENSATION}.law": "fresh"}).is_success
    lab.step(lab.session)
    assert abs(lab.last(lab.session, "B.x.friction_estimate")) > 0.1
    assert lab.error(law="fresh") == lab.error(law="mine") == lab.error(law="fresh@before")
    again = template("fresh").replace("F_c  # N", "F_c * 0.5  # N")
    assert lab.save(again, file.name)["version"] == 2
    assert lab.error(law="fresh") != lab.error(law="fresh@before")
    file.unlink()
    time.sleep(0.5)
    assert lab.error(law="fresh") != lab.error(law="fresh@before")


def test_a_file_that_was_refused_at_the_start_is_taken_once_it_can_be(lab: Lab) -> None:
    assert any("late.py:1" in each for each in lab.laws()["refused"])
    event = lab.save(template("mine"), "late.py")
    assert "mine.name: is the name of another law" in event["reason"]
    assert any("another law" in each for each in lab.laws()["refused"])
    assert lab.save(template("late"), "late.py")["law"] == "late"
    assert lab.laws()["refused"] == []


def test_an_empty_file_is_about_to_be_written(lab: Lab) -> None:
    file = lab.folder / "mine.py"
    file.write_text("")
    os.utime(file, (0, 0))  # long ago: a disk may be busy between the two steps of a write
    time.sleep(0.5)
    assert lab.events() == [] and not lab.entry()["problem"]
    assert lab.save(TWO)["reason"] == ""


def test_another_name_is_refused(lab: Lab) -> None:
    event = lab.save(ONE.replace('name="mine"', 'name="yours"'))
    assert "LAW.name: is another name than before: a new law needs a file" in event["reason"]
    assert "yours" in event["reason"] and "allowed mine" in event["reason"]


def test_two_laws_cannot_declare_a_name_otherwise(lab: Lab) -> None:
    clash = (
        template("clash")
        .replace('"clash_share"', '"mine_share"')
        .replace("clash_share", "mine_share")
    )
    event = lab.save(clash.replace("le=2", "le=3"), "clash.py")
    assert "mine_share is declared otherwise by another" in event["reason"]
    (lab.folder / "clash.py").unlink()


def test_a_study_has_a_new_parameter(lab: Lab) -> None:
    lab.save(TWO)
    grid = [{"path": f"{COMPENSATION}.mine_offset", "start": 0.0, "stop": 3.0, "count": 2}]
    body = {"scenario": "circle", "set": LAW | {"trajectory.laps": 1}, "grid": grid}
    job = lab.client.post(f"{API}/sweep", json=body).raise_for_status().headers["location"]
    until(lambda: lab.client.get(job).json()["state"] not in {"queued", "running"})
    report = lab.client.get(job).json()
    assert report["state"] == "done", report
    errors = report["result"]["variants"]["B"]["axes"]["x"]["metrics"]["max_abs_following_error"]
    alone = [lab.error(law="mine"), lab.error(law="mine", mine_offset=3.0)]
    assert errors == pytest.approx(alone, rel=1e-5)


def test_a_process_that_begins_later_has_the_versions_that_were_taken(tmp_path: Path) -> None:
    """A worker of a study, and the loop of drives: whatever the files hold by then."""
    laws = tmp_path / "laws"
    laws.mkdir()
    copies = {name: tmp_path / f"{name}.py" for name in ("one", "two", "fresh")}
    for name, text in (("one", ONE), ("two", TWO), ("fresh", template("fresh"))):
        copies[name].write_text(text)
    (laws / "mine.py").write_text("1 +\n")
    accepted = {
        "fresh": [str(copies["fresh"])] * 2 + [str(laws / "fresh.py")],
        "mine": [str(copies["two"]), str(copies["one"]), str(laws / "mine.py")],
    }
    in_process(later, laws, MOTIONLAB_LAWS_ACCEPTED=json.dumps(accepted))


def later() -> None:
    from motionlab.config.load import load_scenario
    from motionlab.laws import LAWS, PROBLEMS

    assert not PROBLEMS
    assert list(LAWS)[-4:] == ["mine", "mine@before", "fresh", "fresh@before"]
    assert LAWS["mine@before"].Parameters._fields == ("mine_share",)
    scenario = load_scenario("circle", LAW | {f"{COMPENSATION}.mine_offset": 3.0})
    assert scenario.variants["B"].controller.compensation.values()["mine_offset"] == 3.0


def test_configs_follow_declarations_and_so_do_those_that_were_made_before(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ONE)
    in_process(renewed, tmp_path)


def renewed() -> None:
    from motionlab.config.controller import ControllerConfig
    from motionlab.config.load import load_scenario, redeclared
    from motionlab.config.schema import scenario_schema
    from motionlab.kernel.law_renewal import LawVersion, Renewal
    from motionlab.laws import FILES, PARAMETERS

    before, parameters = load_scenario("circle", LAW), dict(PARAMETERS)
    renewal = Renewal([LawVersion("mine", TWO, ONE, FILES["mine"])])
    assert renewal.redeclares
    renewal.take()
    compensation = before.variants["B"].controller.compensation
    assert compensation.values()["mine_offset"] == 0
    assert redeclared(before, parameters) == load_scenario("circle", LAW)
    default: Any = ControllerConfig.model_fields["compensation"].default
    assert default.mine_offset == 0
    assert "mine_offset" in scenario_schema()["$defs"]["CompensationConfig"]["properties"]
    renewal.take_back()
    assert "mine_offset" not in scenario_schema()["$defs"]["CompensationConfig"]["properties"]
    assert load_scenario("circle", LAW) == before
