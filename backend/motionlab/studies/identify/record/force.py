"""Force and position of a record, with the force from each sample to the next.

A force is neither its command nor the thrust of the currents at the samples: currents take time to
settle, and those that suit one place are held while the motor moves on. Both are filled in as in
`motionlab.studies.identify.thrust_from_currents`. How fast currents settle is not in a record of
currents or of commands alone: the regression is offered the change of force by slower loops, and
the time constant follows from the share of it that fits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.columns import Columns
from motionlab.force_sharing.pole_pitch import share_over
from motionlab.kernel.force_maps import force_model, map_lanes
from motionlab.studies.identify.record.fit import WITHIN
from motionlab.studies.identify.record.motion import Record
from motionlab.studies.identify.record.plan import CURRENTS, RecordExperiment
from motionlab.studies.identify.thrust_from_currents import (
    CurrentLoops,
    Smoothed,
    as_sent,
    thrust_of,
)

Array = NDArray[np.float64]

_SETTLING, _SETTLING_MIN, _SETTLING_MAX = 0.3, 0.05, 3.0
"""Time constant of current loops at the beginning, and its limits, as a share of a period."""

_SLOWER = 0.3
"""By which slower loops are slower, the same."""

_SETTLED = 0.02
"""Change of the time constant that ends the search, the same."""

_IS_COMMAND = 0.5
"""Share of the force between samples from which a column is taken for a command."""


_REALISED = 1.2
"""Median of a force beside that of the thrust it would command, beyond which it does not."""

CLIPPED = 0.02
"""Share of the samples at the largest force from which it looks clipped."""


def share_at_largest(force: Array) -> float:
    """Return the share of samples at the largest magnitude: from `CLIPPED` on it may be a limit."""
    size = np.abs(force)
    return float(np.mean(size >= np.nanmax(size) * (1.0 - 1e-9)))


@dataclass(frozen=True)
class RecordForce:
    """The force of one axis.

    Attributes
    ----------
    experiment : RecordExperiment
        What is read.
    axis : str
        ``x`` or ``y``.
    samples : ndarray, shape (columns, n)
        Position, and force or currents, SI.
    commanded : bool
        Whether currents follow the force.
    settling : float
        Time constant of the current loops, as a share of a period.
    """

    experiment: RecordExperiment
    axis: str
    samples: Array
    commanded: bool
    settling: float = _SETTLING

    @property
    def record(self) -> Record:
        """Position, force, and what slower loops, or currents that follow it, add to the force."""
        position, measured = self.samples[0], self.samples[1]
        ideal = self.experiment.thrust_is_commanded
        if not self._has_currents and ideal:
            return Record(self.experiment.run.period, position, measured)
        fast, slow = self._thrusts(self.settling), self._thrusts(self.settling + _SLOWER)
        if not (self._has_currents or self.commanded):
            fast, slow = measured, fast
            if _ratio(measured, slow) > _REALISED:  # no command of this motor
                return Record(self.experiment.run.period, position, measured)
        return Record(self.experiment.run.period, position, fast, slow - fast)

    def improved(self, values: Mapping[str, float]) -> RecordForce:
        """Return the force with currents that settle as fast as a fit says; itself if as before."""
        share = values.get(WITHIN, 0.0)
        if self._has_commands:
            return self
        if not (self._has_currents or self.commanded):
            return replace(self, commanded=True) if share > _IS_COMMAND else self
        settling = float(np.clip(self.settling + share * _SLOWER, _SETTLING_MIN, _SETTLING_MAX))
        near = abs(settling - self.settling) < _SETTLED
        return self if near else replace(self, settling=settling)

    def doubts(self) -> list[str]:
        """Return why the force may not be what it is taken for."""
        if self._has_currents:
            return []
        name, force = self.experiment.axes[self.axis].force, self.samples[1]
        doubts = []
        largest = float(np.nanmax(np.abs(force)))
        clipped = share_at_largest(force)
        if clipped >= CLIPPED:
            doubts.append(
                f"{name} is at its largest value, {largest:.4g} N, in {100 * clipped:.3g} % of the "
                "samples: if that is a limit of what measures it, what was found does not hold"
            )
        if self.commanded and not self.experiment.thrust_is_commanded:
            realised = self._thrusts(self.settling)
            if _ratio(force, realised) > _REALISED:
                doubts.append(
                    f"{name} is a command of {largest:.4g} N at most, of which the motor gives "
                    f"{np.nanmax(np.abs(realised)):.3g} N: is its unit right?"
                )
        return doubts

    @property
    def _has_currents(self) -> bool:
        return self.experiment.axes[self.axis].force == CURRENTS

    @property
    def _has_commands(self) -> bool:
        return self._has_currents and len(self.samples) == 7

    def _thrusts(self, settling: float) -> Array:
        """Return the mean thrust from each sample to the next, N; NaN where one is missing."""
        known = np.asarray(np.isfinite(self.samples).all(axis=0))
        force = np.full(self.samples.shape[1], np.nan)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(np.int8), [0]])))
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            if end - begin > 2:
                force[begin : end - 1] = self._thrust(self.samples[:, begin:end], settling)
        return force

    def _thrust(self, samples: Array, settling: float) -> Array:
        """Return the mean thrust from each sample to the next, N, of samples without a gap."""
        position, *rest = np.ascontiguousarray(samples)
        left_over = float(np.exp(-1.0 / settling))
        model = map_lanes(self.experiment.rig.model(self.axis).force_map)
        if not self._has_currents:
            smoothed = _exactly(self._followed(position, rest[0], left_over))
        elif not self._has_commands:
            smoothed = _exactly(np.stack(rest))
        else:
            current, command = np.stack(rest[:3]), np.stack(rest[3:])
            if self.experiment.run.kind == "drive":
                command = as_sent(command, current)
            loops = CurrentLoops(self.experiment.delay)
            loops.learn(command, current)
            slower = left_over - float(np.exp(-1.0 / self.settling))
            smoothed = loops.smooth(command, current)
            left_over = loops.left_over + slower
        return thrust_of(model, position, smoothed, left_over).mean(axis=1)

    def _followed(self, position: Array, force: Array, left_over: float) -> Array:
        """Return the currents of commanded forces at the samples, A, shape (3, n)."""
        from scipy.linalg import solve_banded  # as lfilter, without the second that signal loads

        controller, delay = self.experiment.rig.controller, self.experiment.delay
        config = self.experiment.rig.model(self.axis).force_map
        model = force_model(config, controller.sharing, controller.current_limit)
        command = share_over(model, position=position, force=force).current
        acts = np.concatenate([np.repeat(command[:, :1], delay + 1, axis=1), command], axis=1)
        acts = acts[:, : command.shape[1]]
        # i(k) - left_over i(k - 1) = (1 - left_over) act(k), from i(-1) = act(0)
        bands = np.array([[1.0], [-left_over]]).repeat(acts.shape[1], axis=1)
        right = (1.0 - left_over) * acts
        right[:, 0] += left_over * acts[:, 0]
        return solve_banded((1, 0), bands, right.T).T


def force_of(experiment: RecordExperiment, axis: str, columns: Columns) -> RecordForce:
    """Return the force of an axis of a run.

    Parameters
    ----------
    experiment : RecordExperiment
        What is read.
    axis : str
        ``x`` or ``y``.
    columns : Columns
        Of the run.
    """
    chosen = experiment.axes[axis]
    _, first, last = experiment.part
    samples = columns.read(chosen.names)[:, first:last].astype(np.float64)
    samples *= np.array(chosen.factors)[:, None]
    return RecordForce(experiment, axis, samples, chosen.commanded)


def _ratio(force: Array, thrust: Array) -> float:
    """Return the median of a force beside that of a thrust."""
    known = np.isfinite(force) & np.isfinite(thrust)
    if not known.any():
        return 1.0
    return float(np.median(np.abs(force[known])) / max(np.median(np.abs(thrust[known])), 1e-9))


def _exactly(current: Array) -> Smoothed:
    count = current.shape[1]
    return Smoothed(current, np.zeros(count), np.zeros(count - 1))
