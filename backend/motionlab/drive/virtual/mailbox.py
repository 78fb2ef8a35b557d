"""Mail of a node: CANopen over EtherCAT, service data objects."""

from __future__ import annotations

import struct

from motionlab.drive.ethercat import PREOP, REGISTER_AL_STATUS
from motionlab.drive.virtual.al import MAILBOX_BYTES, MAILBOX_IN, MAILBOX_OUT
from motionlab.drive.virtual.layout import (
    ANSWER,
    ERROR_CODE,
    MAIL,
    MAIL_EPOCH,
    NODES,
    Arrays,
)
from motionlab.drive.virtual.objects import (
    NO_COMPLETE_ACCESS,
    NOT_SUPPORTED,
    UNKNOWN_COMMAND,
    Abort,
    Dictionary,
)

_HEADER = struct.Struct("<HHBB")  # length, address, channel and priority, type and counter
_SDO = struct.Struct("<HBHB")  # CoE header, command, index, subindex
_MAIL_ERROR, _COE = 0, 3
_EMERGENCY, _SDO_REQUEST, _SDO_RESPONSE = 1, 2, 3
_UNSUPPORTED_PROTOCOL, _INVALID_HEADER, _TOO_SHORT = 2, 4, 6

_DOWNLOAD, _UPLOAD, _ABORT = 1, 2, 4
"""Commands of a client, bits 5 to 7."""

_EXPEDITED, _SIZED, _COMPLETE = 0x02, 0x01, 0x10


class MailServer:
    """Answers the mail of all nodes, and reports their errors."""

    def __init__(self, s: Arrays, dictionaries: list[Dictionary]) -> None:
        self._s = s
        self._dictionaries = dictionaries
        self._last = [(0, b"")] * NODES  # epoch and content of the last mail of each node
        self._errors_sent = [0] * NODES  # error code of the last emergency of each node

    def serve(self) -> None:
        """Answer all mail that has arrived, and send emergencies, as far as there is room."""
        for n in range(NODES):
            node = self._s.nodes[n]
            if node[ANSWER]:
                continue
            if node[MAIL]:
                self._serve_node(n)
            elif node[ERROR_CODE] != self._errors_sent[n]:
                self._tell_error(n)

    def _tell_error(self, n: int) -> None:
        """Send an emergency: an error code, or 0 where the error has gone."""
        node = self._s.nodes[n]
        if self._s.memory[n, REGISTER_AL_STATUS] & 0x0F < PREOP:
            return
        epoch, code = int(node[MAIL_EPOCH]), int(node[ERROR_CODE])
        # Error code, error register 1001, and five bytes of the maker.
        body = struct.pack("<HHB5x", _EMERGENCY << 12, code, int(code != 0))
        self._send(n, epoch, _COE, 0, body)
        self._errors_sent[n] = code

    def _serve_node(self, n: int) -> None:
        node, memory = self._s.nodes[n], self._s.memory[n]
        epoch = int(node[MAIL_EPOCH])
        mail = memory[MAILBOX_OUT : MAILBOX_OUT + MAILBOX_BYTES].tobytes()
        node[MAIL] = 0
        counter = mail[5] >> 4 & 7
        if counter and self._last[n] == (epoch, mail):
            return  # the same mail again, because its datagram was lost on the way back
        self._last[n] = (epoch, mail)
        answer = self._answer(n, mail)
        if answer:
            self._send(n, epoch, answer[0], counter, answer[1])

    def _send(self, n: int, epoch: int, kind: int, counter: int, body: bytes) -> None:
        """Put a mail into the mailbox of a node, unless that was reset meanwhile."""
        node = self._s.nodes[n]
        if epoch != node[MAIL_EPOCH]:
            return
        head = _HEADER.pack(len(body), 0, 0, kind | counter << 4)
        content = (head + body).ljust(MAILBOX_BYTES, b"\0")
        self._s.memory[n, MAILBOX_IN : MAILBOX_IN + MAILBOX_BYTES] = bytearray(content)
        node[ANSWER] = 1  # last: from here on the master may read it

    def _answer(self, n: int, mail: bytes) -> tuple[int, bytes] | None:
        length, _, _, kind = _HEADER.unpack_from(mail)
        body = mail[_HEADER.size : _HEADER.size + length]
        if length > MAILBOX_BYTES - _HEADER.size:
            return _MAIL_ERROR, struct.pack("<HH", 1, _INVALID_HEADER)
        if kind & 0x0F == _COE and len(body) < _SDO.size + 4:
            return _MAIL_ERROR, struct.pack("<HH", 1, _TOO_SHORT)
        if kind & 0x0F != _COE or body[1] >> 4 != _SDO_REQUEST:
            return _MAIL_ERROR, struct.pack("<HH", 1, _UNSUPPORTED_PROTOCOL)
        _, command, index, subindex = _SDO.unpack_from(body)
        if command >> 5 == _ABORT:
            return None
        try:
            return _COE, self._transfer(self._dictionaries[n], body)
        except Abort as abort:
            # An abort is a request, whoever sends it.
            head = _SDO.pack(_SDO_REQUEST << 12, _ABORT << 5, index, subindex)
            return _COE, head + struct.pack("<I", abort.code)

    @staticmethod
    def _transfer(objects: Dictionary, body: bytes) -> bytes:
        _, command, index, subindex = _SDO.unpack_from(body)
        kind = command >> 5
        if kind not in (_UPLOAD, _DOWNLOAD):
            raise Abort(UNKNOWN_COMMAND)  # everything fits into one mail: no segments
        if command & _COMPLETE:
            raise Abort(NO_COMPLETE_ACCESS)
        if kind == _DOWNLOAD:
            data = _downloaded(command, body[_SDO.size :])
            exact = bool(command & _SIZED) or not command & _EXPEDITED
            objects.write(index, subindex, data, exact=exact)
            return _response(0x60, index, subindex, bytes(4))
        data = objects.read(index, subindex)
        if len(data) <= 4:
            code = 0x43 | (4 - len(data)) << 2
            return _response(code, index, subindex, data.ljust(4, b"\0"))
        return _response(0x41, index, subindex, struct.pack("<I", len(data)) + data)


def _downloaded(command: int, content: bytes) -> bytes:
    if command & _EXPEDITED:
        unused = command >> 2 & 3 if command & _SIZED else 0
        return content[: 4 - unused]
    size = int.from_bytes(content[:4], "little")
    if size != len(content) - 4:
        raise Abort(NOT_SUPPORTED)  # it continues in segments, which no object needs
    return content[4:]


def _response(command: int, index: int, subindex: int, content: bytes) -> bytes:
    return _SDO.pack(_SDO_RESPONSE << 12, command, index, subindex) + content
