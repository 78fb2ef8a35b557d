"""One axis of the machine under constant commands: amplifiers, thrust, guides, resonance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import Lanes, Mask, compiled, select
from motionlab.plant.current import Amplifiers, half_step
from motionlab.plant.friction import LuGre
from motionlab.plant.magnetics import Phases
from motionlab.plant.mechanics import Mechanics, Mover, advance, end_stop_force
from motionlab.plant.resonance import Resonance, ring
from motionlab.plant.table_map import MotorMap, thrust_of


class Machine(NamedTuple):
    """The parts of one axis."""

    amplifiers: Amplifiers
    force_map: MotorMap
    mechanics: Mechanics
    friction: LuGre
    resonance: Resonance


class PlantState(NamedTuple):
    """State of the machine."""

    p: Lanes  # position, m
    v: Lanes  # velocity, m/s
    z: Lanes  # bristle state, m
    y: Lanes  # deflection that the encoder sees, m
    y_rate: Lanes  # m/s
    i_a: Lanes  # phase currents, A
    i_b: Lanes
    i_c: Lanes


class IdealForce(NamedTuple):
    """A force that takes the place of the thrust."""

    acts: Mask
    force: Lanes  # N


class Middle(NamedTuple):
    """The middle of a step."""

    p: Lanes  # position, m
    force: Lanes  # thrust, N
    current: Phases  # A


@compiled
def middle_of(  # noqa: PLR0913, PLR0917 - as `substep`
    machine: Machine,
    s: PlantState,
    target: Phases,
    ideal: IdealForce | None,
    tables: NDArray[np.float64] | None,
    h: Lanes,
) -> Middle:
    """Return the middle of a step of `h` seconds in which currents approach `target`, A."""
    middle = half_step(machine.amplifiers, Phases(s.i_a, s.i_b, s.i_c), target)
    p_mid = s.p + (0.5 * h) * s.v
    force = thrust_of(machine.force_map, tables, p_mid, middle)
    if ideal is not None:
        force = select(ideal.acts, ideal.force, force)
    return Middle(p_mid, force, middle)


@compiled
def moved(  # noqa: PLR0913, PLR0917 - as `substep`
    machine: Machine, s: PlantState, middle: Middle, target: Phases, load: Lanes, h: Lanes
) -> PlantState:
    """Return the state `h` seconds later, of the thrust and the currents of the middle."""
    p_mid, force = middle.p, middle.force
    net = force - load + end_stop_force(machine.mechanics, p_mid, s.v)
    mover = advance(machine.mechanics, machine.friction, Mover(s.p, s.v, s.z), net, h)
    y, y_rate = ring(machine.resonance, s.y, s.y_rate, force)
    current = half_step(machine.amplifiers, middle.current, target)
    return PlantState(mover.p, mover.v, mover.z, y, y_rate, current.a, current.b, current.c)


@compiled
def substep(  # noqa: PLR0913, PLR0917 - what a motion depends on
    machine: Machine,
    s: PlantState,
    target: Phases,
    load: Lanes,
    ideal: IdealForce | None,
    tables: NDArray[np.float64] | None,
    h: Lanes,
) -> PlantState:
    """Return the state `h` seconds later.

    Currents approach `target`, A, against the `load`, N. The thrust is that of the middle.
    """
    middle = middle_of(machine, s, target, ideal, tables, h)
    return moved(machine, s, middle, target, load, h)
