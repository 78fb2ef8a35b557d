"""Sharing a force command by any law, on an analytic map or on a table.

A law sets the part of the commanded force for each phase; the map gives the current for it. Laws:

least-norm
    ``F_k = abs(f) c_k**2 / sum c_j**2`` with c_k what phase k can give at its current limit, as
    `motionlab.force_sharing.least_norm` does on the analytic map.
force-per-ampere
    Least copper loss ``sum i_k**2`` for the commanded force. On the analytic map
    ``sqrt(x_k)/(1 + B q_k)``, with ``q = (i/I_pk)**2``, is the same for all phases that carry
    current; on a table the shares are tabulated. What one phase cannot give, another does.
sine, cubic
    Classical sharing functions of position alone: a phase takes over from the one before it
    along ``(1 - cos pi z)/2`` or ``3 z**2 - 2 z**3``, in the middle of the half pitch in which
    it pulls.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.least_norm import Share, share_force
from motionlab.lanes import Lanes, compiled, load_four, select, square_root
from motionlab.lanes.functions import clip, sine_cosine
from motionlab.plant.magnetics import (
    AnalyticMap,
    Phases,
    current_for,
    force_fraction,
    thrust_shape,
)
from motionlab.plant.table_map import MotorMap, cell, phase_thrust, phase_turns

Array = NDArray[np.float64]

LEAST_NORM, FORCE_PER_AMPERE, SINE, CUBIC = 0.0, 1.0, 2.0, 3.0
"""Values of SharingFunction.law."""

INVERSE_POSITIONS, INVERSE_LEVELS = 288, 64
"""Cells of the inverse of a table: along a pole pitch, and along sqrt(thrust/largest thrust)."""

SHARE_POSITIONS, SHARE_LEVELS = 240, 32
"""Cells of the shares of least copper loss: along a pole pitch, and along force/largest force."""

_TINY = 1e-30


class SharingFunction(NamedTuple):
    """Law of each lane, and where its tables lie among all tables."""

    law: Lanes
    overlap: Lanes  # share of the pole pitch over which a phase hands over, 1
    inverse: Lanes  # first number of the cells of current over position and thrust; -1: none
    shares: Lanes  # first number of the cells of shares of least copper loss; -1: none
    current_limit: Lanes  # largest current command, A


class ForceModel(NamedTuple):
    """A controller's commutation: its model of the force map and its sharing function."""

    map: MotorMap
    sharing: SharingFunction


class _Phase(NamedTuple):
    """Capability of one phase in the commanded direction."""

    turns: Lanes  # where it stands in its pole pitch
    x: Lanes  # analytic shape, 0 where it pulls the other way
    most: Lanes  # thrust at the lane's current limit, N
    whole: Lanes  # thrust at the largest current of the map, N


@compiled
def share_by_law(model: ForceModel, tables: Array | None, position: Lanes, force: Lanes) -> Share:
    """Share `force`, N, at the measured `position`, m, by each lane's law and kind of map.

    Without tables every lane shares by the closed form, and nothing else is compiled.
    """
    formula, limit = model.map.formula, model.sharing.current_limit
    if tables is None:
        return share_force(formula, limit, position, force)
    forward = force > 0.0
    sense = select(forward, 1.0, -1.0)
    turns = phase_turns(formula, position)
    shape = thrust_shape(formula, position)
    a = _phase(model, tables, turns.a, shape.a, sense)
    b = _phase(model, tables, turns.b, shape.b, sense)
    c = _phase(model, tables, turns.c, shape.c, sense)

    magnitude = abs(force)
    part = _shares(model, tables, Phases(a, b, c), magnitude, forward)
    f_a = clip(magnitude * part.a, 0.0, a.most)
    f_b = clip(magnitude * part.b, 0.0, b.most)
    f_c = clip(magnitude * part.c, 0.0, c.most)
    # The others make up for a phase at its limit, as far as they can.
    left = magnitude - (f_a + f_b + f_c)
    room = (a.most - f_a) + (b.most - f_b) + (c.most - f_c)
    passed = clip(left / select(room > _TINY, room, _TINY), 0.0, 1.0)
    passed = select(model.sharing.law == FORCE_PER_AMPERE, passed, 0.0)
    f_a = f_a + passed * (a.most - f_a)
    f_b = f_b + passed * (b.most - f_b)
    f_c = f_c + passed * (c.most - f_c)
    limited = magnitude - (f_a + f_b + f_c) > 1e-9 * magnitude

    current = Phases(
        _current(model, tables, a, f_a),
        _current(model, tables, b, f_b),
        _current(model, tables, c, f_c),
    )
    realised = (
        _thrust(model.map, tables, a, current.a, sense)
        + _thrust(model.map, tables, b, current.b, sense)
        + _thrust(model.map, tables, c, current.c, sense)
    )
    return Share(current, select(forward, realised, -realised), limited)


@compiled
def _phase(model: ForceModel, tables: Array, turns: Lanes, shape: Lanes, sense: Lanes) -> _Phase:
    force_map, table, limit = model.map.formula, model.map.table, model.sharing.current_limit
    tabled = table.thrust >= 0.0
    x = _positive(sense * shape)
    i_max = table.currents / table.per_ampere
    formula = force_map.F_pk * x
    most = _positive(sense * phase_thrust(table, tables, turns, limit))
    whole = _positive(sense * phase_thrust(table, tables, turns, i_max))
    return _Phase(
        turns=turns,
        x=x,
        most=select(tabled, most, formula * force_fraction(force_map, limit)),
        whole=select(tabled, whole, formula),
    )


@compiled
def _shares(
    model: ForceModel, tables: Array, phases: Phases, magnitude: Lanes, forward: Lanes
) -> Phases:
    """Return the part of the commanded force that each phase is to give."""
    sharing, (a, b, c) = model.sharing, phases
    squares = a.most * a.most + b.most * b.most + c.most * c.most
    scale = 1.0 / select(squares > _TINY, squares, _TINY)
    f = _least_loss(model.map.formula, a.x, b.x, c.x, magnitude)
    sum_f = f.a + f.b + f.c
    per = 1.0 / select(sum_f > _TINY, sum_f, _TINY)
    whole = a.whole + b.whole + c.whole
    level = clip(magnitude / select(whole > _TINY, whole, _TINY), 0.0, 1.0) * SHARE_LEVELS
    tabled = model.map.table.thrust >= 0.0
    least = Phases(
        select(tabled, _tabled(sharing, tables, a.turns, level, forward), f.a * per),
        select(tabled, _tabled(sharing, tables, b.turns, level, forward), f.b * per),
        select(tabled, _tabled(sharing, tables, c.turns, level, forward), f.c * per),
    )
    return Phases(
        _by_law(sharing, _classical(sharing, a.turns, forward), least.a, a.most * a.most * scale),
        _by_law(sharing, _classical(sharing, b.turns, forward), least.b, b.most * b.most * scale),
        _by_law(sharing, _classical(sharing, c.turns, forward), least.c, c.most * c.most * scale),
    )


@compiled
def _by_law(
    sharing: SharingFunction, classical: Lanes, least_loss: Lanes, least_norm: Lanes
) -> Lanes:
    other = select(sharing.law == FORCE_PER_AMPERE, least_loss, least_norm)
    return select(sharing.law > FORCE_PER_AMPERE, classical, other)


@compiled
def _least_loss(force_map: AnalyticMap, a: Lanes, b: Lanes, c: Lanes, magnitude: Lanes) -> Phases:
    """Return the forces of least copper loss on the analytic map, up to a common factor.

    With ``F = G (1 - 1/(1 + B q)) x``, ``G = F_pk (1 + B)/B``, the loss sum q is least where
    ``sqrt(x_k)/(1 + B q_k) = 1/w`` for every phase that carries current. At most two phases pull
    the same way: the stronger one alone, or both.
    """
    knee = force_map.I_pk * (1.0 / force_map.I_knee)
    asymptote = (1.0 + knee * knee) / (knee * knee)
    y = magnitude / (force_map.F_pk * asymptote)
    r_a, r_b, r_c = square_root(a), square_root(b), square_root(c)
    strongest = select(a > b, a, b)
    strongest = select(c > strongest, c, strongest)
    both = r_a * r_b + r_b * r_c + r_c * r_a > strongest - y
    rest = clip(a + b + c - y, _TINY, np.inf)
    inverse_w = rest / (r_a + r_b + r_c)
    return Phases(
        select(both, _positive(a - r_a * inverse_w), select(a >= strongest, 1.0, 0.0)),
        select(both, _positive(b - r_b * inverse_w), select(b >= strongest, 1.0, 0.0)),
        select(both, _positive(c - r_c * inverse_w), select(c >= strongest, 1.0, 0.0)),
    )


@compiled
def _classical(sharing: SharingFunction, turns: Lanes, forward: Lanes) -> Lanes:
    """Return the share of a phase by a sharing function; the three sum to 1."""
    place = select(forward, turns, 1.0 - turns)
    per = 1.0 / sharing.overlap
    start = 1.0 / 12.0 - 0.5 * sharing.overlap
    rise = clip((place - start) * per, 0.0, 1.0)
    fall = clip((place - start - 1.0 / 3.0) * per, 0.0, 1.0)
    _, cos_rise = sine_cosine(0.5 * rise)
    _, cos_fall = sine_cosine(0.5 * fall)
    sine = 0.5 * (cos_fall - cos_rise)
    cubic = rise * rise * (3.0 - 2.0 * rise) - fall * fall * (3.0 - 2.0 * fall)
    return select(sharing.law == SINE, sine, cubic)


@compiled
def _tabled(
    sharing: SharingFunction, tables: Array, turns: Lanes, level: Lanes, forward: Lanes
) -> Lanes:
    """Return the share of a phase of least copper loss, between its nodes."""
    column, u = cell(turns * SHARE_POSITIONS, SHARE_POSITIONS)
    row, w = cell(level, SHARE_LEVELS)
    sheet = select(forward, 0.0, float(SHARE_POSITIONS * SHARE_LEVELS))
    first = select(sharing.shares > 0.0, sharing.shares, 0.0)
    return _between(tables, first + 4.0 * (sheet + column * SHARE_LEVELS + row), u, w)


@compiled
def _current(model: ForceModel, tables: Array, phase: _Phase, force: Lanes) -> Lanes:
    """Return the current, A, at which a phase gives `force`, N, in the commanded direction."""
    force_map, sharing = model.map.formula, model.sharing
    formula = force_map.F_pk * phase.x
    y = force / select(formula > _TINY, formula, _TINY)
    most = force_fraction(force_map, sharing.current_limit)
    closed = current_for(force_map, clip(y, 0.0, most))
    level = square_root(clip(force / select(phase.whole > _TINY, phase.whole, _TINY), 0.0, 1.0))
    column, u = cell(phase.turns * INVERSE_POSITIONS, INVERSE_POSITIONS)
    row, w = cell(level * INVERSE_LEVELS, INVERSE_LEVELS)
    first = select(sharing.inverse > 0.0, sharing.inverse, 0.0)
    current = _between(tables, first + 4.0 * (column * INVERSE_LEVELS + row), u, w)
    return select(model.map.table.thrust >= 0.0, clip(current, 0.0, sharing.current_limit), closed)


@compiled
def _thrust(motor_map: MotorMap, tables: Array, phase: _Phase, i: Lanes, sense: Lanes) -> Lanes:
    """Return the thrust of a current in the commanded direction, N."""
    force = sense * phase_thrust(motor_map.table, tables, phase.turns, i)
    closed = motor_map.formula.F_pk * force_fraction(motor_map.formula, i) * phase.x
    return select(motor_map.table.thrust >= 0.0, force, closed)


@compiled
def _between(tables: Array, first: Lanes, u: Lanes, w: Lanes) -> Lanes:
    low, low_next, high, high_next = load_four(tables, first)
    near = low + w * (low_next - low)
    return near + u * (high + w * (high_next - high) - near)


@compiled
def _positive(x: Lanes) -> Lanes:
    return select(x > 0.0, x, 0.0)
