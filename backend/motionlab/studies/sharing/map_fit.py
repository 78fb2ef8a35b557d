"""The analytic force map fitted to a table, for controllers without tables."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.pole_pitch import forces_over
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.table_map import ANALYTIC, MotorMap

Array = NDArray[np.float64]

_POSITIONS, _CURRENTS = 96, 40
_START = (1.0, 0.55, 0.0, 0.0)
_LOW, _HIGH = (0.05, 0.02, -0.3, -0.3), (5.0, 50.0, 0.3, 0.3)


class MapFit(NamedTuple):
    """An analytic map, and its deviation from the fitted table."""

    force_map: AnalyticMap
    relative_rms: float  # of thrust over the largest at the same current, 1: what was made least
    rms: float  # of thrust over positions and currents, N
    worst: float  # largest difference, N
    position: float  # where, m from the position where teeth are aligned
    current: float  # at which current, A


def fit_analytic(table: ForceMap) -> MapFit:
    """Fit F_pk, I_knee, h_2 and h_3 of the analytic map to a table's thrust by least squares.

    Differences count over the largest thrust at their own current: a controller spends its time at
    small currents, where a fit in newtons is off by a third. I_pk is the table's largest current,
    N_pk its normal force there where teeth are aligned.
    """
    from scipy.optimize import least_squares

    turns, i = (
        grid.ravel()
        for grid in np.meshgrid(
            np.arange(_POSITIONS) / _POSITIONS, np.arange(1, _CURRENTS + 1) / _CURRENTS
        )
    )
    i = i * table.i_max
    position = turns * table.tau
    x = position - 0.5 * table.tau
    thrust = table.thrust(x, i)
    peak = float(np.abs(thrust).max())
    rows = np.abs(thrust).reshape(_CURRENTS, _POSITIONS).max(axis=1)
    largest = np.repeat(rows, _POSITIONS)  # at each current
    normal = float(table.normal_force(0.0, table.i_max))
    current = np.stack([i, np.zeros_like(i), np.zeros_like(i)])

    def analytic(parameters: Array) -> AnalyticMap:
        F, knee, h_2, h_3 = (float(value) for value in parameters)
        return AnalyticMap(
            tau=table.tau,
            offset=0.0,
            F_pk=F * peak,
            N_pk=normal,
            I_pk=table.i_max,
            I_knee=knee * table.i_max,
            h_2=h_2,
            h_3=h_3,
        )

    def difference(parameters: Array) -> Array:
        forces = forces_over(
            MotorMap(analytic(parameters), ANALYTIC), position=position, current=current
        )
        return (forces.thrust - thrust) / largest

    solution = least_squares(difference, _START, bounds=(_LOW, _HIGH))
    relative = difference(solution.x)
    left = relative * largest
    worst = int(np.abs(left).argmax())
    return MapFit(
        force_map=analytic(solution.x),
        relative_rms=float(np.sqrt((relative**2).mean())),
        rms=float(np.sqrt((left**2).mean())),
        worst=float(abs(left[worst])),
        position=float(x[worst]),
        current=float(i[worst]),
    )
