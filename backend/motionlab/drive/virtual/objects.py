"""The object dictionary of a node: what service data objects read and write."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from motionlab import __version__
from motionlab.drive.ethercat import OP, PREOP, REGISTER_AL_STATUS, REGISTER_SYNC_MANAGER
from motionlab.drive.process_data import CYCLIC_TORQUE, INPUTS, OUTPUTS, RX_PDO, TX_PDO, Entry
from motionlab.drive.virtual import layout
from motionlab.drive.virtual.al import BY_OUTPUTS, BY_SYNC0
from motionlab.drive.virtual.cia402 import OUTPUT_SYNC
from motionlab.drive.virtual.layout import Arrays

# Abort codes, ETG.1000.6
UNKNOWN_COMMAND = 0x0504_0001
NOT_SUPPORTED = 0x0601_0000
READ_ONLY = 0x0601_0002
NO_COMPLETE_ACCESS = 0x0601_0004
NO_OBJECT, NO_SUBINDEX = 0x0602_0000, 0x0609_0011
WRONG_LENGTH = 0x0607_0010
OUT_OF_RANGE = 0x0609_0030
NOT_IN_THIS_STATE = 0x0800_0022

WITH_OUTPUTS = 34
"""Object 1C33:01: inputs are latched when outputs arrive."""

SYNC_TYPES = 0b111
"""Objects 1C32:04 and 1C33:04: free running, by outputs, by SYNC0."""

PROFILE = 402
DEVICE_TYPE = PROFILE | 0x0002 << 16  # a servo drive
CYCLIC_TORQUE_SUPPORTED = 1 << 9
STO_INPUT = 1 << 16
"""Bit of 60FD: the first of the maker's inputs, high while torque is safely off."""


class Abort(Exception):
    """A transfer that the node refuses, with its abort code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"SDO abort 0x{code:08X}")
        self.code = code


@dataclass(frozen=True)
class Item:
    """One value of the dictionary; without `write` it is read only."""

    kind: str  # u1, i1, u2, i2, u4, i4, or s for text
    read: Callable[[], int | str]
    write: Callable[[int], None] | None = None
    low: int = 0
    high: int = 0  # of what can be written

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return int(self.kind[1:])

    def encoded(self) -> bytes:
        """Return the value as it is transferred."""
        value = self.read()
        if isinstance(value, str):
            return value.encode("ascii")
        return (value & (1 << 8 * self.size) - 1).to_bytes(self.size, "little")

    def store(self, data: bytes, exact: bool) -> None:
        """Set the value from what was transferred, the beginning of it where it is not `exact`.

        Raises
        ------
        Abort
            If it cannot be written, has another size or lies outside its range.
        """
        if self.write is None:
            raise Abort(READ_ONLY)
        data = data if exact else data[: self.size]
        if len(data) != self.size:
            raise Abort(WRONG_LENGTH)
        value = int.from_bytes(data, "little", signed=self.kind[0] == "i")
        if not self.low <= value <= self.high:
            raise Abort(OUT_OF_RANGE)
        self.write(value)


@dataclass(frozen=True)
class Identity:
    """Object 1018 of a node."""

    vendor: int
    product: int
    revision: int
    serial: int


class Dictionary:
    """Objects of one node.

    `resolution` is the size of a count of its encoder, m; 0 without one.
    """

    def __init__(self, s: Arrays, n: int, identity: Identity, resolution: float) -> None:
        self._s, self._n = s, n
        self._pdo_counts = {0x1C12: 1, 0x1C13: 1, RX_PDO: len(OUTPUTS), TX_PDO: len(INPUTS)}
        self._items: dict[tuple[int, int], Item] = {}
        self._add_device(identity)
        self._add_mappings()
        self._add_synchronisation()
        self._add_profile(resolution)

    def read(self, index: int, subindex: int) -> bytes:
        """Return an object's bytes.

        Raises
        ------
        Abort
            If there is none of that index or subindex.
        """
        return self._item(index, subindex).encoded()

    def write(self, index: int, subindex: int, data: bytes, *, exact: bool = True) -> None:
        """Set an object; without `exact` the data may be longer than it.

        Raises
        ------
        Abort
            If there is none, or it cannot be set to this.
        """
        self._item(index, subindex).store(data, exact)

    @property
    def indices(self) -> list[int]:
        """Every index there is, in order."""
        return sorted({index for index, _ in self._items})

    def _item(self, index: int, subindex: int) -> Item:
        item = self._items.get((index, subindex))
        if item is None:
            known = any(index == other for other, _ in self._items)
            raise Abort(NO_SUBINDEX if known else NO_OBJECT)
        return item

    def _constant(self, index: int, subindex: int, kind: str, value: int | str) -> None:
        self._items[index, subindex] = Item(kind, lambda: value)

    def _live(self, index: int, kind: str, column: int, subindex: int = 0) -> None:
        """Add an object that shows a column of the node's state."""
        node = self._s.nodes[self._n]
        self._items[index, subindex] = Item(kind, lambda: int(node[column]))

    def _setting(  # noqa: PLR0913, PLR0917 - a row of a table
        self, index: int, subindex: int, kind: str, column: int, low: int, high: int
    ) -> None:
        """Add an object that is lost at INIT."""
        settings = self._s.objects[self._n]

        def write(value: int) -> None:
            settings[column] = value

        self._items[index, subindex] = Item(kind, lambda: int(settings[column]), write, low, high)

    def _array(self, index: int, count: int) -> None:
        self._constant(index, 0, "u1", count)

    def _add_device(self, identity: Identity) -> None:
        self._constant(0x1000, 0, "u4", DEVICE_TYPE)
        node = self._s.nodes[self._n]
        self._items[0x1001, 0] = Item("u1", lambda: int(node[layout.ERROR_CODE] != 0))
        self._constant(0x1008, 0, "s", "Virtual current drive")
        self._constant(0x1009, 0, "s", "simulated")
        self._constant(0x100A, 0, "s", __version__)
        self._array(0x1018, 4)
        for i, value in enumerate(
            (identity.vendor, identity.product, identity.revision, identity.serial)
        ):
            self._constant(0x1018, i + 1, "u4", value)
        self._array(0x10F1, 2)
        self._constant(0x10F1, 1, "u4", 1)
        self._setting(0x10F1, 2, "u2", layout.SYNC_ERROR_LIMIT, 0, 65535)

    def _add_mappings(self) -> None:
        self._array(0x1C00, 4)
        for i, kind in enumerate((1, 2, 3, 4)):
            self._constant(0x1C00, i + 1, "u1", kind)
        self._fixed(0x1C12, "u2", (RX_PDO,))
        self._fixed(0x1C13, "u2", (TX_PDO,))
        self._fixed(RX_PDO, "u4", _mapped(OUTPUTS))
        self._fixed(TX_PDO, "u4", _mapped(INPUTS))

    def _fixed(self, index: int, kind: str, values: tuple[int, ...]) -> None:
        """Add a list that masters write although only one content is possible."""
        counts = self._pdo_counts

        def set_count(count: int) -> None:
            self._needs_preop()
            if count not in (0, len(values)):
                raise Abort(OUT_OF_RANGE)
            counts[index] = count

        self._items[index, 0] = Item("u1", lambda: counts[index], set_count, 0, 255)
        for i, value in enumerate(values):

            def set_value(_: int) -> None:
                self._needs_preop()
                if counts[index]:
                    raise Abort(NOT_SUPPORTED)  # the list has to be emptied first

            self._items[index, i + 1] = Item(
                kind, lambda value=value: value, set_value, value, value
            )

    def _needs_preop(self) -> None:
        if self._state() != PREOP:
            raise Abort(NOT_IN_THIS_STATE)

    def _state(self) -> int:
        """Return the state of the application layer; compiled functions cost a first caller 1 s."""
        return int(self._s.memory[self._n, REGISTER_AL_STATUS]) & 0x0F

    def _add_synchronisation(self) -> None:
        settings, node = self._s.objects[self._n], self._s.nodes[self._n]

        def set_type(value: int) -> None:
            self._needs_preop()
            settings[layout.SYNC_TYPE] = value

        def set_input_type(value: int) -> None:
            self._needs_preop()
            if value not in (0, BY_OUTPUTS, BY_SYNC0, WITH_OUTPUTS):
                raise Abort(OUT_OF_RANGE)  # inputs are latched when outputs act, by 1C32

        def input_type() -> int:
            return BY_SYNC0 if settings[layout.SYNC_TYPE] == BY_SYNC0 else WITH_OUTPUTS

        def set_cycle(value: int) -> None:
            settings[layout.CYCLE_TIME] = value

        self._items[0x1C32, 1] = Item(
            "u2", lambda: int(settings[layout.SYNC_TYPE]), set_type, 0, BY_SYNC0
        )
        self._items[0x1C33, 1] = Item("u2", input_type, set_input_type, 0, WITH_OUTPUTS)
        for index in (0x1C32, 0x1C33):
            self._array(index, 32)
            self._items[index, 2] = Item(
                "u4",
                lambda: int(node[layout.SYNC_CYCLE] or settings[layout.CYCLE_TIME]),
                set_cycle,
                0,
                2**32 - 1,
            )
            self._constant(index, 4, "u2", SYNC_TYPES)
            self._constant(index, 5, "u4", layout.STEP_NS)
            self._constant(index, 6, "u4", 0)
            self._live(index, "u2", layout.MISSED, 11)
            self._constant(index, 32, "u1", 0)

    def _add_profile(self, resolution: float) -> None:
        s, n = self._s, self._n
        self._live(0x603F, "u2", layout.ERROR_CODE)
        self._live(0x6041, "u2", layout.STATUS_WORD)
        self._live(0x6061, "i1", layout.MODE_DISPLAY)
        self._live(0x6064, "i4", layout.POSITION)
        self._live(0x606C, "i4", layout.VELOCITY)
        self._live(0x6077, "i2", layout.TORQUE)
        self._items[0x6040, 0] = Item("u2", lambda: self._output(0, 2))
        self._items[0x6071, 0] = Item("i2", lambda: self._output(2, 2))
        node = s.nodes[n]

        def set_mode(mode: int) -> None:
            if mode not in (0, CYCLIC_TORQUE):
                raise Abort(OUT_OF_RANGE)
            if self._state() != OP and mode:  # in OP the process data decides
                node[layout.MODE_DISPLAY] = mode

        self._items[0x6060, 0] = Item("i1", lambda: self._output(4, 1), set_mode, -128, 127)
        self._constant(0x6502, 0, "u4", CYCLIC_TORQUE_SUPPORTED)
        self._constant(0x6075, 0, "u4", int(s.ratings[n]))
        self._constant(0x6076, 0, "u4", int(s.ratings[n]))
        self._items[0x60FD, 0] = Item(
            "u4", lambda: STO_INPUT if s.switches[layout.STO] > 0.0 else 0
        )
        for index, subindex, kind, column, low, high in _SETTINGS:
            self._setting(index, subindex, kind, column, low, high)
        self._array(0x607D, 2)
        self._array(0x60C2, 2)
        if resolution:
            self._array(0x608F, 2)
            self._constant(0x608F, 1, "u4", round(1e-3 / resolution))  # counts in ...
            self._constant(0x608F, 2, "u4", 1)  # ... a millimetre

    def _output(self, at: int, size: int) -> int:
        memory = self._s.memory[self._n]
        register = REGISTER_SYNC_MANAGER + 8 * OUTPUT_SYNC
        first = int.from_bytes(memory[register : register + 2].tobytes(), "little")
        return int.from_bytes(memory[first + at : first + at + size].tobytes(), "little")


_S32 = 2**31 - 1
_SETTINGS = (
    (0x6065, 0, "u4", layout.FOLLOWING_WINDOW, 0, 2**32 - 1),
    (0x6066, 0, "u2", layout.FOLLOWING_TIMEOUT, 0, 65535),
    (0x6072, 0, "u2", layout.MAX_TORQUE, 0, 2000),
    (0x6073, 0, "u2", layout.MAX_CURRENT, 0, 2000),
    (0x607D, 1, "i4", layout.POSITION_MIN, -_S32, _S32),
    (0x607D, 2, "i4", layout.POSITION_MAX, -_S32, _S32),
    (0x6080, 0, "u4", layout.MAX_SPEED, 0, 2**32 - 1),
    (0x6085, 0, "u4", layout.QUICK_STOP_DECELERATION, 0, 2**32 - 1),
    (0x6087, 0, "u4", layout.TORQUE_SLOPE, 1000, 10_000_000),
    (0x60C2, 1, "u1", layout.INTERPOLATION_TIME, 1, 255),
    (0x60C2, 2, "i1", layout.INTERPOLATION_UNIT, -128, 63),
)
DEFAULTS = {
    layout.SYNC_TYPE: BY_OUTPUTS,
    layout.MAX_TORQUE: 1000,
    layout.MAX_CURRENT: 1000,
    layout.TORQUE_SLOPE: 100_000,  # from rated current to none in 10 ms
    layout.FOLLOWING_WINDOW: 2**32 - 1,  # off, as drives come
    layout.FOLLOWING_TIMEOUT: 0,
    layout.POSITION_MIN: -_S32,
    layout.POSITION_MAX: _S32,
    layout.MAX_SPEED: 2**32 - 1,
    layout.QUICK_STOP_DECELERATION: 2**32 - 1,
    layout.SYNC_ERROR_LIMIT: 4,
    layout.CYCLE_TIME: layout.CONTROL_PERIOD_NS,
    layout.INTERPOLATION_TIME: 5,
    layout.INTERPOLATION_UNIT: -4,
}
"""Settings of a node after INIT."""


def _mapped(entries: tuple[Entry, ...]) -> tuple[int, ...]:
    return tuple(entry.mapped for entry in entries)
