"""Who is on a session, and who changed, pushed and stopped what."""

from __future__ import annotations

import time
from typing import Any

import pytest

from motionlab.library.run import Event
from motionlab.server.live.event_log import EARLIER_MAX, EVENTS_MAX, EventLog
from motionlab.server.live.people import NAME_MAX, People, decoded_name, shown_name
from tests.server.conftest import Connect
from tests.server.live import API, Live, Stream, until
from tests.server.openapi import Contract
from tests.server.servers import Server

K_P = "variants.B.controller.x.k_p"
ANNA = {"Person": "Anna%20%C3%84."}


def introduced(stream: Stream, **person: str) -> str:
    stream.send(type="person", **person)
    return stream.find("named")["name"]


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("Anna%20%C3%84.", "Anna \u00c4."),
        ("  a\tb  ", "a b"),
        ("%E2%80%AEtxt%00%0A", "txt"),  # neither a change of direction nor a line of its own
        ("%ff%", "\ufffd%"),
        ("%C3%84" * 100, "\u00c4" * NAME_MAX),
        ("x" * 50_000, "x" * NAME_MAX),
        ("", ""),
    ],
)
def test_a_name_is_one_short_printable_line(header: str, name: str) -> None:
    assert decoded_name(header) == name
    assert shown_name(name) == name


def test_people_have_names_or_numbers(server: Server, live: Live, contract: Contract) -> None:
    with Stream(server, live.id) as first, Stream(server, live.id):
        assert live.info()["people"] == []  # who does not say so is nobody
        first.send(type="person", key="k1")
        contract.schema("Named", first.find("named"))
        assert live.info()["people"] == ["Guest 1"]
        with Stream(server, live.id) as second:
            assert introduced(second, name=" Guest 1 ", key="k2") == "Guest 2"
            assert first.find("session")["session"]["people"] == ["Guest 1"]
            assert first.find("session")["session"]["people"] == ["Guest 1", "Guest 2"]
            assert introduced(first, name="Anna\u202e", key="k1") == "Anna"
            assert live.info()["people"] == ["Anna", "Guest 2"]
        until(lambda: live.info()["people"] == ["Anna"])
        with Stream(server, live.id) as again, Stream(server, live.id) as other_tab:
            assert introduced(again, key="k2") == "Guest 2"
            assert introduced(other_tab, key="k2") == "Guest 2"
            assert live.info()["people"] == ["Anna", "Guest 2"]


def test_a_person_that_cannot_be_taken_is_refused(connect: Connect, live: Live) -> None:
    stream = connect()
    for person in ({"name": "x" * 201}, {"name": 1}, {"key": "a b"}, {"key": "x" * 65}):
        stream.send(type="person", **person)
        assert next(iter(person)) in stream.find("error")["problem"]["detail"]
    assert live.info()["people"] == []


def test_numbers_of_guests_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("motionlab.server.live.people._GUESTS_KEPT", 3)
    people = People(lambda: None)
    people.enter("stays", key="stays", name="")
    for k in range(5):
        people.enter(k, key=f"k{k}", name="")
        people.leave(k)
    assert people.enter("again", key="k4", name="") == "Guest 6"
    assert people.enter("late", key="k0", name="") == "Guest 7"  # forgotten
    assert people.names == ("Guest 1", "Guest 6", "Guest 7")


def test_events_name_who_made_them(live: Live) -> None:
    live.step(10)
    live.client.patch(f"{live.path}/parameters", json={"set": {K_P: 3e5}}, headers=ANNA)
    live.client.post(f"{live.path}/undo", headers={"Person": "Guest%202"})
    push = {"axis": "x", "force": 2.0}
    live.client.post(f"{live.path}/push", json=push, headers=ANNA)
    live.step(20)
    live.change({K_P: 2e5})
    live.client.post(f"{live.path}/stop", headers=ANNA | {"Lease": "x" * 100})
    until(lambda: live.state == "stopped")
    events = live.info()["events"]
    said = [(event["kind"], event["tick"], event["by"], event["undo"]) for event in events]
    assert said == [
        ("change", 10, "Anna \u00c4.", False),
        ("change", 10, "Guest 2", True),
        ("push", 10, "Anna \u00c4.", False),
        ("change", 30, "", False),
        ("stop", 30, "Anna \u00c4.", False),
    ]
    live.do("reset")
    (reset,) = live.info()["events"]
    assert (reset["kind"], reset["tick"]) == ("reset", 0)


def test_who_did_what_to_the_clock(live: Live) -> None:
    def command(name: str, person: str, **body: Any) -> None:
        answer = live.client.post(f"{live.path}/{name}", json=body, headers={"Person": person})
        assert answer.status_code == 200

    begun = time.time() - 1.0
    command("play", "Anna", speed=2.0)
    command("play", "Ben", speed=2.0)  # changes nothing
    command("play", "Ben", speed=4.0)
    command("play", "Ben", speed=3.0)  # of a drag
    command("pause", "Anna")
    command("pause", "Ben")
    command("play", "Anna")
    told = [(e["kind"], e["by"], e["speed"]) for e in live.info()["events"]]
    clock = [
        ("play", "Anna", 2.0),
        ("speed", "Ben", 3.0),
        ("pause", "Anna", None),
        ("play", "Anna", None),
    ]
    assert told == clock
    earlier = f"{live.path}/earlier-events"
    assert live.client.get(earlier).json() == []
    command("reset", "Ben")
    command("reset", "Anna")
    events = live.client.get(earlier).json()
    assert [(e["kind"], e["by"], e["speed"]) for e in events] == [*clock, ("reset", "Ben", None)]
    assert all(begun < e["at"] < time.time() + 1.0 for e in events)
    assert [e["by"] for e in live.info()["events"]] == ["Anna"]


def test_a_run_has_no_events_of_the_clock(live: Live) -> None:
    live.do("play")
    until(lambda: live.info()["tick"] > 10)
    live.client.post(f"{live.path}/pause", headers=ANNA)
    live.client.patch(f"{live.path}/parameters", json={"set": {K_P: 3e5}}, headers=ANNA)
    live.step(10)
    run = live.info()["run"]
    live.do("reset")
    until(lambda: live.client.get(f"{API}/runs/{run}").json().get("state") == "complete")
    assert [e["kind"] for e in live.client.get(f"{API}/runs/{run}").json()["events"]] == ["change"]


def test_events_are_recorded_with_their_names(live: Live) -> None:
    live.step(10)
    live.client.patch(f"{live.path}/parameters", json={"set": {K_P: 3e5}}, headers=ANNA)
    live.step(10)
    run = live.info()["run"]
    live.do("reset")  # which ends the recording

    def recorded() -> dict[str, Any]:
        return live.client.get(f"{API}/runs/{run}").json()

    until(lambda: recorded().get("state") == "complete")
    assert [event["by"] for event in recorded()["events"]] == ["Anna \u00c4."]
    report = live.client.get(f"{API}/runs/{run}/report").text
    assert "(by Anna \u00c4.)" in report


@pytest.mark.parametrize("name", ["%", "%00", "x" * 60_000, "%F0%9F%98%80" * 99])
def test_no_name_keeps_stop_from_acting(live: Live, name: str) -> None:
    answer = live.client.post(f"{live.path}/stop", headers={"Person": name})
    assert answer.status_code == 200
    until(lambda: live.state == "stopped")
    assert len(live.info()["events"][-1]["by"]) <= NAME_MAX


def change(tick: int, value: float, **others: Any) -> Event:
    facts: dict[str, Any] = {"set": {K_P: value}, "previous": {K_P: value - 1}, "by": "Anna"}
    return Event(tick=tick, kind="change", **(facts | others))


def test_a_drag_is_one_event() -> None:
    log = EventLog()
    for k in range(10):
        log.add(change(1000 * k, k))
    drag = change(9000, 9.0, previous={K_P: -1.0})
    assert log.latest == (drag,)
    others = [
        change(9500, 9.0, by="Ben"),
        change(9500, 8.0, by="Ben", undo=True),
        change(9600, 9.0, by="Ben"),
        change(11_600, 9.0, by="Ben"),
        change(11_700, 9.0, by="Ben", set={"plant.x.mass": 7.0}),
        Event(tick=11_700, kind="stop", by="Ben"),
    ]
    for event in others:
        log.add(event)
    assert log.latest == (drag, *others)


def test_the_latest_events_are_kept() -> None:
    log = EventLog()
    for tick in range(EVENTS_MAX + 5):
        log.add(Event(tick=tick, kind="push"))
    assert [event.tick for event in log.latest] == list(range(5, EVENTS_MAX + 5))
    reset = Event(tick=0, kind="reset")
    log.add(reset)
    assert log.latest == (reset,)
    assert [event.tick for event in log.earlier] == list(range(5, EVENTS_MAX + 5))
    for _ in range(EARLIER_MAX):
        log.add(reset)
    assert log.earlier == (reset,) * EARLIER_MAX
