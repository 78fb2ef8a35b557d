"""One axis of an exported motor, in one step.

Parameters are those of a scenario. They may change between two steps, and a step may have any
length: what a simulation computes once of both is computed here.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numpy.typing import NDArray

from motionlab.lanes import Lanes, select
from motionlab.plant.current import Amplifiers, settled_current
from motionlab.plant.encoder import Encoder, measure
from motionlab.plant.friction import LuGre, friction_force
from motionlab.plant.machine import Machine, PlantState, substep
from motionlab.plant.magnetics import AnalyticMap, Phases
from motionlab.plant.mechanics import Mechanics
from motionlab.plant.resonance import Resonance, sampled
from motionlab.plant.table_map import MotorMap, TableMap, normal_force_of, thrust_of


class CurrentLoops(NamedTuple):
    """Current amplifiers of three phases."""

    bandwidth: Lanes  # Hz; 0: currents follow at once
    gain_a: Lanes  # current per commanded current, 1
    gain_b: Lanes
    gain_c: Lanes
    offset_a: Lanes  # current at zero command, A
    offset_b: Lanes
    offset_c: Lanes
    limit: Lanes  # largest current either way, A


class Mode(NamedTuple):
    """A flexible mode of the mover."""

    frequency: Lanes  # Hz
    damping: Lanes  # damping ratio, 1
    coupling: Lanes  # deflection that the encoder sees, of the mode's, 1; 0: none


class PlantParameters(NamedTuple):
    """One axis of a motor."""

    mass: Lanes  # kg
    stroke: Lanes  # either way from the middle, m
    stop_distance: Lanes  # of the end stops beyond the stroke, m
    stop_stiffness: Lanes  # N/m
    stop_damping: Lanes  # N s/m
    position_start: Lanes  # m
    friction_on: Lanes  # 0: a frictionless axis
    friction: LuGre
    force_map: AnalyticMap
    map_gain: Lanes  # factor on the forces of a table, 1
    amplifiers: CurrentLoops
    encoder: Encoder
    resonance: Mode


class PlantInput(NamedTuple):
    """What acts on one axis."""

    current: Phases  # commands, A
    load: Lanes  # N, against positive positions
    encoder_noise: Lanes  # added before quantisation, m


class PlantOutput(NamedTuple):
    """Signals of one axis."""

    position: Lanes  # m
    position_measured: Lanes  # m
    velocity: Lanes  # m/s
    friction: Lanes  # N
    bristle: Lanes  # m
    thrust: Lanes  # N
    normal_force: Lanes  # N
    current_a: Lanes  # A
    current_b: Lanes
    current_c: Lanes


class Step(NamedTuple):
    """What depends on parameters and on the length of a step."""

    h: Lanes  # length, s
    current_rest: Lanes  # what remains of a current's deviation after half a step, 1
    resonance: Resonance


def reset_axis(par: PlantParameters) -> PlantState:
    """Return the state of an axis at rest at its start."""
    return PlantState(
        p=par.position_start, v=0.0, z=0.0, y=0.0, y_rate=0.0, i_a=0.0, i_b=0.0, i_c=0.0
    )


def sample_axis(par: PlantParameters, h: Lanes) -> Step:
    """Return the coefficients of steps of `h` seconds, which are exact."""
    mode, bandwidth = par.resonance, par.amplifiers.bandwidth
    rest = math.exp(-2.0 * math.pi * bandwidth * (0.5 * h))
    resonance = sampled(
        frequency=mode.frequency,
        damping=mode.damping,
        coupling=mode.coupling,
        mass=par.mass,
        h=h,
    )
    return Step(h=h, current_rest=select(bandwidth > 0.0, rest, 0.0), resonance=resonance)


def step_axis(  # noqa: PLR0913, PLR0917 - what a motion depends on
    par: PlantParameters,
    sampled_step: Step,
    table: TableMap,
    at: PlantInput,
    s: PlantState,
    tables: NDArray | None,
) -> PlantState:
    """Return the state one step later, after currents followed constant commands."""
    loops = par.amplifiers
    amplifiers = Amplifiers(
        half_step=sampled_step.current_rest,
        gain_a=loops.gain_a,
        gain_b=loops.gain_b,
        gain_c=loops.gain_c,
        offset_a=loops.offset_a,
        offset_b=loops.offset_b,
        offset_c=loops.offset_c,
        limit=loops.limit,
    )
    target = settled_current(amplifiers, at.current, Phases(0.0, 0.0, 0.0))
    motor_map, mechanics = motor_map_of(par, table), mechanics_of(par)
    machine = Machine(amplifiers, motor_map, mechanics, friction_of(par), sampled_step.resonance)
    return substep(machine, s, target, at.load, None, tables, sampled_step.h)


def measure_axis(
    par: PlantParameters,
    table: TableMap,
    at: PlantInput,
    s: PlantState,
    tables: NDArray | None,
) -> PlantOutput:
    """Return the signals of an axis in a state."""
    current, motor_map = Phases(s.i_a, s.i_b, s.i_c), motor_map_of(par, table)
    return PlantOutput(
        position=s.p,
        position_measured=measure(par.encoder, s.p + s.y, at.encoder_noise),
        velocity=s.v,
        friction=friction_force(friction_of(par), s.v, s.z),
        bristle=s.z,
        thrust=thrust_of(motor_map, tables, s.p, current),
        normal_force=normal_force_of(motor_map, tables, s.p, current),
        current_a=s.i_a,
        current_b=s.i_b,
        current_c=s.i_c,
    )


def motor_map_of(par: PlantParameters, table: TableMap) -> MotorMap:
    """Return the force map: the formula, and where the table lies."""
    return MotorMap(par.force_map, table._replace(gain=par.map_gain))


def mechanics_of(par: PlantParameters) -> Mechanics:
    """Return mass and end stops."""
    stop = par.stroke + par.stop_distance
    return Mechanics(par.mass, stop, par.stop_stiffness, par.stop_damping)


def friction_of(par: PlantParameters) -> LuGre:
    """Return the friction; where it is off, of a bristle that gives way at 1e-60 N."""
    on, f = par.friction_on > 0.0, par.friction
    return LuGre(
        sigma_0=select(on, f.sigma_0, 1.0),
        sigma_1=select(on, f.sigma_1, 0.0),
        sigma_2=select(on, f.sigma_2, 0.0),
        F_c=select(on, f.F_c, 1e-60),
        F_s=select(on, f.F_s, 1e-60),
        v_s=select(on, f.v_s, 1.0),
    )
