"""Status and contents of a live session, as the API returns them, and what its state refuses."""

from __future__ import annotations

import json
from typing import Any, Literal

from pydantic import BaseModel, Field, TypeAdapter

from motionlab.config.scenario import Scenario
from motionlab.library.run import Event
from motionlab.simulation.change import Change

State = Literal["paused", "playing", "stopping", "stopped", "finished"]
RecordState = tuple[str | None, str, int]
"""The run that is recorded, why nothing is, and the tick with which the recording begins."""


class WrongState(Exception):
    """A command that the state of the session does not allow."""


def json_of(value: Any, adapter: TypeAdapter[Any]) -> str:
    """Return a value as JSON, whatever text it holds: its session is still to be stopped."""
    try:
        return adapter.dump_json(value).decode()
    except ValueError:  # half of a surrogate pair, which JSON can spell and UTF-8 cannot
        return json.dumps(adapter.dump_python(value))


class JsonMembers:
    """Members of an object as JSON; scenarios are long and seldom change, so texts are kept."""

    def __init__(self) -> None:
        self._texts: dict[str, tuple[Any, str]] = {}

    def text(self, name: str, value: Any, adapter: TypeAdapter[Any]) -> str:
        """Return a member, written anew only when its value is another object."""
        kept = self._texts.get(name)
        if kept is None or kept[0] is not value:
            kept = self._texts[name] = (value, f'"{name}":{json_of(value, adapter)}')
        return kept[1]


class SessionStatus(BaseModel):
    """Status of a session."""

    id: str
    revision: int = Field(description="Grows with every change; of two reports the larger is newer")
    timeline: int = Field(description="Counts resets; ticks of another timeline are other ticks")
    state: State
    tick: int
    time: float = Field(description="Simulated time, s")
    speed: float = Field(description="Simulated time per time")
    stream: str = Field(description="Path of its websocket")
    run: str | None = Field(description="Run that is being recorded; null before the first tick")
    recorded_from: float = Field(
        description="Simulated time with which that run begins, s; above 0 once its beginning has "
        "gone, to make room for what comes"
    )
    unrecorded: str = Field(description="Why nothing can be recorded now; empty when all is well")
    watchers: int = Field(description="Streams and 3-D views that are open")
    ends: int | None = Field(description="Tick at which it ends; null if it goes on")
    diverged: dict[str, float | None] = Field(description="Time at which a variant diverged, s")
    drive: str = Field(
        default="", description="Title of the drive link that it moves; empty where it is simulated"
    )


class SessionInfo(SessionStatus):
    """State and contents of a session."""

    people: list[str] = Field(
        description="Who watches: names that people gave to their streams, or Guest 1, Guest 2 ..."
    )
    events: list[Event] = Field(
        description="What people did since the reset, the latest 100, oldest first; a person's "
        "changes of one field within 1 s are one, at the last of them"
    )
    changes: list[Change] = Field(description="The latest, oldest first; undo takes back the last")
    base: Scenario = Field(description="What it was created from")
    scenario: Scenario = Field(description="What is in effect")
