"""The thrust that the measured currents gave, by the controller's map at the measured position.

The force command is not the thrust: currents lag, and a command is held while the motor moves on,
over a place where its shares no longer fit. A control period between two samples is therefore
filled in. Currents approach where they settle at, and the position goes on evenly::

    i(s) = i_s + (i_k - i_s) r^s,   i_s = (i_{k+1} - r i_k)/(1 - r)
    p(s) = p_k + s (p_{k+1} - p_k)

for s from 0 to 1, with r what a period leaves of a deviation, read off commands and currents.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.config.plant import AmplifierConfig
from motionlab.control.over_pitch import forces_over
from motionlab.identify.rig import Rig
from motionlab.simulation.maps import map_lanes
from motionlab.telemetry.recording import VariantRecord

Array = NDArray[np.float64]

_PLACES = (np.arange(5) + 0.5) / 5.0
"""Where in a period the thrust is taken, as a share of it."""

_STEP = 0.01
"""Steps in which drives report a current, A: a per mille of their rated 10 A, as CiA 402 has it."""

_SLOWEST = 0.95
"""Largest share of a deviation that a period may leave: 16 Hz of bandwidth."""


def mean_thrust(rig: Rig, axis: str, record: VariantRecord) -> Array:
    """Return the mean thrust of every control period but the last, N.

    Parameters
    ----------
    rig : Rig
        Whose controller's map and loop delay are used.
    axis : str
        ``x`` or ``y``.
    record : VariantRecord
        Of one motion: current commands, currents as the drives report them, and the encoder's
        reading are read.

    Returns
    -------
    ndarray, shape (ticks - 1,)
        In the newtons of the controller's map.
    """
    if rig.scenario.plant.force == "ideal":  # has no currents: the command is the thrust
        return record.channel("force_command", axis)[:-1].astype(np.float64)
    model = map_lanes(rig.model(axis).force_map)
    position = record.channel("position_measured", axis).astype(np.float64)
    command = _phases(record, "current_command", axis)
    current = reported(
        _phases(record, "current", axis), getattr(rig.scenario.plant, axis).amplifiers
    )
    r = left_over(command, current, rig.controller.delay)
    start, end = current[:, :-1], current[:, 1:]
    settled = (end - r * start) / (1.0 - r)
    total = np.zeros(len(position) - 1)
    for s in _PLACES:
        place = position[:-1] + s * np.diff(position)
        passing = settled + (start - settled) * r**s
        total += forces_over(model.force_map, model.table, position=place, current=passing).thrust
    return total / len(_PLACES)


def reported(current: Array, amplifiers: AmplifierConfig) -> Array:
    """Return what the drives say of true currents, A, shape (3, n).

    An amplifier's gain and offset are its current sensor's: its loop brings what the sensor says,
    not the current, to the command. No experiment sees them.
    """
    gain, offset = (np.array([*each])[:, None] for each in (amplifiers.gain, amplifiers.offset))
    said = (current - offset) / np.where(gain > 0.0, gain, 1.0)
    return _STEP * np.round(said / _STEP)


def left_over(command: Array, current: Array, delay: int) -> float:
    """Return what a control period leaves of the difference between a current and its command, 1.

    Least squares of ``i_{k+1} - c = r (i_k - c)`` over all phases, with c the command that acts.

    Parameters
    ----------
    command, current : ndarray, shape (3, n)
        As recorded, A.
    delay : int
        Control periods from a command to its effect.
    """
    acts = command[:, : command.shape[1] - 1 - delay]
    before, after = current[:, delay:-1] - acts, current[:, delay + 1 :] - acts
    square = float(np.sum(before * before))
    if square == 0.0:
        return 0.0
    return float(np.clip(np.sum(before * after) / square, 0.0, _SLOWEST))


def _phases(record: VariantRecord, name: str, axis: str) -> Array:
    return np.stack([record.channel(f"{name}_{k}", axis) for k in "abc"]).astype(np.float64)
