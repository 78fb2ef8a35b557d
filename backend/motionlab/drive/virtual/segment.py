"""A segment of six virtual drives: its arrays, its mail, its switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig, load_drive
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.drive.ethercat import (
    INIT,
    REGISTER_AL_CONTROL,
    REGISTER_AL_STATUS,
    REGISTER_DC_ACTIVATION,
    REGISTER_DC_CUC,
    REGISTER_DC_SPEED_START,
    REGISTER_DC_START_TIME,
    REGISTER_DC_SYNC0_CYCLE,
    REGISTER_DC_SYSTEM_TIME_OFFSET,
    REGISTER_DL_CONTROL,
    REGISTER_EVENT_MASK,
    REGISTER_FEATURES,
    REGISTER_FMMU,
    REGISTER_SII_CONFIGURATION,
    REGISTER_SII_CONTROL,
    REGISTER_STATION_ADDRESS,
    REGISTER_SYNC_MANAGER,
    REGISTER_TYPE,
    REGISTER_WATCHDOG_DIVIDER,
    REGISTER_WATCHDOG_PDI,
    REGISTER_WATCHDOG_PROCESS_DATA,
    REGISTER_WATCHDOG_STATUS,
)
from motionlab.drive.virtual import layout
from motionlab.drive.virtual.cia402 import INPUT_SYNC, OUTPUT_SYNC, SWITCH_ON_DISABLED
from motionlab.drive.virtual.datagrams import answer
from motionlab.drive.virtual.esc import SII_EIGHT_BYTES
from motionlab.drive.virtual.events import catch_up
from motionlab.drive.virtual.layout import NODES, Arrays, kept, new_arrays
from motionlab.drive.virtual.mailbox import MailServer
from motionlab.drive.virtual.objects import DEFAULTS, Dictionary, Identity
from motionlab.drive.virtual.sii import slave_information
from motionlab.drive.virtual.switches import (
    Switches,
    clear_switches,
    parse_switches,
    set_switches,
    switched,
)
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import INPUT_ROWS
from motionlab.lanes.bank import TABLES
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.timeline import Timeline
from motionlab.trajectories.reference import Reference

REVISION = 1
_POWER_ON_NS = 1_234_567
"""By how much longer each node has been on than the next one: local clocks differ."""

_WATCHDOG_TICKS = 200  # 20 ms
_WRITABLE = (
    (REGISTER_STATION_ADDRESS, 2),
    (REGISTER_DL_CONTROL, 4),
    (REGISTER_AL_CONTROL, 2),
    (REGISTER_EVENT_MASK, 2),
    (REGISTER_WATCHDOG_DIVIDER, 2),
    (REGISTER_WATCHDOG_PDI, 2),
    (REGISTER_WATCHDOG_PROCESS_DATA, 2),
    (REGISTER_SII_CONFIGURATION, 16),
    (REGISTER_FMMU, 16 * layout.FMMUS),
    (REGISTER_DC_SYSTEM_TIME_OFFSET, 12),
    (REGISTER_DC_SPEED_START, 4),
    (REGISTER_DC_CUC, 2),
    (REGISTER_DC_START_TIME, 8),
    (REGISTER_DC_SYNC0_CYCLE, 8),
    (layout.PROCESS_MEMORY, layout.MEMORY - layout.PROCESS_MEMORY),
)


def default_drive() -> DriveConfig:
    """Return the link that ships for the virtual drive."""
    return load_drive(config_root() / "drives" / "virtual.toml")


def mounted(
    drive: DriveConfig, *, offset: tuple[float, float] | None = None, swapped: str = ""
) -> DriveConfig:
    """Return a link whose machine was put together otherwise.

    `offset` is the position at count 0 of the encoders of x and y, m; `swapped` names axes whose
    cables of phases b and c are exchanged.
    """
    other = {"a": "a", "b": "c", "c": "b"}
    changes: dict[str, Any] = {
        "nodes": tuple(
            node.model_copy(update={"phase": other[node.phase]}) if node.axis in swapped else node
            for node in drive.nodes
        )
    }
    for axis, place in zip(AXES, offset or (), strict=False):
        changes[axis] = getattr(drive, axis).model_copy(update={"offset": place})
    return drive.model_copy(update=changes)


class Segment:
    """Six virtual drives with a motor behind them.

    `changes` are of the motor, by dotted path, such as ``{"plant.x.encoder.noise": 1e-8}``; `start`
    is in m, `now` in ns since 2000-01-01.

    Raises
    ------
    ConfigError
        If there is no such motor, or it is moved by ideal forces.
    """

    def __init__(  # noqa: PLR0913 - the options of the command
        self,
        motor: str = "nominal",
        drive: DriveConfig | None = None,
        *,
        changes: Mapping[str, Any] | None = None,
        start: tuple[float, float] = (0.0, 0.0),
        seed: int = 0,
        serials: Sequence[int] = range(1, NODES + 1),
        now: int = 0,
    ) -> None:
        self.drive = default_drive() if drive is None else drive
        scenario = load_scenario("circle", {"plant": motor, "seed": seed, **(changes or {})})
        if scenario.plant.force == "ideal":
            raise ConfigError(
                FieldError("motor", "is moved by ideal forces: drives need currents", motor)
            )
        self.arrays, self._kept = _arrays(self.drive, scenario, start, serials)
        s = self.arrays
        s.clock[[layout.LAST, layout.PLANT_TIME]] = now
        s.clock[layout.RANDOM] = 1 + seed % 2_147_483_646
        s.nodes[:, [layout.LAST_STEP, layout.LAST_OUTPUT]] = now
        # Nodes do not power on at once, so their clocks differ.
        s.nodes[:, layout.CLOCK] = (NODES - np.arange(NODES)) * _POWER_ON_NS - now
        resolutions = [getattr(self.drive, axis).resolution for axis in AXES]
        self._mail = MailServer(
            s,
            [
                Dictionary(
                    s,
                    n,
                    Identity(node.vendor, node.product, REVISION, serials[n]),
                    resolutions[s.wiring[n, 2]] if s.wiring[n, 2] >= 0 else 0.0,
                )
                for n, node in enumerate(self.drive.nodes)
            ],
        )

    def exchange(self, payload: bytes, now: int) -> bytes | None:
        """Return the answer to a frame that arrives at `now`, or None where none comes back.

        Mail is answered before it returns.
        """
        frame = np.frombuffer(bytearray(payload.ljust(1, b"\0")), dtype=np.uint8)
        came_back = answer(self.arrays, frame, 0, len(payload), now)
        self.serve_mail()
        return frame[: len(payload)].tobytes() if came_back else None

    def advance(self, now: int) -> None:
        """Let everything happen that is due until `now`."""
        run_until(self.arrays, now)

    def serve_mail(self) -> None:
        """Answer mail that has arrived."""
        self._mail.serve()

    def switch(self, switches: Switches | None = None, **changes: Any) -> None:
        """Set fault switches, by keyword or as validated.

        Raises
        ------
        ConfigError
            Naming every field that is wrong.
        """
        set_switches(self.arrays, parse_switches(changes) if switches is None else switches)

    def status(self) -> dict[str, Any]:
        """Return switches in effect, counters, and the state of every node."""
        s = self.arrays
        counters = dict(zip(_COUNTERS, s.counters.tolist(), strict=True))
        nodes = [
            {
                "al_state": int(s.memory[n, REGISTER_AL_STATUS]),
                "status_word": int(s.nodes[n, layout.STATUS_WORD]),
                "error_code": int(s.nodes[n, layout.ERROR_CODE]),
                "position": int(s.nodes[n, layout.POSITION]),
                "current": int(s.nodes[n, layout.TARGET]) * 1e-3,
                "missed": int(s.nodes[n, layout.MISSED]),
            }
            for n in range(NODES)
        ]
        return {"switches": switched(s), "counters": counters, "nodes": nodes}

    @property
    def position(self) -> tuple[float, float]:
        """True position of the mover, m."""
        return float(self.arrays.plant[0, 0]), float(self.arrays.plant[0, 1])


_COUNTERS = (
    "frames",
    "malformed",
    "lost",
    "watchdogs",
    "skipped_ns",
    "latest_output_ns",
    "earliest_output_ns",
)


@kept
def run_until(s: Arrays, now: int) -> None:
    """Let everything happen that is due until `now`."""
    catch_up(s, now)


def _arrays(
    drive: DriveConfig, scenario: Scenario, start: tuple[float, float], serials: Sequence[int]
) -> tuple[Arrays, tuple[NDArray[np.float64], ...]]:
    """Return a segment at power-on, and what has to live as long as it: it holds an address."""
    parameters, tables = lane_parameters(scenario), TABLES.values
    s = new_arrays()
    nodes, wiring = s.nodes, s.wiring
    nodes[:, layout.DRIVE_STATE] = SWITCH_ON_DISABLED
    nodes[:, layout.SYNC_NEXT] = layout.NEVER
    wiring[:] = -1
    for n, node in enumerate(drive.nodes):
        _power_on(s.memory[n])
        image = slave_information(node.vendor, node.product, REVISION, serials[n])
        s.eeprom[n] = np.frombuffer(image, dtype=np.uint8)
        wiring[n, :2] = AXES.index(node.axis), "abc".index(node.phase)
    axes = [getattr(drive, axis) for axis in AXES]
    # An encoder is read by one drive of its axis alone.
    for lane, axis in enumerate(axes):
        wiring[axis.encoder - 1, 2] = lane
    s.scales[:] = [[axis.direction, axis.resolution, axis.offset] for axis in axes]
    s.defaults[:] = [DEFAULTS[i] for i in range(layout.OBJECT_COLUMNS)]
    s.objects[:] = s.defaults
    s.ratings[:] = [round(1e3 * node.rated_current) for node in drive.nodes]
    s.writable[:] = _writable()
    s.counters[layout.EARLIEST] = layout.CONTROL_PERIOD_NS
    s.plant[:] = initial_state(1, start)[0, : layout.PLANT_ROWS]
    s.measured[:] = s.plant[:1]
    s.parameters[:] = parameters[0]
    s.tables[:] = tables.ctypes.data, tables.size
    inputs = _inputs(scenario)
    s.inputs[: len(inputs)] = inputs
    s.clock[layout.PERIODS] = len(inputs)
    clear_switches(s)
    return s, (parameters, tables)


def _power_on(memory: NDArray[np.uint8]) -> None:
    """Write the registers as a node has them at power-on."""
    # Type and revision are no maker's. FMMUs, sync managers, kilobytes, ports 0 and 1 MII.
    head = (0xF0, 1, 0, 0, layout.FMMUS, layout.SYNC_MANAGERS, 4, 0x0F)
    memory[REGISTER_TYPE : REGISTER_TYPE + 8] = head
    for register, value in (
        (REGISTER_FEATURES, 0x000C),  # distributed clocks, 64 bits wide
        (REGISTER_AL_STATUS, INIT),
        (REGISTER_AL_CONTROL, INIT),
        (REGISTER_WATCHDOG_DIVIDER, 2498),
        (REGISTER_WATCHDOG_PDI, 1000),
        (REGISTER_WATCHDOG_PROCESS_DATA, _WATCHDOG_TICKS),
        (REGISTER_WATCHDOG_STATUS, 1),
        (REGISTER_SII_CONTROL, SII_EIGHT_BYTES),
    ):
        memory[register : register + 2] = tuple(value.to_bytes(2, "little"))
    for k in (OUTPUT_SYNC, INPUT_SYNC):
        memory[REGISTER_SYNC_MANAGER + 8 * k + 7] = 1


def _writable() -> NDArray[np.uint8]:
    mask = np.zeros(layout.MEMORY, dtype=np.uint8)
    for first, count in _WRITABLE:
        mask[first : first + count] = 0xFF
    mask[REGISTER_DC_ACTIVATION] = 0x07
    for k in range(layout.SYNC_MANAGERS):
        first = REGISTER_SYNC_MANAGER + 8 * k
        mask[first : first + 5] = 0xFF
        mask[first + 6] = 0x03
    return mask


def _inputs(scenario: Scenario) -> NDArray[np.float64]:
    """Return noise and ripple as the simulation draws them; without any load."""
    rest = np.zeros((1, 2))
    reference = Reference(rest, rest, rest, (0.0, 0.0), (), (0, 1), (), (), 0)
    timeline = Timeline(reference, rest, endless=True)

    def page(number: int) -> NDArray[np.float64]:
        return page_inputs(scenario, timeline, number)[:, :INPUT_ROWS]

    first = page(0)
    if not first.any():
        return first[:1].copy()
    others = range(1, layout.NOISE_PERIODS // PAGE)
    return np.concatenate([first, *(page(k) for k in others)])
