"""Sockets that carry EtherCAT frames: UDP, or raw Ethernet."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Sequence

from motionlab.config.drive import LinkConfig
from motionlab.drive.ethercat import ETHERTYPE, Datagram, datagrams, ethernet_header, frame
from motionlab.errors import MotionLabError

_TRIES = 25
_TIMEOUT = 0.02  # s, of one try


class LinkError(MotionLabError):
    """The bus or a drive does not answer as it must."""

    kind = "drive-link"


class Carrier:
    """A connected socket, for the exchanges that are not cyclic.

    `header` precedes each frame: an Ethernet header, or nothing in UDP.

    Raises
    ------
    LinkError
        If there is no such interface or address, or no right to use it.
    """

    def __init__(self, link: LinkConfig) -> None:
        self._index = 0
        try:
            if link.carrier == "udp":
                family = socket.AF_INET6 if ":" in link.address else socket.AF_INET
                self.socket = socket.socket(family, socket.SOCK_DGRAM)
                self.socket.connect((link.address, link.port))
                self.header = b""
            else:
                self.socket = socket.socket(
                    socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE)
                )
                # Raw sockets have no peer: this one takes every EtherCAT frame of the card.
                self.socket.bind((link.interface, ETHERTYPE))
                self.header = ethernet_header(self.socket.getsockname()[4][:6])
        except PermissionError:
            raise LinkError(
                f"link.interface = {link.interface!r}: raw Ethernet needs the right CAP_NET_RAW"
            ) from None
        except OSError as error:
            where = (
                f"link.interface = {link.interface!r}"
                if link.carrier == "ethernet"
                else f"link.address = {link.address!r}"
            )
            raise LinkError(f"{where}: {error.strerror or error}") from None
        self.socket.setblocking(False)

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()

    def exchange(
        self, *sent: Datagram, tries: int = _TRIES, timeout: float = _TIMEOUT
    ) -> Sequence[Datagram]:
        """Send datagrams in one frame and return them as they come back.

        Raises
        ------
        LinkError
            If no answer comes after some tries.
        """
        for _ in range(tries):
            self._index = self._index + 1 & 0xFF
            numbered = [datagram._replace(index=self._index) for datagram in sent]
            try:
                self.socket.send(self.header + frame(numbered))
            except ConnectionRefusedError:  # of the frame before: no listener
                time.sleep(timeout)
                continue
            except OSError as error:
                raise LinkError(f"the link cannot send: {error.strerror}") from None
            if (answer := self._answer(timeout, len(sent))) is not None:
                return answer
        raise LinkError(
            f"no answer within {tries * timeout * 1e3:.0f} ms: check cable, power and address"
        )

    def _answer(self, timeout: float, count: int) -> Sequence[Datagram] | None:
        deadline = time.monotonic() + timeout
        while (left := deadline - time.monotonic()) > 0:
            if not select.select([self.socket], [], [], left)[0]:
                return None
            try:
                payload = self.socket.recv(2048)[len(self.header) :]
                answers = list(datagrams(payload))
            except (OSError, ValueError):
                continue
            if len(answers) == count and answers[0].index == self._index:
                return answers
        return None
