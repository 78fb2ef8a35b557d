"""From power-on to process data: INIT, PREOP, SAFEOP, OP, with every check on the way.

ETG.1000.6 gives the states, ETG.1020 the order in which clocks are set up. Parameters are volatile:
they are written each time between PREOP and SAFEOP.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from motionlab.config.drive import DriveConfig, NodeConfig
from motionlab.drive.ethercat import (
    AL_CODES,
    AL_ERROR,
    AL_STATES,
    APWR,
    ARMW,
    BRD,
    BWR,
    FPRD,
    FPWR,
    INIT,
    LRD,
    LWR,
    NOP,
    OP,
    PREOP,
    REGISTER_AL_CONTROL,
    REGISTER_AL_STATUS,
    REGISTER_AL_STATUS_CODE,
    REGISTER_DC_ACTIVATION,
    REGISTER_DC_CUC,
    REGISTER_DC_RECEIVE_TIME,
    REGISTER_DC_RECEIVE_TIME_UNIT,
    REGISTER_DC_START_TIME,
    REGISTER_DC_SYNC0_CYCLE,
    REGISTER_DC_SYSTEM_TIME,
    REGISTER_DC_SYSTEM_TIME_DELAY,
    REGISTER_DC_SYSTEM_TIME_OFFSET,
    REGISTER_FMMU,
    REGISTER_SII_CONFIGURATION,
    REGISTER_SII_CONTROL,
    REGISTER_SII_DATA,
    REGISTER_STATION_ADDRESS,
    REGISTER_SYNC_MANAGER,
    REGISTER_TYPE,
    REGISTER_WATCHDOG_DIVIDER,
    REGISTER_WATCHDOG_PROCESS_DATA,
    SAFEOP,
    WATCHDOG_TICK,
    Datagram,
)
from motionlab.drive.link.bus import INPUTS_AT, OUTPUTS_AT
from motionlab.drive.link.carrier import Carrier, LinkError
from motionlab.drive.link.mailbox import Mailbox
from motionlab.drive.process_data import (
    CYCLIC_TORQUE,
    INPUT_BYTES,
    INPUTS,
    NODES,
    OUTPUT_BYTES,
    OUTPUTS,
    RX_PDO,
    TX_PDO,
    Entry,
)
from motionlab.timing import CONTROL_PERIOD

STATION = 0x1001  # address of the first drive; the next ones follow
_STATE_TIMEOUT = 5.0  # s, for a drive to change its state
_SII_TIMEOUT = 0.5  # s
_SII_VENDOR, _SII_PRODUCT = 0x08, 0x0A  # words
_SII_RECEIVE, _SII_SEND = 0x18, 0x19  # offset, then size, of the standard mailboxes
_SII_CATEGORIES = 0x40
_SII_SYNC_MANAGERS = 41
_SII_END = 0xFFFF
_SII_WORDS_MAX = 0x800
_MAILBOX_OUT, _MAILBOX_IN, _BUFFERED_OUT, _BUFFERED_IN = 0x26, 0x22, 0x64, 0x20
_ACTIVE_SYNC0 = 0x03
_START_AHEAD = 100_000_000  # ns until the first SYNC0
_SETTLE = 20_000_000  # ns of SYNC0 before OP is asked for
_PERIOD = round(CONTROL_PERIOD * 1e9)
_SYNC0, _SM_EVENT = 2, 1  # 1C32:01
_MILLI = 1000.0
_POSITION_LIMIT = 0x607D
_DELAY_MAX = 10_000  # ns, of a line of six drives


class Limit(NamedTuple):
    """A limit of a drive, as it was written and as it was read back."""

    name: str
    written: int
    read: int


class Identity(NamedTuple):
    """What a drive's information memory says of it."""

    vendor: int
    product: int


class DriveIdentity(NamedTuple):
    """Identity, rated current and limits of a drive, as it reports them."""

    vendor: int
    product: int
    revision: int
    serial: int
    name: str
    rated_current: float  # A
    limits: tuple[Limit, ...] = ()


class Parameter(NamedTuple):
    """A parameter of the start-up list."""

    index: int  # pyright: ignore[reportIncompatibleMethodOverride]
    subindex: int
    size: int  # bytes
    value: int
    meaning: str


@dataclass
class BringUp:
    """A bus on its way up; lists are in the order of the bus."""

    carrier: Carrier
    config: DriveConfig
    answers: list[Identity] = field(default_factory=list)  # who answers, as expected or not
    identities: list[DriveIdentity] = field(default_factory=list)
    sync_start: int = 0  # system time of a SYNC0, ns; 0 without distributed clocks
    steps: list[str] = field(default_factory=list)
    _mailboxes: list[Mailbox] = field(default_factory=list)

    def bring_up(self) -> None:
        """Bring every drive to OP, without torque; process data must follow at once.

        Raises
        ------
        LinkError
            Saying which drive does not answer, or is not what the configuration expects.
        """
        self.find()
        self.prepare()
        self.operate()

    def find(self) -> None:
        """Count and address the drives and compare their identity with the configuration."""
        count = self.carrier.exchange(Datagram(BRD, 0, REGISTER_TYPE, b"\0"))[0].working_counter
        if count != NODES:
            raise LinkError(f"{count} drives on the bus, {NODES} expected")
        self._broadcast(REGISTER_AL_CONTROL, INIT | AL_ERROR)
        self._await(INIT)
        for node in range(NODES):
            address = struct.pack("<H", STATION + node)
            self._one(Datagram(APWR, -node, REGISTER_STATION_ADDRESS, address))
        self._clear(REGISTER_FMMU, 16 * 3)
        self._clear(REGISTER_SYNC_MANAGER, 8 * 4)
        self._broadcast(REGISTER_DC_ACTIVATION, 0, size=1)
        self._broadcast(REGISTER_SII_CONFIGURATION, 0, size=1)  # the master reads it, not the drive
        self.answers = [
            Identity(self._sii(node, _SII_VENDOR), self._sii(node, _SII_PRODUCT))
            for node in range(NODES)
        ]
        for node, (expected, (vendor, product)) in enumerate(
            zip(self.config.nodes, self.answers, strict=True)
        ):
            self._expect(node, "vendor", expected.vendor, vendor)
            self._expect(node, "product", expected.product, product)
        self.steps.append(f"{NODES} drives, identities as configured")

    def prepare(self) -> None:
        """Go to PREOP, write the start-up list, and set clocks, mappings and watchdog."""
        self._mailboxes = [self._open_mailbox(node) for node in range(NODES)]
        self._change(PREOP)
        self.identities = [self._identify(node) for node in range(NODES)]
        for node, config in enumerate(self.config.nodes):
            for parameter in startup_list(self.config, config):
                self._mailboxes[node].download(
                    parameter.index, parameter.subindex, parameter.value, parameter.size
                )
            limits = tuple(self._read_back(node, each) for each in limits_of(self.config, config))
            self.identities[node] = self.identities[node]._replace(limits=limits)
        self.steps.append("parameters written, limits read back")
        if self.config.link.distributed_clocks:
            self._set_clocks()
            self.steps.append("clocks distributed")
        for node in range(NODES):
            self._map(node)
        counts = round(self.config.link.watchdog / WATCHDOG_TICK)
        self._broadcast(
            REGISTER_WATCHDOG_DIVIDER, 2498
        )  # ticks of 100 us, in units of 40 ns less 2
        self._broadcast(REGISTER_WATCHDOG_PROCESS_DATA, counts)
        self._change(SAFEOP)
        self.steps.append("SAFEOP")

    def operate(self) -> None:
        """Exchange process data without torque until every drive is in OP."""
        outputs = struct.pack("<HhbB", 0, 0, CYCLIC_TORQUE, 0) * NODES
        deadline = time.monotonic() + _STATE_TIMEOUT
        op_requested = False
        distribute = ARMW if self.sync_start else NOP
        while True:
            answer = self.carrier.exchange(
                Datagram(LRD, INPUTS_AT, 0, bytes(NODES * INPUT_BYTES)),
                Datagram(LWR, OUTPUTS_AT, 0, outputs),
                Datagram(BRD, 0, REGISTER_AL_STATUS, bytes(2)),
                Datagram(distribute, 0, REGISTER_DC_SYSTEM_TIME, bytes(8)),
            )
            clocks_run = int.from_bytes(answer[3].data, "little") >= self.sync_start + _SETTLE
            counters = answer[0].working_counter, answer[1].working_counter
            # A drive refuses OP before it has outputs and, with clocks, SYNC0.
            if not op_requested and counters[1] == NODES and (clocks_run or not self.sync_start):
                self._broadcast(REGISTER_AL_CONTROL, OP)
                op_requested = True
            (status,) = struct.unpack("<H", answer[2].data)
            if op_requested and status & AL_ERROR:
                self._explain(OP)
            if status == OP and counters == (NODES, NODES):
                self.steps.append("OP")
                return
            if time.monotonic() > deadline:
                self._explain(OP)
                raise LinkError(
                    f"no OP: working counters {counters[0]} and {counters[1]}, {NODES} expected"
                )
            time.sleep(CONTROL_PERIOD)

    def shut_down(self) -> None:
        """Return every drive to INIT."""
        self._broadcast(REGISTER_AL_CONTROL, INIT | AL_ERROR)

    def _one(self, datagram: Datagram) -> bytes:
        """Exchange a datagram that exactly one drive answers, and return its data."""
        (answer,) = self.carrier.exchange(datagram)
        if answer.working_counter == 0:
            place = -datagram.position if datagram.command == APWR else datagram.position - STATION
            raise LinkError(f"drive {place + 1} does not answer at register {datagram.offset:#06x}")
        return answer.data

    def _read(self, node: int, register: int, size: int) -> int:
        data = self._one(Datagram(FPRD, STATION + node, register, bytes(size)))
        return int.from_bytes(data, "little")

    def _write(self, node: int, register: int, value: int, size: int) -> None:
        data = value.to_bytes(size, "little")
        self._one(Datagram(FPWR, STATION + node, register, data))

    def _broadcast(self, register: int, value: int, *, size: int = 2) -> None:
        self.carrier.exchange(Datagram(BWR, 0, register, value.to_bytes(size, "little")))

    def _clear(self, register: int, size: int) -> None:
        self.carrier.exchange(Datagram(BWR, 0, register, bytes(size)))

    def _expect(self, node: int, what: str, expected: int, actual: int) -> None:
        if expected != actual:
            raise LinkError(
                f"nodes.{node}.{what}: drive {node + 1} is {actual:#x}, {expected:#x} expected"
            )

    def _change(self, state: int) -> None:
        self._broadcast(REGISTER_AL_CONTROL, state)
        self._await(state)

    def _await(self, state: int) -> None:
        deadline = time.monotonic() + _STATE_TIMEOUT
        while True:
            (answer,) = self.carrier.exchange(Datagram(BRD, 0, REGISTER_AL_STATUS, bytes(2)))
            (status,) = struct.unpack("<H", answer.data)
            if status == state and answer.working_counter == NODES:
                return
            if status & AL_ERROR and state != INIT:
                self._explain(state)
            if time.monotonic() > deadline:
                self._explain(state)
                raise LinkError(f"the drives do not reach {AL_STATES[state]}")
            time.sleep(0.002)

    def _explain(self, state: int) -> None:
        """Raise with the reason of the first drive that is not in a state."""
        for node in range(NODES):
            status = self._read(node, REGISTER_AL_STATUS, 2)
            if status != state:
                code = self._read(node, REGISTER_AL_STATUS_CODE, 2)
                raise LinkError(
                    f"drive {node + 1} stays in {AL_STATES.get(status & 0x0F, hex(status))} on the "
                    f"way to {AL_STATES[state]}: {AL_CODES.get(code, 'see its manual')} "
                    f"(AL status code {code:#06x})"
                )

    def _sii(self, node: int, word: int) -> int:
        """Read two words of a drive's information memory."""
        request = struct.pack("<HI", 0x0100, word)
        self._one(Datagram(FPWR, STATION + node, REGISTER_SII_CONTROL, request))
        deadline = time.monotonic() + _SII_TIMEOUT
        while self._read(node, REGISTER_SII_CONTROL, 2) & 0x8000:
            if time.monotonic() > deadline:
                raise LinkError(f"drive {node + 1}: its information memory does not answer")
        return self._read(node, REGISTER_SII_DATA, 4)

    def _open_mailbox(self, node: int) -> Mailbox:
        """Set sync managers 0 and 1 as the drive's information memory says."""
        receive, send = self._sii(node, _SII_RECEIVE), self._sii(node, _SII_SEND + 1)
        areas = [(area & 0xFFFF, area >> 16) for area in (receive, send)]
        for manager, ((address, size), control) in enumerate(
            zip(areas, (_MAILBOX_OUT, _MAILBOX_IN), strict=True)
        ):
            self._set_sync_manager(node, manager, address, size, control)
        return Mailbox(self.carrier, STATION + node, write=areas[0], read=areas[1])

    def _set_sync_manager(
        self, node: int, manager: int, address: int, size: int, control: int
    ) -> None:
        setting = struct.pack("<HHBBBB", address, size, control, 0, 1, 0)
        register = REGISTER_SYNC_MANAGER + 8 * manager
        self._one(Datagram(FPWR, STATION + node, register, setting))

    def _identify(self, node: int) -> DriveIdentity:
        box = self._mailboxes[node]
        identity = DriveIdentity(
            *(box.number(0x1018, i) for i in (1, 2, 3, 4)),
            name=box.upload(0x1008).rstrip(b"\0").decode("ascii", "replace"),
            rated_current=box.number(0x6075) / _MILLI,
        )
        rated = self.config.nodes[node].rated_current
        if abs(identity.rated_current - rated) > 0.5 / _MILLI:
            raise LinkError(
                f"nodes.{node}.rated_current = {rated:g} A: drive {node + 1} says "
                f"{identity.rated_current:g} A; a command would be of another size than meant"
            )
        if not box.number(0x6502) >> (CYCLIC_TORQUE - 1) & 1:
            raise LinkError(f"drive {node + 1} has no cyclic synchronous torque mode")
        return identity

    def _read_back(self, node: int, parameter: Parameter) -> Limit:
        """Return a limit as the drive has it; refuse a drive that did not take it."""
        index, subindex, size, written, meaning = parameter
        data = self._mailboxes[node].upload(index, subindex)
        read = int.from_bytes(data[:size], "little", signed=index == _POSITION_LIMIT)
        name = f"object {index:04X}:{subindex:02X}, {meaning}"
        if read != written:
            raise LinkError(
                f"drive {node + 1} did not take {name}: {written} written, {read} read back"
            )
        return Limit(name, written, read)

    def _set_clocks(self) -> None:
        """Measure the delays along the bus, set offsets, and start SYNC0 in every drive."""
        self.carrier.exchange(Datagram(BWR, 0, REGISTER_DC_RECEIVE_TIME, bytes(4)))
        # The same frame stamped the clocks of all drives; on a line, half of what it took from a
        # drive to the end and back, less that of the next, is the way between them.
        local = [self._read(node, REGISTER_DC_RECEIVE_TIME_UNIT, 8) for node in range(NODES)]
        beyond = [self._time_beyond(node) for node in range(NODES)]
        for node in range(NODES):
            delay = min(max(0, (beyond[0] - beyond[node]) // 2), _DELAY_MAX)
            self._write(
                node,
                REGISTER_DC_SYSTEM_TIME_OFFSET,
                (local[0] + delay - local[node]) % (1 << 64),
                8,
            )
            self._write(node, REGISTER_DC_SYSTEM_TIME_DELAY, delay, 4)
            self._write(node, REGISTER_DC_CUC, 0, 1)
        ahead = self._read(0, REGISTER_DC_SYSTEM_TIME, 8) + _START_AHEAD
        self.sync_start = ahead - ahead % _PERIOD
        for node, config in enumerate(self.config.nodes):
            start = self.sync_start + round(config.sync_shift * 1e9)
            self._write(node, REGISTER_DC_SYNC0_CYCLE, _PERIOD, 4)
            self._write(node, REGISTER_DC_START_TIME, start, 8)
            self._write(node, REGISTER_DC_ACTIVATION, _ACTIVE_SYNC0, 1)

    def _time_beyond(self, node: int) -> int:
        """Return how long a frame was beyond a drive of a line, ns."""
        data = self._one(Datagram(FPRD, STATION + node, REGISTER_DC_RECEIVE_TIME, bytes(8)))
        there, back = struct.unpack("<II", data)
        return (back - there) & 0xFFFF_FFFF if back else 0

    def _map(self, node: int) -> None:
        """Set sync managers 2 and 3 and map them into the logical address space."""
        areas = list(self._process_data_areas(node))
        parts = (
            (OUTPUTS_AT, OUTPUT_BYTES, _BUFFERED_OUT, 2),
            (INPUTS_AT, INPUT_BYTES, _BUFFERED_IN, 1),
        )
        for i, (base, size, control, access) in enumerate(parts):
            address = areas[2 + i]
            self._set_sync_manager(node, 2 + i, address, size, control)
            logical = base + node * size
            entry = struct.pack("<IHBBHBBBBH", logical, size, 0, 7, address, 0, access, 1, 0, 0)
            self._one(Datagram(FPWR, STATION + node, REGISTER_FMMU + 16 * i, entry))

    def _process_data_areas(self, node: int) -> Iterator[int]:
        """Yield the start address of each sync manager, from the information memory."""
        word = _SII_CATEGORIES
        while word < _SII_WORDS_MAX:
            header = self._sii(node, word)
            kind, words = header & 0xFFFF, header >> 16
            if kind == _SII_END:
                break
            if kind == _SII_SYNC_MANAGERS:
                for at in range(word + 2, word + 2 + words, 4):  # 8 bytes each
                    yield self._sii(node, at) & 0xFFFF
                return
            word += 2 + words
        raise LinkError(f"drive {node + 1}: its information memory lists no sync managers")


def limits_of(config: DriveConfig, node: NodeConfig) -> list[Parameter]:
    """Return the limits that a drive is to hold."""
    axis = getattr(config, node.axis)
    of_rated = round(_MILLI * axis.current_max / node.rated_current)
    limits = [
        Parameter(0x6072, 0, 2, of_rated, "largest torque, per mille of rated"),
        Parameter(0x6073, 0, 2, of_rated, "largest current, per mille of rated"),
    ]
    if node is config.nodes[axis.encoder - 1]:
        counts = sorted(
            round(axis.direction * (limit - axis.offset) / axis.resolution)
            for limit in (axis.position_min, axis.position_max)
        )
        limits += [
            Parameter(
                0x6065, 0, 4, round(axis.following_error / axis.resolution), "error window, counts"
            ),
            Parameter(0x6066, 0, 2, round(axis.following_error_time * _MILLI), "its time-out, ms"),
            Parameter(_POSITION_LIMIT, 1, 4, counts[0], "least position, counts"),
            Parameter(_POSITION_LIMIT, 2, 4, counts[1], "largest position, counts"),
        ]
    return limits


def startup_list(config: DriveConfig, node: NodeConfig) -> list[Parameter]:
    """Return what is written to a drive between PREOP and SAFEOP, in this order."""
    clocks = config.link.distributed_clocks
    return [
        *_mapping(RX_PDO, 0x1C12, OUTPUTS),
        *_mapping(TX_PDO, 0x1C13, INPUTS),
        Parameter(0x1C32, 1, 2, _SYNC0 if clocks else _SM_EVENT, "outputs act at SYNC0"),
        Parameter(0x1C33, 1, 2, _SYNC0 if clocks else _SM_EVENT, "inputs are latched at SYNC0"),
        Parameter(0x6060, 0, 1, CYCLIC_TORQUE, "mode: cyclic synchronous torque"),
        *limits_of(config, node),
    ]


def _mapping(pdo: int, assignment: int, entries: tuple[Entry, ...]) -> list[Parameter]:
    """Return the writes that map entries into a PDO and assign it."""
    return [
        Parameter(assignment, 0, 1, 0, "assignment off"),
        Parameter(pdo, 0, 1, 0, "mapping off"),
        *(
            Parameter(pdo, i, 4, entry.mapped, entry.name)
            for i, entry in enumerate(entries, start=1)
        ),
        Parameter(pdo, 0, 1, len(entries), "mapping on"),
        Parameter(assignment, 1, 2, pdo, "assigned"),
        Parameter(assignment, 0, 1, 1, "assignment on"),
    ]
