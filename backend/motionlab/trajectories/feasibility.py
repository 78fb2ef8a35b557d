"""Whether the motor can follow a reference, decided before anything moves."""

from __future__ import annotations

import numpy as np

from motionlab.config.planar import AXES
from motionlab.errors import Infeasible
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_limits import (
    ALWAYS,
    QUANTITIES,
    RELATIVE_ROUNDING,
    UNITS,
    Demand,
    MotionLimits,
    Span,
    demands,
    place_at,
)
from motionlab.trajectories.reference import Reference

_QUADRATURE = 4
"""Counts per cycle of an encoder with two tracks in quadrature."""


def check(reference: Reference, limits: MotionLimits, *, span: Span = ALWAYS) -> None:
    """Refuse a motion that leaves the stroke or exceeds the motor's limits.

    The thrust that the motion requires is M a + f_f(v), eq (16). Velocity that jumps between two
    ticks counts as the acceleration it takes, the start from rest included. A position that jumps
    by more than the velocity explains is a true step: up to `STEP_MAX` it is allowed and
    counts neither as velocity nor as acceleration.

    Parameters
    ----------
    reference : Reference
        The motion.
    limits : MotionLimits
        Limits of the motor.
    span : Span
        Ticks at which these limits hold.

    Raises
    ------
    Infeasible
        With the first time and place at which anything is exceeded.
    """
    first: tuple[int, Demand] | None = None
    for demand in demands(reference, limits, span=span):
        tick = int(np.argmax(demand.beyond != 0))
        if demand.violations and (first is None or tick < first[0]):
            first = tick, demand
    if first is not None:
        tick, demand = first
        flags = int(demand.beyond[tick])
        raise refusal(demand, (flags & -flags).bit_length() - 1, tick)


def refusal(demand: Demand, quantity: int, tick: int) -> Infeasible:
    """Return the error of one tick at which a quantity exceeds its limit."""
    limit = demand.limit_at(quantity, tick)
    kept = demand.reserve > 0.0 and QUANTITIES[quantity] == "thrust"
    return Infeasible(
        quantity=QUANTITIES[quantity],
        axis=AXES[demand.axis],
        time=tick * CONTROL_PERIOD,
        place=place_at(demand.reference, tick),
        value=demand.value_at(quantity, tick),
        limit=(-limit, limit),
        unit=UNITS[quantity],
        note=f"{100 * demand.reserve:.3g} % are left to feedback (thrust_reserve)" if kept else "",
    )


def count_rate_warning(
    reference: Reference, axis: str, *, resolution: float, rate: float
) -> str | None:
    """Return a note if the encoder interface of an axis would lose counts.

    The interface follows up to 4 `rate` `resolution`: 0.25 m/s at 1.25 MHz and 50 nm.

    Parameters
    ----------
    reference : Reference
        The motion.
    axis : str
        ``x`` or ``y``.
    resolution : float
        One encoder count, m.
    rate : float
        Largest frequency of the interface, Hz.

    Returns
    -------
    str or None
        A note for the user, or None if no count is lost.
    """
    v_max = _QUADRATURE * rate * resolution
    speed = np.abs(reference.velocity[:, AXES.index(axis)])
    too_fast = speed > v_max * (1 + RELATIVE_ROUNDING)
    if not too_fast.any():
        return None
    tick = int(np.argmax(too_fast))
    peak = float(speed.max())
    return (
        f"encoder: velocity on {axis} exceeds {v_max:.6g} m/s from t = "
        f"{tick * CONTROL_PERIOD:.4f} s on, peak {peak:.6g} m/s; "
        f"a real {rate / 1e6:g} MHz interface would lose counts"
    )
