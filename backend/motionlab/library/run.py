"""What a run is: the record of a simulation, a live session, a drive or a measurement."""

from __future__ import annotations

import re
import secrets
from typing import Any, Literal

from pydantic import BaseModel, Field

from motionlab.config.bounds import check_text
from motionlab.errors import ConfigError, FieldError

Kind = Literal["simulation", "live", "drive", "measurement"]
State = Literal["recording", "complete", "partial"]

ID = "^r-[a-z2-7]{12}$"
"""Form of the identifier of a run."""

TAG = "^[a-z0-9][a-z0-9._-]{0,31}$"
"""Form of a tag."""

TEXT = r"^[^\x00]*$"
"""Form of names and notes: PostgreSQL knows no zero in a text."""

NAME = r"^[^\x00-\x1f\x7f-\x9f\ud800-\udfff]*$"
"""Form of a new name: one line, and nothing that a terminal takes for an order."""

LINE = r"^[^\x00-\x1f\x7f-\x9f]*$"
"""`NAME` for a request, whose JSON is Unicode text."""

NAME_MAX = 120
NOTE_MAX = 10_000
TAGS_MAX = 20

CHANGEABLE = frozenset(
    {"name", "named", "note", "tags", "pinned", "kept", "deleted", "differences"}
)
"""What can be changed of a run: by hand, or, the differences, while it is being recorded."""

_LETTERS = "abcdefghijklmnopqrstuvwxyz234567"
_ID = re.compile(ID)


def check_name(name: object, loc: str = "name") -> None:
    """Refuse what is no name of a run.

    Raises
    ------
    ConfigError
        Naming `loc`.
    """
    if not isinstance(name, str):
        raise ConfigError(FieldError(loc, "must be text", name))
    if len(name) > NAME_MAX:
        bounds: dict[str, float] = {"maximum": NAME_MAX}
        raise ConfigError(
            FieldError(loc, "is too long", len(name), unit="characters", bounds=bounds)
        )
    check_text(name, loc=loc)
    if re.fullmatch(NAME, name) is None:
        raise ConfigError(FieldError(loc, "has a control character", name))


def new_id() -> str:
    """Return an identifier that no other run has: 60 random bits."""
    return "r-" + "".join(secrets.choice(_LETTERS) for _ in range(12))


def is_id(text: str) -> bool:
    """Return whether a text has the form of an identifier."""
    return _ID.fullmatch(text) is not None


class Difference(BaseModel):
    """A field of a scenario whose value is not the shipped one."""

    path: str = Field(description="Dotted path, as with --set")
    shipped: Any = Field(description="Value of the shipped scenario; null where it has none")
    value: Any = Field(description="Value of this run; null where it has none")


class Event(BaseModel):
    """What happened at a tick of a live session, or of its recording.

    Of a session alone are `play`, `pause`, `speed` and `reset`: samples do not depend on them.
    """

    tick: int = Field(description="First tick at which it holds")
    kind: Literal["change", "push", "stop", "gap", "play", "pause", "speed", "reset", "law"]
    at: float | None = Field(default=None, description="Unix time, s; of a session")
    by: str = Field(default="", description="Name of who did it; empty if unnamed")
    set: dict[str, Any] = Field(default_factory=dict, description="Of a change: path to value")
    previous: dict[str, Any] = Field(default_factory=dict, description="The values before")
    undo: bool = Field(default=False, description="Of a change: it takes back an earlier one")
    checked: int | None = Field(
        default=None, description="Of a change: tick at which it was checked, before it took effect"
    )
    axis: Literal["x", "y"] | None = Field(default=None, description="Of a push")
    force: float | None = Field(default=None, description="Of a push, N")
    ticks: int | None = Field(default=None, description="Ticks of a push, or missing in a gap")
    reason: str = Field(default="", description="Why ticks are missing, or drives stopped")
    law: str = Field(default="", description="Of `law`: the law whose file has changed")
    version: int | None = Field(
        default=None, description="Of `law`: number of the version that runs from this tick on"
    )
    jump: dict[str, dict[str, float]] = Field(
        default_factory=dict,
        description="Of `law`: what the new version commands in this tick, minus what the former "
        "would have from the same state, N, by variant and axis; without controllers of the law, "
        "or after the motion's end, empty",
    )
    texts: dict[str, str] = Field(
        default_factory=dict,
        description="Of `law` and `change` in a recording: text of each law of one's own that a "
        "controller has from this tick on, where it had none or another",
    )
    speed: float | None = Field(
        default=None, description="Simulated time per time; of `play` where it is another one"
    )


class Capture(BaseModel):
    """What a capture of a trigger is of, and how far its curves go."""

    origin: str = Field(description="The run that it is a stretch of; empty where there is none")
    from_tick: int = Field(description="Tick of its first sample")
    trigger_tick: int = Field(description="Tick at which it was triggered")
    peaks: dict[str, float] = Field(
        description="By channel, those of the trigger and following errors: the sample farthest "
        "from zero, signed, SI"
    )
    glitches: dict[str, float] = Field(
        description="By following error whose axis reverses: height of the quadrant glitch at the "
        "reversal nearest to the trigger, signed, m"
    )


class Run(BaseModel):
    """A run, as lists show it."""

    id: str = Field(pattern=ID)
    kind: Kind
    state: State = Field(description="partial: the recording ended before the run did")
    name: str
    scenario: str = Field(description="Name of its scenario; empty for a measurement")
    note: str
    tags: list[str]
    pinned: bool = Field(description="Never evicted")
    kept: bool = Field(
        default=False,
        description="By a person, who kept, imported, named, noted or tagged it: never evicted",
    )
    created: float = Field(description="When it began, seconds since 1970")
    deleted: float | None = Field(default=None, description="When it was deleted; it can be undone")
    duration: float = Field(description="Recorded time, s")
    ticks: int = Field(description="Recorded samples of each channel")
    period: float = Field(description="Time between two samples, s")
    size: int = Field(description="Bytes of its telemetry")
    reason: str = Field(default="", description="Why it is partial")
    stopped: str = Field(
        default="", description="What stopped it, STOP or a fault; empty where nothing did"
    )
    stopped_at: float | None = Field(
        default=None, description="When that was, from the first sample on, s"
    )
    named: bool = Field(
        default=False, description="By a person; else the name follows what the run is"
    )
    drive: str = Field(default="", description="Title of the drive link that moved; else empty")
    variants: list[str]
    labels: dict[str, str] = Field(description="Of each variant: what its controller is")
    differences: list[Difference] = Field(
        description="From the shipped scenario of its name, with the changes made while it ran"
    )
    metrics: dict[str, float] = Field(
        description="By variant, axis and metric, such as B.x.max_abs_following_error, SI; of a "
        "simulated motor also gain_margin (a factor) and phase_margin (rad), the worst at "
        "standstill and sliding, of a stable loop that has a linearisation"
    )
    capture: Capture | None = Field(default=None, description="Of a trigger's capture")
    thumbnail: dict[str, list[int]] = Field(
        description="Curves of 0 to 1000 by name: reference, and each variant; x, y, x, y ..."
    )


class RunDetail(Run):
    """A run with all that makes it reproducible."""

    seed: int | None = Field(description="null for a measurement")
    version: str
    model: str = Field(description="Hash of the model's sources")
    processor: str = Field(description="Processor that its code was compiled for")
    maps: dict[str, Any] = Field(description="Force maps it used, with their hashes")
    scenario_document: dict[str, Any] | None = Field(
        description="The resolved scenario; null for a measurement"
    )
    laws: dict[str, str] = Field(
        default_factory=dict,
        description="Text of the file of each law of one's own that a controller has at tick 0",
    )
    first_tick: int = Field(
        default=0, description="Tick of its first sample; of a long recording the beginning goes"
    )
    events: list[Event] = Field(description="Changes, pushes, the stop, gaps, by tick")
    result: dict[str, Any] = Field(
        description="Metrics: of a simulation its result document, of a live session those of its "
        "latest two periods or ten seconds, up to a stop"
    )
    columns: list[dict[str, str]] = Field(description="Name, unit and meaning of each channel")

    def measured(self) -> tuple[float, float] | None:
        """Return the window of the metrics from the first sample on, s; None without one."""
        window, begun = self.result.get("window"), self.first_tick * self.period
        return window and (window["start"] - begun, window["end"] - begun)


class Evicted(BaseModel):
    """A run that the lab had recorded by itself, and removed to make room."""

    run: str = Field(description="Its identifier")
    name: str
    created: float = Field(description="When it began, seconds since 1970")
    evicted: float = Field(description="When it was removed, seconds since 1970")
    size: int = Field(description="Bytes of its telemetry")


class Page(BaseModel):
    """A page of a list of runs."""

    runs: list[Run]
    total: int = Field(description="Runs that the search finds")
    cursor: str | None = Field(description="Where the next page begins; null on the last")
