"""The machine's half of a control period: the plant under the command in effect."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.effects.effect import MidStep
from motionlab.kernel.effect_calls import Effects, Resisted, resist
from motionlab.kernel.layout import Command, Inputs, Parameters, PlantState
from motionlab.lanes import Lanes, compiled, select
from motionlab.plant.current import settled_current
from motionlab.plant.friction import LuGre, friction_force
from motionlab.plant.machine import IdealForce, Machine, middle_of, moved, substep
from motionlab.plant.magnetics import Phases
from motionlab.plant.mechanics import end_stop_force
from motionlab.plant.table_map import normal_force_of
from motionlab.timing import PLANT_STEP, SUBSTEPS

_INSTANT = 1e-9
"""Step, s, over which effects are asked for their force at an instant."""


class Driven(NamedTuple):
    """What holds over a control period."""

    machine: Machine
    target: Phases  # currents that are approached, A
    ideal: IdealForce


@compiled
def driven(par: Parameters, acting: Command, at: Inputs) -> Driven:
    """Return the machine and the command in effect."""
    ideal = IdealForce(par.controller.ideal_force > 0.0, acting.force)
    disturbance = Phases(at.current_a, at.current_b, at.current_c)
    command = Phases(acting.current_a, acting.current_b, acting.current_c)
    target = settled_current(par.amplifiers, command, disturbance)
    machine = Machine(par.amplifiers, par.force_map, par.mechanics, par.friction, par.resonance)
    return Driven(machine, target, ideal)


@compiled
def move(
    par: Parameters,
    s: PlantState,
    acting: Command,
    at: Inputs,
    tables: NDArray[np.float64] | None,
) -> PlantState:
    """Return the machine's state a period later, after currents followed their commands."""
    machine, target, ideal = driven(par, acting, at)
    for _ in range(SUBSTEPS):
        s = substep(machine, s, target, at.load, ideal, tables, PLANT_STEP)
    return s


@compiled
def resisted_now(  # noqa: PLR0913, PLR0917 - what effects may know
    par: Parameters, s: PlantState, thrust: Lanes, normal: Lanes, time: Lanes, effects: Effects
) -> Resisted:
    """Return the forces of effects at an instant: those of a step that hardly lasts."""
    M = par.mechanics.M
    seen = MidStep(s.p, s.v, time, s.i_a, s.i_b, s.i_c, normal, thrust, M, _INSTANT + 0.0 * M)
    return resist(effects, seen, 0.0 * M)


@compiled
def move_resisted(  # noqa: PLR0913, PLR0917 - as `move`, and the effects
    par: Parameters,
    s: PlantState,
    acting: Command,
    at: Inputs,
    tables: NDArray[np.float64] | None,
    effects: Effects,
    resistance: Lanes,
    time: Lanes,
) -> PlantState:
    """Do what `move` does against effects, whose force at the start, N, and time, s, are given.

    The velocity of a step's middle is predicted with the force of the step before. A force F with
    damping D, given for the velocity v_m that was predicted, acts as ``F + D (v - v_m)`` on the
    mean velocity v of the step: so stiff friction is no limit for the step.
    """
    machine, target, ideal = driven(par, acting, at)
    friction, M, h = machine.friction, par.mechanics.M, PLANT_STEP + 0.0 * par.mechanics.M
    for step in range(SUBSTEPS):
        middle = middle_of(machine, s, target, ideal, tables, PLANT_STEP)
        i = middle.current
        stop = end_stop_force(machine.mechanics, middle.p, s.v)
        net = middle.force + stop - at.load - friction_force(friction, s.v, s.z) - resistance
        v_mid = s.v + (0.5 * PLANT_STEP) * net / M
        attraction = normal_force_of(par.force_map, tables, middle.p, i)
        seen = MidStep(
            s.p + (0.25 * PLANT_STEP) * (s.v + v_mid),
            v_mid,
            time + (step + 0.5) * PLANT_STEP,
            i.a,
            i.b,
            i.c,
            select(ideal.acts, 0.0, attraction),
            middle.force,
            M,
            h,
        )
        forces = resist(effects, seen, 1.0 + 0.0 * M)
        D = forces.damping
        damped = LuGre(
            friction.sigma_0,
            friction.sigma_1,
            friction.sigma_2 + D,
            friction.F_c,
            friction.F_s,
            friction.v_s,
        )
        slowed = Machine(par.amplifiers, par.force_map, par.mechanics, damped, par.resonance)
        v = s.v
        s = moved(slowed, s, middle, target, at.load + (forces.force - D * v_mid), PLANT_STEP)
        resistance = forces.force + D * (0.5 * (v + s.v) - v_mid)
    return s
