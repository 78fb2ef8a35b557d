"""A live session of a server: commands, and its samples as arrays while they come."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError, naming_extras
from motionlab.scripting.arguments import check_number, plain
from motionlab.scripting.channels import Channels, Kept, Record
from motionlab.scripting.http_client import LabServer, ServerRefused
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.frames import decode
from motionlab.telemetry.parquet import column_descriptions
from motionlab.timing import to_ticks

if TYPE_CHECKING:
    from pyarrow import parquet
    from websockets.sync.connection import Connection

_SILENCE = 10.0
"""After which a session that sends nothing is given up, s."""
_MOVING = ("playing", "stopping")
_AT_REST = ("stopped", "finished")
_LONGEST = 86_400.0  # s of a recording in one block


class Session:
    """A live session; ends with the block: ``with client.session("circle") as session:``.

    Parameters
    ----------
    server : LabServer
        Where it is.
    info : mapping
        As the server describes it.

    Attributes
    ----------
    id : str
        Its identifier, also in the address of the page.
    """

    def __init__(self, server: LabServer, info: Mapping[str, Any]) -> None:
        self.id: str = info["id"]
        self._server = server
        self._path = f"/sessions/{self.id}"

    def __enter__(self) -> Session:
        """Return the session."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End it; what it recorded stays among the runs of the server."""
        try:
            self._server.call("DELETE", self._path)
        except ServerRefused:
            if error is None:
                raise

    @property
    def info(self) -> dict[str, Any]:
        """What ``GET /sessions/{id}`` answers: state, tick, time, speed, scenario in effect."""
        return self._server.call("GET", self._path)

    def play(self, speed: float = 1.0) -> None:
        """Have time pass, 0.1 to 10 times as fast as on a motor."""
        self._post("play", {"speed": speed})

    def pause(self) -> None:
        """Have time stand still."""
        self._post("pause")

    def step(self, ticks: int = 1) -> None:
        """Advance a paused session by ticks of 0.5 ms."""
        self._post("step", {"ticks": ticks})

    def stop(self) -> None:
        """Brake to rest, then command no current; only `reset` leaves this state."""
        self._post("stop")

    def reset(self) -> None:
        """Return to tick 0, paused."""
        self._post("reset")

    def undo(self) -> None:
        """Take the latest change back."""
        self._post("undo")

    def set(self, changes: Mapping[str, Any]) -> int:
        """Change fields of the plant, of controllers or of the load, all or nothing.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to value, SI.

        Returns
        -------
        int
            Tick from which on they hold.
        """
        path = f"{self._path}/parameters"
        return self._server.call("PATCH", path, {"set": plain(changes)})["tick"]

    def push(self, axis: Literal["x", "y"], force: float, duration: float = 0.05) -> int:
        """Push the mover: `force`, N, for `duration`, s; return the tick at which it begins."""
        body = {"axis": axis, "force": force, "duration": duration}
        return self._server.call("POST", f"{self._path}/push", body)["tick"]

    def metrics(self) -> dict[str, Any]:
        """Return the result document of the last two periods, or 10 s (docs/metrics.md)."""
        return self._server.call("GET", f"{self._path}/metrics")

    def latest(self) -> Channels:
        """Return every channel of the last 30 s."""
        return from_parquet(self._server.fetch("GET", f"{self._path}/telemetry?format=parquet"))

    def stream(
        self, *channels: str, from_tick: int | None = None, frame_ticks: int = 100
    ) -> Iterator[Block]:
        """Yield samples of channels as they come.

        Ends when the session ends, and when it has come to rest after `stop` or at its end.

        Parameters
        ----------
        *channels : str
            Such as ``B.x.following_error``; all of them if none is named.
        from_tick : int, optional
            First tick, or the oldest of the last 30 s; the next one when left out.
        frame_ticks : int
            Ticks of a block at least while time passes, 1 to 1000; 100 are 50 ms at speed 1.

        Raises
        ------
        ConfigError
            If a channel is not there.
        ServerRefused
            If there is no connection, or nothing comes for 10 s, as while it is paused.
        """
        with naming_extras("stream"):
            from websockets.exceptions import ConnectionClosed, WebSocketException
            from websockets.frames import CloseCode
            from websockets.sync.client import connect

        address = f"ws{self._server.address.removeprefix('http')}/api/v1{self._path}/stream"
        try:
            with connect(
                address,
                additional_headers=self._server.headers,
                compression=None,
                max_size=None,
                proxy=None,
            ) as socket:
                yield from _streamed(socket, channels, from_tick, frame_ticks)
        except TimeoutError:
            raise ServerRefused(f"{address}: nothing came for {_SILENCE:g} s") from None
        except ConnectionClosed as error:
            if error.rcvd is None or error.rcvd.code != CloseCode.GOING_AWAY:
                raise ServerRefused(f"{address}: the connection was lost") from None
        except (OSError, WebSocketException) as error:
            raise ServerRefused(f"{address}: no connection: {error}") from None

    def record(self, *channels: str, seconds: float, speed: float | None = None) -> Block:
        """Return channels of the next `seconds` of the session's time.

        Parameters
        ----------
        *channels : str
            As of `stream`.
        seconds : float
            Time of the session, s.
        speed : float, optional
            Play it at this speed first; it goes on playing.

        Returns
        -------
        Channels
            Ticks that were lost on the way are NaN.

        Raises
        ------
        ServerRefused
            As `stream`, and if the session ends before.
        """
        check_number(
            "seconds", seconds, unit="s", exclusive_minimum=0.0, exclusive_maximum=_LONGEST
        )
        info = self.info
        if speed is not None:
            self.play(speed)
        elif info["state"] not in _MOVING:
            raise ServerRefused(f"the session is {info['state']}: play() first, or give a speed")
        first, count = info["tick"], to_ticks(seconds)
        described: dict[str, Channel] = {}
        values = np.empty((0, 0), dtype=np.float32)
        for block in self.stream(*channels, from_tick=first):
            if not described:
                described = block.described
                values = np.full((len(described), count), np.nan, dtype=np.float32)
            at = block.first - first
            part = block.samples[:, : max(0, count - at)]
            values[:, at : at + part.shape[1]] = part
            if at + block.samples.shape[1] >= count:
                return Block(described, values, first)
        raise ServerRefused(f"the session ended before {seconds:g} s were recorded")

    def _post(self, command: str, body: dict[str, Any] | None = None) -> None:
        self._server.call("POST", f"{self._path}/{command}", body)


class Block(Channels):
    """Some ticks of a stream.

    Attributes
    ----------
    samples : ndarray of float32, shape (channels, ticks)
        In the order of the channels.
    first : int
        Tick of the first.
    """

    def __init__(
        self, described: Mapping[str, Channel], samples: NDArray[np.float32], first: int
    ) -> None:
        ticks = range(first, first + samples.shape[1])
        super().__init__(described, Kept(list(described), samples, ticks, {}).record)
        self.samples = samples
        self.first = first


def _streamed(
    socket: Connection, channels: tuple[str, ...], from_tick: int | None, frame_ticks: int
) -> Iterator[Block]:
    hello = json.loads(socket.recv(_SILENCE))
    known = {column["name"]: Channel(**column) for column in hello["columns"]}
    selected = {name: known[name] for name in channels if name in known} if channels else known
    wrong = [name for name in channels if name not in known]
    if wrong:
        raise ConfigError(*(FieldError("channels", "no channel of that name", n) for n in wrong))
    begin = {} if from_tick is None else {"from_tick": from_tick}
    wish = {"type": "subscribe", "columns": list(selected), "frame_ticks": frame_ticks}
    socket.send(json.dumps(wish | begin))
    session, next_tick = hello["session"], None
    while session["state"] not in _AT_REST or next_tick is None or next_tick < session["tick"]:
        message = socket.recv(_SILENCE)
        if isinstance(message, bytes):
            frame = decode(message)
            socket.send(f'{{"type": "ack", "sequence": {frame.sequence}}}')
            block = Block(selected, frame.columns, frame.first_tick)
            next_tick = block.ticks.stop
            yield block
            continue
        content = json.loads(message)
        match content["type"]:
            case "error":
                raise ServerRefused(content["problem"]["detail"])
            case "session":
                session = content["session"]
            case "subscribed":
                next_tick = content["from_tick"]
            case "reset":
                next_tick = 0


def from_parquet(data: bytes) -> Channels:
    """Return the channels of a Parquet file of telemetry; read when they are asked for."""
    file = parquet_of(data)
    return Channels(
        described_in(column_descriptions(file.schema_arrow)), lambda: record_of_file(file)
    )


@naming_extras("a recording of a server")
def parquet_of(data: bytes) -> parquet.ParquetFile:
    """Return the bytes of a Parquet file as one that can be read."""
    from pyarrow import parquet

    return parquet.ParquetFile(io.BytesIO(data))


def described_in(columns: Sequence[Mapping[str, str]]) -> dict[str, Channel]:
    """Return unit and meaning of each column by its name."""
    return {each["name"]: Channel(each["name"], each["unit"], each["meaning"]) for each in columns}


def record_of_file(file: parquet.ParquetFile) -> Record:
    """Return what a Parquet file of telemetry holds."""
    ticks = file.read(columns=["tick"])["tick"]
    first = int(ticks[0].as_py()) if len(ticks) else 0
    facts = {
        key.decode(): text.decode() for key, text in (file.schema_arrow.metadata or {}).items()
    }

    def values(names: Sequence[str]) -> NDArray[np.float32]:
        columns = file.read(columns=list(names))
        return np.stack([columns[name].to_numpy() for name in names])

    return Record(values, range(first, first + len(ticks)), facts)
