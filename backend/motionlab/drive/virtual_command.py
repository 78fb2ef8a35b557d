"""The command ``motionlab vdrive``."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import select
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from motionlab.errors import DONE, ConfigError, FieldError

_PORT = 34980
_PORT_MAX = 65_535
_SEED_MAX = 2**31 - 1
_DRIVES = 6
_SERIAL_MAX, _SERIAL_DIGITS = 2**32 - 1, 10


def add(commands: Any) -> None:
    """Add ``motionlab vdrive``."""
    parser = commands.add_parser(
        "vdrive",
        help="run a virtual drive: six simulated current drives on EtherCAT",
        description="Run a virtual drive: a software EtherCAT segment of six CiA 402 current "
        "drives with a simulated motor behind them, in UDP packets or on a network card. It is a "
        "test double, no EtherCAT device. It runs until interrupted.",
        epilog="While it runs, motionlab vdrive --switch drop=0.05 loses 5 % of its frames, and "
        "--switch clear=true ends that; `motionlab docs drive-virtual` has all switches.",
    )
    parser.add_argument("--motor", default="nominal", help="shipped motor (default: %(default)s)")
    parser.add_argument(
        "--set",
        dest="assignments",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="change the motor, such as plant.x.encoder.noise=1e-8 (repeatable)",
    )
    parser.add_argument(
        "--drive",
        type=Path,
        metavar="FILE",
        help="drive link whose nodes and encoders to be (default: configs/drives/virtual.toml)",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--address",
        type=_address,
        default=("127.0.0.1", _PORT),
        metavar="IP[:PORT]",
        help=f"where to answer in UDP; port 0 takes a free one (default: 127.0.0.1:{_PORT})",
    )
    where.add_argument(
        "--interface", metavar="CARD", help="answer on a network card, raw Ethernet, instead"
    )
    parser.add_argument(
        "--control",
        type=_whole("control", 0, _PORT_MAX),
        metavar="PORT",
        help="UDP port on 127.0.0.1 for switches; 0 takes a free one (the one after that of "
        f"--address, {_PORT + 1} with --interface)",
    )
    parser.add_argument(
        "--start", type=_pair, default=(0.0, 0.0), metavar="X,Y", help="position, m (default: 0,0)"
    )
    parser.add_argument(
        "--offset",
        type=_pair,
        metavar="X,Y",
        help="position at count 0 of each encoder, m (default: that of the drive link)",
    )
    parser.add_argument(
        "--swap",
        choices=("x", "y", "xy"),
        default="",
        help="axes whose cables of phases b and c are exchanged",
    )
    parser.add_argument(
        "--serials",
        type=_serials,
        default=tuple(range(1, 7)),
        metavar="N,N,N,N,N,N",
        help="serial numbers of the drives (default: 1,2,3,4,5,6)",
    )
    parser.add_argument(
        "--seed",
        type=_whole("seed", 0, _SEED_MAX),
        default=0,
        help="of noise and faults (default: %(default)s)",
    )
    parser.add_argument(
        "--drift", type=_drift, default=0.0, metavar="PPM", help="of its clock, +-1000 (default: 0)"
    )
    parser.add_argument(
        "--priority",
        type=_whole("priority", 0, 99),
        default=70,
        metavar="0..99",
        help="of the answering thread under SCHED_FIFO, if allowed; 0 does without "
        "(default: %(default)s)",
    )
    parser.add_argument(
        "--slow",
        type=_whole("slow", 1, 20),
        default=1,
        metavar="1..20",
        help="times slower than real time, as link.slow of the drive link, for tests and "
        "demonstrations on busy machines (default: %(default)s)",
    )
    parser.add_argument(
        "--switch",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="set a fault switch of the virtual drive that runs already (repeatable)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON on stdout")
    parser.add_argument("--until-eof", action="store_true", help="end when stdin does")
    parser.set_defaults(command=_vdrive)


def _whole(option: str, least: int, most: int) -> Callable[[str], int]:
    """Return what reads the value of an option that is a whole number."""

    def read(text: str) -> int:
        if not text.isdecimal() or not least <= int(text) <= most:
            what = "must be a whole number"
            raise ConfigError(FieldError(option, what, text, f"{least} to {most}"))
        return int(text)

    return read


def _address(text: str) -> tuple[str, int]:
    import ipaddress

    host, _, port = text.rpartition(":") if text.count(":") == 1 else (text, "", "")
    try:
        address = str(ipaddress.ip_address(host))
    except ValueError:
        what = "is no IP address with or without port"
        raise ConfigError(FieldError("address", what, text)) from None
    return address, _whole("address", 0, _PORT_MAX)(port) if port else _PORT


def _pair(text: str) -> tuple[float, float]:
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        x = y = float("nan")
    if not (abs(x) <= 1.0 and abs(y) <= 1.0):
        what = "must be a pair of positions such as 0.01,0"
        raise ConfigError(FieldError("start", what, text, "-1 to 1 m"))
    return x, y


def _serials(text: str) -> tuple[int, ...]:
    parts = text.split(",")
    known = [part.isdecimal() and len(part) <= _SERIAL_DIGITS for part in parts]
    if len(parts) != _DRIVES or not all(known) or max(map(int, parts)) > _SERIAL_MAX:
        what = f"must be {_DRIVES} whole numbers with commas between them"
        raise ConfigError(FieldError("serials", what, text, f"0 to {_SERIAL_MAX} each"))
    return tuple(map(int, parts))


def _drift(text: str) -> float:
    try:
        drift = float(text)
    except ValueError:
        drift = float("nan")
    if not abs(drift) <= 1000.0:
        raise ConfigError(FieldError("drift", "must be a number", text, "-1000 to 1000 ppm"))
    return drift * 1e-6


def _vdrive(options: argparse.Namespace) -> int:
    return _switch(options) if options.switch else _run(options)


def _control_port(options: argparse.Namespace) -> int:
    """Return the port for switches: that of --control, or the one after that of --address."""
    if options.control is not None:
        return options.control
    if options.address[1] == _PORT_MAX:
        raise ConfigError(FieldError("control", f"there is no port after {_PORT_MAX}: give one"))
    return options.address[1] + 1


def _switch(options: argparse.Namespace) -> int:
    """Set switches of a running virtual drive."""
    from motionlab.config.changes import parse_assignments
    from motionlab.drive.virtual.control import ask

    changes = parse_assignments(options.switch, "--switch")
    status = ask(_control_port(options), changes)
    if options.json:
        print(json.dumps(status))
        return DONE
    on = " ".join(f"{name}={value}" for name, value in status["switches"].items())
    counters = ", ".join(f"{name} {value}" for name, value in status["counters"].items())
    print(f"switched on: {on}" if on else f"taken: {', '.join(changes)}; no fault is on")
    print(counters)
    return DONE


def _run(options: argparse.Namespace) -> int:
    """Answer until interrupted."""
    from motionlab.config.changes import parse_assignments
    from motionlab.config.drive import load_drive
    from motionlab.drive.virtual.segment import Segment, mounted
    from motionlab.drive.virtual.server import (
        Server,
        open_ethernet,
        open_pair,
        open_udp,
        wall_clock,
    )

    drive = load_drive("virtual" if options.drive is None else options.drive)
    drive = mounted(drive, offset=options.offset, swapped=options.swap)
    segment = Segment(
        options.motor,
        drive,
        changes=parse_assignments(options.assignments),
        start=options.start,
        seed=options.seed,
        serials=options.serials,
        now=wall_clock(),
    )
    address, port = options.address
    where = options.interface or address
    if options.interface or port or options.control is not None:
        control = _control_port(options)
        opened = open_ethernet(where) if options.interface else open_udp(address, port)
    else:
        opened, control = open_pair(address)
    with Server(
        segment,
        opened,
        control_port=control,
        drift=options.drift,
        priority=options.priority,
        slow=options.slow,
    ) as server:
        ports = {"at": where, "port": server.port, "control_port": server.control_port}
        if options.json:
            print(json.dumps(ports), flush=True)
        else:
            at = f"{where}:{server.port}" if server.port else where
            print(
                f"Virtual drive, motor {options.motor}, at {at}; switches at UDP port "
                f"{server.control_port}. It is a test double, no EtherCAT device.",
                flush=True,
            )
        _end_at_sigterm()
        with contextlib.suppress(KeyboardInterrupt):
            server.run(_stdin_ended if options.until_eof else lambda: False)
    return DONE


def _end_at_sigterm() -> None:
    def end(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, end)


def _stdin_ended() -> bool:
    ready, _, _ = select.select([sys.stdin], [], [], 0.0)
    return bool(ready) and not os.read(sys.stdin.fileno(), 1024)
