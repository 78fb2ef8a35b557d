"""A master for tests: our own frames, one datagram at a time, at times of its own choice."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from motionlab.drive import process_data as pd
from motionlab.drive.ethercat import (
    APRD,
    APWR,
    ARMW,
    BRD,
    BWR,
    FPRD,
    FPWR,
    INIT,
    LRD,
    LRW,
    LWR,
    OP,
    PREOP,
    REGISTER_AL_CONTROL,
    REGISTER_AL_STATUS,
    REGISTER_AL_STATUS_CODE,
    REGISTER_DC_ACTIVATION,
    REGISTER_DC_RECEIVE_TIME,
    REGISTER_DC_START_TIME,
    REGISTER_DC_SYNC0_CYCLE,
    REGISTER_DC_SYSTEM_TIME,
    REGISTER_DC_SYSTEM_TIME_DELAY,
    REGISTER_DC_SYSTEM_TIME_OFFSET,
    REGISTER_FMMU,
    REGISTER_STATION_ADDRESS,
    REGISTER_SYNC_MANAGER,
    SAFEOP,
    Datagram,
    datagrams,
    frame,
)

NODES = pd.NODES
PERIOD = 500_000
"""ns."""

OUTPUTS, INPUTS = NODES * pd.OUTPUT_BYTES, NODES * pd.INPUT_BYTES
Exchange = Callable[[bytes, int], bytes | None]


class NoAnswer(Exception):
    """The frame did not come back."""


class Refused(Exception):
    """An SDO was aborted."""

    def __init__(self, code: int) -> None:
        super().__init__(f"0x{code:08X}")
        self.code = code


@dataclass
class Bus:
    """Six nodes behind a function that exchanges frames.

    Attributes
    ----------
    exchange : callable
        Takes a frame and the time, ns, and returns the answer.
    now : int
        Time of the next frame; tests move it on.
    """

    exchange: Exchange
    now: int = 0
    outputs: np.ndarray = field(default_factory=lambda: np.zeros(NODES, pd.OUTPUT))
    _counters: list[int] = field(default_factory=lambda: [0] * NODES)

    def send(self, *sent: Datagram) -> list[Datagram]:
        answer = self.exchange(frame(sent), self.now)
        if answer is None:
            raise NoAnswer
        return list(datagrams(answer))

    def one(self, command: int, position: int, offset: int, data: bytes) -> Datagram:
        return self.send(Datagram(command, position, offset, data))[0]

    def read(self, node: int, register: int, size: int) -> bytes:
        found = self.one(FPRD, 0x1001 + node, register, bytes(size))
        assert found.working_counter == 1, (node, hex(register))
        return found.data

    def number(self, node: int, register: int, size: int = 2) -> int:
        return int.from_bytes(self.read(node, register, size), "little")

    def write(self, node: int, register: int, data: bytes) -> None:
        found = self.one(FPWR, 0x1001 + node, register, data)
        assert found.working_counter == 1, (node, hex(register))

    def count(self) -> int:
        return self.one(BRD, 0, 0, bytes(1)).working_counter

    def address(self) -> None:
        for node in range(NODES):
            data = struct.pack("<H", 0x1001 + node)
            assert self.one(APWR, -node, REGISTER_STATION_ADDRESS, data).working_counter == 1

    def state(self, node: int) -> tuple[int, int]:
        return self.number(node, REGISTER_AL_STATUS), self.number(node, REGISTER_AL_STATUS_CODE)

    def request(self, node: int, state: int) -> tuple[int, int]:
        self.write(node, REGISTER_AL_CONTROL, struct.pack("<H", state))
        return self.state(node)

    def request_all(self, state: int) -> None:
        self.one(BWR, 0, REGISTER_AL_CONTROL, struct.pack("<H", state))
        assert [self.state(n) for n in range(NODES)] == [(state, 0)] * NODES

    def mailboxes(self, node: int) -> None:
        self.write(
            node,
            REGISTER_SYNC_MANAGER,
            struct.pack("<HHBBBB", 0x1000, 128, 0x26, 0, 1, 0)
            + struct.pack("<HHBBBB", 0x1080, 128, 0x22, 0, 1, 0),
        )

    def process_data(self, node: int, outputs: int = 6, inputs: int = 16) -> None:
        self.write(
            node,
            REGISTER_SYNC_MANAGER + 16,
            struct.pack("<HHBBBB", 0x1100, outputs, 0x64, 0, 1, 0)
            + struct.pack("<HHBBBB", 0x1180, inputs, 0x20, 0, 1, 0),
        )
        self.write(
            node,
            REGISTER_FMMU,
            fmmu(6 * node, 6, 0x1100, 2) + fmmu(OUTPUTS + 16 * node, 16, 0x1180, 1),
        )

    def has_mail(self, node: int) -> bool:
        return bool(self.number(node, REGISTER_SYNC_MANAGER + 13, 1) & 8)

    def emergencies(self, node: int) -> list[tuple[int, int]]:
        """Return error codes and registers of the emergencies that have come, and empty the box."""
        found = []
        while self.has_mail(node):
            mail = self.read(node, 0x1080, 128)
            assert mail[:8] == struct.pack("<HHBBH", 10, 0, 0, 3, 1 << 12)
            found.append(struct.unpack_from("<HB", mail, 8))
        return found

    def mail(self, node: int, body: bytes, kind: int = 3) -> bytes:
        """Send a mail and return its answer; emergencies before it are lost."""
        self.emergencies(node)
        self._counters[node] = counter = self._counters[node] % 7 + 1
        head = struct.pack("<HHBB", len(body), 0, 0, kind | counter << 4)
        self.write(node, 0x1000, (head + body).ljust(128, b"\0"))
        for _ in range(20_000):  # about a second where it runs in real time
            if self.has_mail(node):
                break
        answer = self.read(node, 0x1080, 128)
        assert answer[5] >> 4 == counter
        return answer[6 : 6 + struct.unpack_from("<H", answer)[0]]

    def upload(self, node: int, index: int, subindex: int = 0) -> bytes:
        answer = self.mail(node, struct.pack("<HBHB4x", 2 << 12, 0x40, index, subindex))
        command, size = answer[2], answer[6:10]
        if command == 0x80:
            raise Refused(int.from_bytes(size, "little"))
        if command & 2:
            return size[: 4 - (command >> 2 & 3)]
        assert int.from_bytes(size, "little") == len(answer[10:])
        return answer[10:]

    def download(self, node: int, index: int, subindex: int, data: bytes) -> None:
        command = 0x23 | (4 - len(data)) << 2
        head = struct.pack("<HBHB", 2 << 12, command, index, subindex)
        answer = self.mail(node, head + data.ljust(4, b"\0"))
        if answer[2] == 0x80:
            raise Refused(int.from_bytes(answer[6:10], "little"))
        assert answer[2] == 0x60

    def exchange_all(self) -> np.ndarray:
        """Write outputs and read inputs in one LRW."""
        data = self.outputs.tobytes() + bytes(INPUTS)
        found = self.one(LRW, 0, 0, data)
        assert found.working_counter == 3 * NODES
        return np.frombuffer(found.data[OUTPUTS:], pd.INPUT)

    def read_inputs(self) -> np.ndarray:
        found = self.one(LRD, OUTPUTS, 0, bytes(INPUTS))
        assert found.working_counter == NODES
        return np.frombuffer(found.data, pd.INPUT)

    def write_outputs(self) -> None:
        assert self.one(LWR, 0, 0, self.outputs.tobytes()).working_counter == NODES

    def to_preop(self) -> None:
        self.address()
        self.request_all(INIT)
        for node in range(NODES):
            self.mailboxes(node)
        self.request_all(PREOP)

    def to_op(self, sync0: bool = False) -> None:
        """Bring all nodes from INIT to OP; with `sync0` at 2 kHz, SYNC0 a millisecond from now."""
        self.to_preop()
        if sync0:
            self.clocks()
        for node in range(NODES):
            self.download(node, 0x1C32, 1, struct.pack("<H", 2 if sync0 else 1))
            self.process_data(node)
        if sync0:
            self.start_sync0(self.system_time() + 1_000_000)
        self.request_all(SAFEOP)
        if sync0:
            self.now += 2_000_000
        self.exchange_all()
        self.request_all(OP)

    def system_time(self, node: int = 0) -> int:
        return self.number(node, REGISTER_DC_SYSTEM_TIME, 8)

    def clocks(self) -> None:
        """Set offsets and delays of all nodes to the first one's clock."""
        self.one(BWR, 0, REGISTER_DC_RECEIVE_TIME, bytes(4))
        local = [self.number(n, REGISTER_DC_RECEIVE_TIME + 0x18, 8) for n in range(NODES)]
        ports = [
            struct.unpack("<II", self.read(n, REGISTER_DC_RECEIVE_TIME, 8)) for n in range(NODES)
        ]
        round_trip = [back - there for there, back in ports[:-1]] + [0]
        for n in range(NODES):
            delay = (round_trip[0] - round_trip[n]) // 2
            offset = local[0] + delay - local[n]
            self.write(n, REGISTER_DC_SYSTEM_TIME_OFFSET, struct.pack("<q", offset))
            self.write(n, REGISTER_DC_SYSTEM_TIME_DELAY, struct.pack("<I", delay))
        self.one(ARMW, 0, REGISTER_DC_SYSTEM_TIME, bytes(8))

    def start_sync0(self, start: int, cycle: int = PERIOD) -> None:
        for n in range(NODES):
            self.write(n, REGISTER_DC_SYNC0_CYCLE, struct.pack("<I", cycle))
            self.write(n, REGISTER_DC_START_TIME, struct.pack("<q", start))
            self.write(n, REGISTER_DC_ACTIVATION, b"\x03")

    def control(self, word: int) -> np.ndarray:
        """Send a control word for two periods and return the inputs."""
        self.outputs["control"] = word
        self.outputs["mode"] = pd.CYCLIC_TORQUE
        return self.periods(3)

    def periods(self, count: int) -> np.ndarray:
        """Exchange process data in so many periods and return the last inputs."""
        for _ in range(count - 1):
            self.now += PERIOD
            self.exchange_all()
        self.now += PERIOD
        return self.exchange_all()

    def enable(self) -> np.ndarray:
        """Bring all drives to operation enabled."""
        self.control(pd.FAULT_RESET)
        for word in (pd.SHUTDOWN, pd.SWITCHED_ON, pd.ENABLED):
            found = self.control(word)
        return found


def fmmu(logical: int, size: int, physical: int, kind: int) -> bytes:
    return struct.pack("<IHBBHBBB3x", logical, size, 0, 7, physical, 0, kind, 1)


__all__ = ["APRD", "Bus", "NoAnswer", "Refused", "fmmu"]
