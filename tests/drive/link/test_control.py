"""The loop's controller is that of the simulation, bit for bit on the same positions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.load import epochs, load_scenario
from motionlab.drive import loop_parameters
from motionlab.drive.link.bus import Inputs
from motionlab.drive.link.commanding import UNKNOWN
from motionlab.drive.link.shared import Command, State, Status
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.errors import ConfigError
from motionlab.kernel.layout import state_row
from motionlab.telemetry.channels import CHANNELS, Sample
from motionlab.timing import CONTROL_PERIOD
from tests.drive.link.lockstep import Lockstep
from tests.simulated import SHORT, Played, play

LAWS = ("off", "lugre-observer", "published-k", "residual-k", "canudas-de-wit", "reversed-k")
MACHINE = {
    "current_a",
    "current_b",
    "current_c",
    "load_force",
} | {CHANNELS[row].name for row in UNKNOWN}
"""Channels of the machine: the drives' own currents, and what nothing measures."""
B = "variants.B.controller"
TICKS = round(0.5 / CONTROL_PERIOD)
TABLES: dict[str, dict[str, Any]] = {
    "maps of both axes": {
        f"{B}.model.x.force_map": "new-design",
        f"{B}.model.y.force_map": "previous-design",
        f"{B}.sharing.law": "force-per-ampere",
    },
    "a map of one axis": {f"{B}.model.y.force_map": "new-design"},
    "a sharing function": {f"{B}.sharing.law": "sine"},
    "a map of the simulated machine": {"plant.force_map": "new-design"},
}


class Replaying(Lockstep):
    """A loop whose encoders read what a recording says.

    Parameters
    ----------
    recorded : ndarray, shape (2, ticks)
        Positions of x and y, m.
    """

    def __init__(self, recorded: NDArray[np.float32]) -> None:
        self.positions = recorded.astype(np.float64)
        self.tick = 0
        super().__init__()

    def _read(self) -> Inputs:
        read = super()._read()
        for axis in range(2):
            counts = np.rint(self.positions[axis, self.tick] / self.layout.resolution[axis])
            self.inputs["position"][self.layout.encoder[axis]] = counts
        return read


def replayed(simulated: Played, scenario_changes: Mapping[str, Any]) -> NDArray[np.float32]:
    """Return what the loop computes from a recording, with one set of parameters ahead.

    Shape (channels, axes, ticks).
    """
    row = Sample._fields.index("position_measured")
    loop = Replaying(simulated.samples("B")[row])
    ready = epochs(on_drives(load_scenario("circle", scenario_changes), "B"))
    changes = [(tick, held_parameters(scenario)) for tick, scenario in ready]
    loop.put(changes.pop(0)[1])
    loop.arm()
    source = simulated.prepared.reference
    loop.memory.state[:] = 0.0  # a simulation has held no position before
    loop.memory.state[state_row("failed")] = -1.0
    kinds = (source.position, source.velocity, source.acceleration)
    loop.follow(np.stack([values[:TICKS] for values in kinds], axis=1))
    command, status = loop.shared.command, loop.shared.status
    for tick in range(1, TICKS):
        loop.tick = tick
        if changes and status[Status.PARAMETERS] == command[Command.PARAMETERS]:
            first, parameters = changes.pop(0)
            loop.put(parameters, first)
        loop.cycle()
    if len(ready) > 1:
        assert status[Status.PARAMETERS_TICK] == ready[-1][0]
    assert loop.state == State.MOVING, loop.fault
    assert status[Status.END] == TICKS
    return loop.shared.samples[:TICKS].transpose(1, 2, 0)


def check(changes: dict[str, Any]) -> None:
    changes = SHORT | {f"{B}.delay": 1} | changes
    simulated = play("circle", changes)
    samples = simulated.samples("B")
    found = replayed(simulated, changes)
    assert np.abs(found[Sample._fields.index("force_command")]).max() > 1.0
    for row, channel in enumerate(CHANNELS):
        if channel.name not in MACHINE:
            np.testing.assert_array_equal(found[row], samples[row, :, :TICKS], channel.name)


@pytest.mark.parametrize("law", LAWS)
def test_a_recording_gives_the_same_bits_in_the_loop(law: str) -> None:
    check({f"{B}.compensation.law": law, f"{B}.disturbance_observer.enabled": True})


def test_so_it_does_over_changes_within_the_motion() -> None:
    gains = {f"{B}.x.k_p": 3e5, f"{B}.y.k_d": 900.0, f"{B}.compensation.law": "residual-k"}
    switches = {f"{B}.compensation.enabled": False, f"{B}.disturbance_observer.enabled": True}
    table = {f"{B}.model.x.force_map": "new-design"}
    schedule = [
        {"time": tick * CONTROL_PERIOD, "set": changes}
        for tick, changes in ((300, gains), (500, switches), (700, table))
    ]
    check({"schedule": schedule})


@pytest.mark.parametrize("name", TABLES)
def test_so_it_does_with_tables(name: str) -> None:
    check(TABLES[name])


def test_the_map_of_the_simulated_machine_stays_there() -> None:
    changes = TABLES["a map of the simulated machine"]
    given = held_parameters(on_drives(load_scenario("circle", changes), "B"))
    assert given.tables.size == 64
    assert given.tabled.all()


def test_tables_beyond_the_room_are_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = on_drives(load_scenario("circle", TABLES["maps of both axes"]), "B")
    size = held_parameters(scenario).tables.size
    monkeypatch.setattr(loop_parameters, "TABLE_NUMBERS", size)
    held_parameters(scenario)
    monkeypatch.setattr(loop_parameters, "TABLE_NUMBERS", size - 1)
    with pytest.raises(ConfigError, match=f"{B}.model.y.force_map: its tables are too large"):
        held_parameters(scenario)
