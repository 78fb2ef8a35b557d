"""The JSON messages of a session's stream, which OpenAPI cannot describe by itself."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter
from pydantic.json_schema import models_json_schema

from motionlab.server.http.problems import Problem
from motionlab.server.live.session_info import SessionInfo

FRAME_TICKS_LEAST_MAX = 1000
"""Largest `frame_ticks`: half a second at the speed of a motor, 5 s at the lowest."""

WhenBehind = Literal["skip", "thin", "wait"]
"""What becomes of samples that a client's line cannot carry."""


class StreamColumn(BaseModel):
    """A column that can be subscribed to."""

    name: str
    unit: str
    meaning: str


class Greeting(BaseModel):
    """Protocol, and variants of the session."""

    type: Literal["hello"] = "hello"
    protocol: int
    rate: int = Field(description="Ticks per second of simulated time")
    variants: list[str]


class Hello(Greeting):
    """Sent once, on connect."""

    columns: list[StreamColumn]
    session: SessionInfo


class Subscribed(BaseModel):
    """Answers a subscription: frames begin with `from_tick`."""

    type: Literal["subscribed"] = "subscribed"
    columns: list[str]
    from_tick: int


class Gap(BaseModel):
    """Ticks `from_tick` to `to_tick` - 1 were skipped."""

    type: Literal["gap"] = "gap"
    from_tick: int
    to_tick: int
    frames: int = Field(description="About how many frames that would have been")


class Delay(BaseModel):
    """How late samples are, about once a second; only to a client whose curves may be thinned."""

    type: Literal["delay"] = "delay"
    seconds: float = Field(description="Longest time from a sample until the client had it, s")


class Named(BaseModel):
    """Answers `person`: the name by which others see who watches by this stream."""

    type: Literal["named"] = "named"
    name: str


class SessionMessage(BaseModel):
    """State, speed, parameters or people have changed, or somebody has pushed."""

    type: Literal["session"] = "session"
    session: SessionInfo


class Reset(BaseModel):
    """The session is back at tick 0; earlier samples are void."""

    type: Literal["reset"] = "reset"


class ErrorMessage(BaseModel):
    """A client message that cannot be used; the connection stays."""

    type: Literal["error"] = "error"
    problem: Problem


class Subscribe(BaseModel):
    """Subscribe to columns, from a tick or from now on."""

    model_config = ConfigDict(extra="forbid", strict=True)

    type: Literal["subscribe"]
    columns: list[str] = Field(max_length=4096)
    from_tick: int | None = Field(default=None, ge=0)
    frame_ticks: int | None = Field(
        default=None,
        ge=1,
        le=FRAME_TICKS_LEAST_MAX,
        description="Ticks that a frame holds at least while time passes; the rest comes at rest",
    )
    when_behind: WhenBehind | None = Field(
        default=None,
        description="What a line that cannot carry every sample misses: ticks (`skip`, unless "
        "given), all but the extremes (`thin`), or nothing for up to 30 s (`wait`)",
    )


class Acknowledge(BaseModel):
    """Acknowledge a frame and all before it."""

    model_config = ConfigDict(extra="forbid", strict=True)

    type: Literal["ack"]
    sequence: int = Field(ge=0)


class Person(BaseModel):
    """Say who watches by this stream; streams that do not, such as a script's, are no people."""

    model_config = ConfigDict(extra="forbid", strict=True)

    type: Literal["person"]
    name: str = Field(
        default="",
        max_length=200,
        description="Of it, one line of 40 printable characters is shown; empty for a guest",
    )
    key: str = Field(
        default="",
        pattern="^[A-Za-z0-9_-]{0,64}$",
        description="Streams of one key are one person; never shown",
    )


SERVER_MESSAGES = (Hello, Subscribed, Gap, Delay, Named, SessionMessage, Reset, ErrorMessage)
CLIENT_MESSAGES = (Subscribe, Acknowledge, Person)

ServerMessage = Subscribed | Gap | Delay | Named | Reset | ErrorMessage
"""Messages that a stream builds as objects; greetings and sessions are assembled as text."""

ClientMessage = Annotated[Subscribe | Acknowledge | Person, Field(discriminator="type")]
client_message: TypeAdapter[Subscribe | Acknowledge | Person] = TypeAdapter(ClientMessage)


def schemas() -> dict[str, Any]:
    """Return the JSON schema of every message, by name, as OpenAPI components."""
    models = [(model, "validation") for model in (*SERVER_MESSAGES, *CLIENT_MESSAGES)]
    _, document = models_json_schema(
        models,  # pyright: ignore[reportArgumentType]
        ref_template="#/components/schemas/{model}",
    )
    return document["$defs"]


def asyncapi(version: str) -> dict[str, Any]:
    """Return the AsyncAPI document of the stream."""
    frame = {
        "name": "frame",
        "contentType": "application/octet-stream",
        "summary": "Binary telemetry; docs/stream.md describes it byte by byte",
        "payload": {"type": "string", "format": "binary"},
    }
    names = [model.__name__ for model in (*SERVER_MESSAGES, *CLIENT_MESSAGES)]
    messages = {
        name: {"name": name, "payload": {"$ref": f"#/components/schemas/{name}"}} for name in names
    }
    channel = {"$ref": "#/channels/stream"}

    def named(models: tuple[type[BaseModel], ...]) -> list[dict[str, str]]:
        return [{"$ref": f"#/channels/stream/messages/{m.__name__}"} for m in models]

    return {
        "asyncapi": "3.0.0",
        "info": {"title": "PSRM Motion Lab stream", "version": version},
        "channels": {
            "stream": {
                "address": "/api/v1/sessions/{session_id}/stream",
                "parameters": {"session_id": {"description": "Identifier of the session"}},
                "messages": messages | {"frame": frame},
            }
        },
        "operations": {
            "serve": {
                "action": "send",
                "channel": channel,
                "messages": [
                    *named(SERVER_MESSAGES),
                    {"$ref": "#/channels/stream/messages/frame"},
                ],
            },
            "listen": {"action": "receive", "channel": channel, "messages": named(CLIENT_MESSAGES)},
        },
        "components": {"schemas": schemas()},
    }
