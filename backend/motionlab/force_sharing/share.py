"""Sharing a force command among the phases, on an analytic map or on a table.

A sharing function gives the part of each phase; the map gives the current for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.functions import FUNCTIONS, SharingParameters
from motionlab.force_sharing.functions.function import (
    TINY,
    Demand,
    Phase,
    Share,
    SharingFunction,
)
from motionlab.force_sharing.tables import INVERSE_LEVELS, INVERSE_POSITIONS, between
from motionlab.lanes import Lanes, Mask, anywhere, compiled, select, square_root
from motionlab.lanes.functions import clip, positive
from motionlab.plant.magnetics import Phases, current_for, force_fraction, thrust_shape
from motionlab.plant.table_map import MotorMap, cell, phase_thrust, phase_turns

Array = NDArray[np.float64]
Forces = Callable[[Lanes, Any, Demand, Array], Phases]


class Sharing(NamedTuple):
    """Force sharing of each lane, and where its tables lie among all tables."""

    law: Lanes  # number of the sharing function
    inverse: Lanes  # first number of the cells of current over position and thrust; -1: none
    table: Lanes  # first number of the function's own table; -1: none
    current_limit: Lanes  # largest current command, A


class ForceModel(NamedTuple):
    """A controller's commutation: its model of the force map and its force sharing."""

    map: MotorMap
    sharing: Sharing
    parameters: SharingParameters  # pyright: ignore[reportInvalidTypeForm] - known when read


@compiled
def within_capability(part: Phases, demand: Demand) -> Phases:
    """Return the force of each phase, N, of its part of the command: at most what it can give."""
    magnitude = demand.magnitude
    return Phases(
        clip(magnitude * part.a, 0.0, demand.a.most),
        clip(magnitude * part.b, 0.0, demand.b.most),
        clip(magnitude * part.c, 0.0, demand.c.most),
    )


@compiled
def passed_on(f: Phases, demand: Demand) -> Phases:
    """Return forces with which the others make up for a phase at its limit, as far as they can."""
    a, b, c = demand.a, demand.b, demand.c
    left = demand.magnitude - (f.a + f.b + f.c)
    room = (a.most - f.a) + (b.most - f.b) + (c.most - f.c)
    passed = clip(left / select(room > TINY, room, TINY), 0.0, 1.0)
    return Phases(
        f.a + passed * (a.most - f.a),
        f.b + passed * (b.most - f.b),
        f.c + passed * (c.most - f.c),
    )


def forces_by(function: SharingFunction) -> Forces:
    """Return the forces of the phases by one sharing function, as `phase_forces`."""
    shares = function.shares

    if function.passes_on:

        def phase_forces(_law: Lanes, par: Any, demand: Demand, tables: Array) -> Phases:
            """Return the force of each phase, N, in the commanded direction."""
            return passed_on(within_capability(shares(par, demand, tables), demand), demand)

    else:

        def phase_forces(_law: Lanes, par: Any, demand: Demand, tables: Array) -> Phases:
            """Return the force of each phase, N, in the commanded direction."""
            return within_capability(shares(par, demand, tables), demand)

    return compiled(phase_forces)


@compiled
def _chosen(mask: Mask, yes: Phases, no: Phases) -> Phases:
    return Phases(select(mask, yes.a, no.a), select(mask, yes.b, no.b), select(mask, yes.c, no.c))


def _by_number() -> Forces:
    """Return the forces by each lane's own function; one that no lane has is not computed.

    Its text has a branch for each function: compiled code cannot choose between functions.
    """
    scope: dict[str, Any] = {"anywhere": anywhere, "chosen": _chosen, "Phases": Phases}
    lines = [
        "def phase_forces(law, par, demand, tables):",
        "    f = Phases(demand.a.most, demand.b.most, demand.c.most)",
    ]
    for number, function in enumerate(FUNCTIONS.values()):
        scope[f"forces_{number}"] = forces_by(function)
        lines += [
            f"    if anywhere(law == {number}.0):",
            f"        own = forces_{number}(law, par, demand, tables)",
            f"        f = chosen(law == {number}.0, own, f)",
        ]
    exec("\n".join([*lines, "    return f"]), scope)
    return scope["phase_forces"]


phase_forces: Forces = compiled(_by_number())
"""Return the force of each phase, N, in the commanded direction, by each lane's own function."""

(closed_form,) = (each.closed for each in FUNCTIONS.values() if each.closed is not None)
"""What lanes without tables run."""


@compiled
def share_force(model: ForceModel, tables: Array | None, position: Lanes, force: Lanes) -> Share:
    """Share `force`, N, at the measured `position`, m; without tables, in closed form."""
    formula, limit = model.map.formula, model.sharing.current_limit
    if tables is None:
        return closed_form(formula, limit, position, force)
    forward = force > 0.0
    sense = select(forward, 1.0, -1.0)
    turns = phase_turns(formula, position)
    shape = thrust_shape(formula, position)
    a = _phase(model, tables, turns.a, shape.a, sense)
    b = _phase(model, tables, turns.b, shape.b, sense)
    c = _phase(model, tables, turns.c, shape.c, sense)

    magnitude = abs(force)
    tabled = model.map.table.thrust >= 0.0
    demand = Demand(magnitude, forward, a, b, c, tabled, formula, model.sharing.table)
    f = phase_forces(model.sharing.law, model.parameters, demand, tables)
    limited = magnitude - (f.a + f.b + f.c) > 1e-9 * magnitude

    current = Phases(
        _current(model, tables, a, f.a),
        _current(model, tables, b, f.b),
        _current(model, tables, c, f.c),
    )
    realised = (
        _thrust(model.map, tables, a, current.a, sense)
        + _thrust(model.map, tables, b, current.b, sense)
        + _thrust(model.map, tables, c, current.c, sense)
    )
    return Share(current, select(forward, realised, -realised), limited)


@compiled
def _phase(model: ForceModel, tables: Array, turns: Lanes, shape: Lanes, sense: Lanes) -> Phase:
    """Return what one phase can give in the commanded direction."""
    force_map, table, limit = model.map.formula, model.map.table, model.sharing.current_limit
    tabled = table.thrust >= 0.0
    x = positive(sense * shape)
    i_max = table.currents / table.per_ampere
    formula = force_map.F_pk * x
    most = positive(sense * phase_thrust(table, tables, turns, limit))
    whole = positive(sense * phase_thrust(table, tables, turns, i_max))
    return Phase(
        turns=turns,
        x=x,
        most=select(tabled, most, formula * force_fraction(force_map, limit)),
        whole=select(tabled, whole, formula),
    )


@compiled
def _current(model: ForceModel, tables: Array, phase: Phase, force: Lanes) -> Lanes:
    """Return the current, A, at which a phase gives `force`, N, in the commanded direction."""
    force_map, sharing = model.map.formula, model.sharing
    formula = force_map.F_pk * phase.x
    y = force / select(formula > TINY, formula, TINY)
    most = force_fraction(force_map, sharing.current_limit)
    closed = current_for(force_map, clip(y, 0.0, most))
    level = square_root(clip(force / select(phase.whole > TINY, phase.whole, TINY), 0.0, 1.0))
    column, u = cell(phase.turns * INVERSE_POSITIONS, INVERSE_POSITIONS)
    row, w = cell(level * INVERSE_LEVELS, INVERSE_LEVELS)
    first = select(sharing.inverse > 0.0, sharing.inverse, 0.0)
    current = between(tables, first + 4.0 * (column * INVERSE_LEVELS + row), u, w)
    return select(model.map.table.thrust >= 0.0, clip(current, 0.0, sharing.current_limit), closed)


@compiled
def _thrust(motor_map: MotorMap, tables: Array, phase: Phase, i: Lanes, sense: Lanes) -> Lanes:
    """Return the thrust of a current in the commanded direction, N."""
    force = sense * phase_thrust(motor_map.table, tables, phase.turns, i)
    closed = motor_map.formula.F_pk * force_fraction(motor_map.formula, i) * phase.x
    return select(motor_map.table.thrust >= 0.0, force, closed)
