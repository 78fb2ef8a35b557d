"""A virtual drive on a socket: a thread that answers frames, another for mail and switches."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import selectors
import socket
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

from motionlab.drive.ethercat import ETHERTYPE
from motionlab.drive.virtual.control import LOOPBACK, DriveFailed
from motionlab.drive.virtual.frame_thread import MAC_HEADER, STOP, carrier, run_loop
from motionlab.drive.virtual.segment import Segment
from motionlab.errors import ConfigError, FieldError

EPOCH_2000 = 946_684_800_000_000_000
"""Unix time of 2000-01-01, ns."""

LINE_MAX = 4096
"""Longest line of switches, bytes."""

_TRIES = 20
_TURN = 0.1  # s


def open_udp(address: str, port: int, option: str = "address") -> socket.socket:
    """Return a socket for UDP packets.

    Raises
    ------
    ConfigError
        Naming the `option` of the command, if the address cannot be bound.
    """
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    opened = socket.socket(family, socket.SOCK_DGRAM)
    try:
        opened.bind((address, port))
    except OSError as error:
        opened.close()
        text = f"UDP port {port} of {address}: {error.strerror}"
        taken = error.errno == errno.EADDRINUSE
        raise ConfigError(
            FieldError(option, text, range="port 0, for a free one" if taken else "")
        ) from None
    return opened


def open_ethernet(interface: str) -> socket.socket:
    """Return a socket for EtherCAT frames on a network card.

    Raises
    ------
    ConfigError
        If there is no such card, it is down, or there is no right to it.
    """
    try:
        opened = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE))
    except PermissionError:
        raise ConfigError(
            FieldError("interface", "raw Ethernet needs root or the right CAP_NET_RAW", interface)
        ) from None
    try:
        opened.bind((interface, ETHERTYPE))
        # To bind to a card that is down succeeds; only its error tells.
        if failure := opened.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
            raise OSError(failure, f"{os.strerror(failure)}: ip link set {interface} up")
    except OSError as error:
        opened.close()
        cards = ", ".join(name for _, name in socket.if_nameindex())
        known = error.errno != errno.ENODEV
        raise ConfigError(
            FieldError(
                "interface",
                error.strerror if known and error.strerror else "no such network card",
                interface,
                range="" if known else f"one of {cards}",
            )
        ) from None
    return opened


class Server:
    """A segment on a socket, which it closes at the end.

    The segment's clock should begin at `wall_clock`; by `drift`, 1, it is fast. Control port 0
    takes a free one; priority 0 does without SCHED_FIFO.
    """

    def __init__(  # noqa: PLR0913 - the options of the command
        self,
        segment: Segment,
        on: socket.socket,
        *,
        control_port: int = 0,
        drift: float = 0.0,
        priority: int = 0,
        slow: int = 1,
    ) -> None:
        self.segment = segment
        self._on = on
        self._priority = priority
        raw = on.family == socket.AF_PACKET
        self.port = 0 if raw else int(on.getsockname()[1])
        try:
            self._control = open_udp(LOOPBACK, control_port, "control")
        except ConfigError:
            on.close()
            raise
        self.control_port = int(self._control.getsockname()[1])
        self._mail_event = os.eventfd(0, os.EFD_NONBLOCK)
        header = MAC_HEADER if raw else 0
        self._carrier = carrier(on.fileno(), header, self._mail_event, drift, slow)
        self._thread = threading.Thread(target=self._answer, name="vdrive", daemon=True)
        self.real_time = False

    def __enter__(self) -> Server:
        """Start to answer, at once: what is not compiled yet is compiled first."""
        self._carrier.numbers[STOP] = 1
        run_loop(self.segment.arrays, self._carrier)
        self._carrier.numbers[STOP] = 0
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Stop, and close the sockets."""
        self._carrier.numbers[STOP] = 1
        self._thread.join()
        self._on.close()
        self._control.close()
        os.close(self._mail_event)

    def run(self, ended: Callable[[], bool] = lambda: False) -> None:
        """Answer mail and switches until `ended`, which is asked every tenth of a second."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._mail_event, selectors.EVENT_READ)
            selector.register(self._control, selectors.EVENT_READ)
            while not ended():
                for key, _ in selector.select(_TURN):
                    if key.fileobj is self._control:
                        self._answer_switches()
                    else:
                        with contextlib.suppress(BlockingIOError):
                            os.eventfd_read(self._mail_event)
                self.segment.serve_mail()

    def _answer(self) -> None:
        if self._priority:
            with contextlib.suppress(OSError):  # without the right to it, it runs as it is
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(self._priority))
                self.real_time = True
        run_loop(self.segment.arrays, self._carrier)

    def _answer_switches(self) -> None:
        line, sender = self._control.recvfrom(LINE_MAX)
        reply: dict[str, Any]
        try:
            document = json.loads(line or b"{}")
            if not isinstance(document, dict):
                raise ConfigError(FieldError("switches", "is no JSON object"))
            self.segment.switch(**document)
            reply = self.segment.status()
        except (ValueError, RecursionError) as error:
            reply = {"error": f"no JSON: {error}"}
        except (ConfigError, TypeError) as error:
            reply = {"error": str(error)}
        with contextlib.suppress(OSError):
            self._control.sendto(json.dumps(reply).encode(), sender)


def wall_clock() -> int:
    """Return the time, ns since 2000-01-01."""
    return time.time_ns() - EPOCH_2000


def open_pair(address: str) -> tuple[socket.socket, int]:
    """Return a socket on a free UDP port whose next port is free on loopback, and that one.

    Raises
    ------
    DriveFailed
        If none is found.
    """
    for _ in range(_TRIES):
        opened = open_udp(address, 0)
        following = int(opened.getsockname()[1]) + 1
        try:
            open_udp(LOOPBACK, following).close()
        except (ConfigError, OverflowError):
            opened.close()
            continue
        return opened, following
    raise DriveFailed("no two free UDP ports in a row")
