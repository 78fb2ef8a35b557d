"""Service data objects over CoE: reading and writing a drive's parameters (ETG.1000.6)."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable

from motionlab.drive.ethercat import FPRD, FPWR, REGISTER_SYNC_MANAGER, Datagram
from motionlab.drive.link.carrier import Carrier, LinkError

_COE = 3
_REQUEST, _RESPONSE = 2, 3
_ABORT = 0x80
_FULL = 0x08  # sync manager status: the mailbox holds a message
_TIMEOUT = 3.0  # s, for an answer of a drive
_PATIENCE = 0.5  # s, for a frame that empties a mailbox
_EXPEDITED = 4  # bytes that fit without a length

ABORTS = {
    0x05030000: "toggle bit not alternated",
    0x05040001: "unknown command",
    0x06010000: "unsupported access",
    0x06010001: "write only",
    0x06010002: "read only",
    0x06020000: "no such object",
    0x06040041: "cannot be mapped",
    0x06040043: "incompatible parameter",
    0x06070010: "wrong length",
    0x06090011: "no such subindex",
    0x06090030: "out of range",
    0x06090031: "too large",
    0x06090032: "too small",
    0x08000020: "cannot be stored",
    0x08000021: "local control",
    0x08000022: "not in this state",
}


class _Unanswered(LinkError):
    """No answer in time."""


class Mailbox:
    """The mailbox of one drive.

    `write` and `read` are address and length of its receive and its send mailbox.
    """

    def __init__(
        self, carrier: Carrier, station: int, *, write: tuple[int, int], read: tuple[int, int]
    ) -> None:
        self._carrier = carrier
        self._station = station
        self._write = write
        self._read = read
        self._counter = 0

    def upload(self, index: int, subindex: int = 0) -> bytes:
        """Read an object.

        Raises
        ------
        LinkError
            If the drive refuses, or does not answer.
        """
        answer = self._ask(struct.pack("<BHB4x", 0x40, index, subindex), index, subindex)
        command = answer[0]
        if command & 0x02:  # expedited
            return answer[4 : 8 - (command >> 2 & 3)]
        (size,) = struct.unpack_from("<I", answer, 4)
        return answer[8 : 8 + size]

    def number(self, index: int, subindex: int = 0) -> int:
        """Read an object as an unsigned number."""
        return int.from_bytes(self.upload(index, subindex), "little")

    def download(self, index: int, subindex: int, value: int, size: int) -> None:
        """Write a number of `size` bytes, at most 4.

        Raises
        ------
        LinkError
            If the drive refuses, or does not answer.
        """
        command = 0x23 | (_EXPEDITED - size) << 2
        data = (value & (1 << 8 * size) - 1).to_bytes(_EXPEDITED, "little")
        self._ask(struct.pack("<BHB", command, index, subindex) + data, index, subindex)

    def _ask(self, sdo: bytes, index: int, subindex: int) -> bytes:
        """Send a request and return its answer; once more where a lost frame took that away."""
        try:
            return self._ask_once(sdo, index, subindex)
        except _Unanswered:
            return self._ask_once(sdo, index, subindex)

    def _ask_once(self, sdo: bytes, index: int, subindex: int) -> bytes:
        self._discard_old()
        self._counter = self._counter % 7 + 1
        body = struct.pack("<H", _REQUEST << 12) + sdo
        header = struct.pack("<HHBB", len(body), 0, 0, _COE | self._counter << 4)
        address, size = self._write
        message = (header + body).ljust(size, b"\0")
        name = f"object {index:04X}:{subindex:02X} of drive at {self._station:#x}"
        self._until(
            lambda: (
                self._carrier.exchange(Datagram(FPWR, self._station, address, message))[
                    0
                ].working_counter
            ),
            f"{name}: the mailbox does not take a message",
        )
        while True:
            self._until(self._has_message, f"{name}: no answer")
            answer = self._fetch()
            kind, service = answer[5] & 0x0F, struct.unpack_from("<H", answer, 6)[0] >> 12
            if kind != _COE or service not in {_REQUEST, _RESPONSE}:
                continue  # an emergency message, or one of another protocol
            body = answer[8 : 6 + struct.unpack_from("<H", answer)[0]].ljust(8, b"\0")
            if body[0] == _ABORT:
                (code,) = struct.unpack_from("<I", body, 4)
                raise LinkError(f"{name}: {ABORTS.get(code, 'refused')} (abort {code:#010x})")
            return body

    def _discard_old(self) -> None:
        while self._has_message():
            self._fetch()

    def _fetch(self) -> bytes:
        address, size = self._read
        read = Datagram(FPRD, self._station, address, bytes(size))
        return self._carrier.exchange(read, timeout=_PATIENCE)[0].data  # reading empties it

    def _has_message(self) -> bool:
        status = REGISTER_SYNC_MANAGER + 8 + 5  # of sync manager 1
        (answer,) = self._carrier.exchange(Datagram(FPRD, self._station, status, b"\0"))
        return bool(answer.data[0] & _FULL)

    @staticmethod
    def _until(done: Callable[[], object], failure: str) -> None:
        deadline = time.monotonic() + _TIMEOUT
        while not done():
            if time.monotonic() > deadline:
                raise _Unanswered(failure)
            time.sleep(0.001)
