"""Tracking of a motion by the loop of each variant, by simulation.

A motor that can follow a motion does not make sure that a loop does so within its currents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from motionlab.analysis.metrics import variant_metrics
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.trajectory_check import Examination

LONGEST = 120.0
"""Longest motion whose loops are run, s."""
WORK_MAX = 600.0
"""Most simulated time summed over the variants, s."""


@dataclass(frozen=True)
class LoopCheck:
    """One variant that ran along a motion.

    Attributes
    ----------
    variant, label, law : str
        Name, description and law of friction compensation.
    feedforward : bool
        Whether it feeds the acceleration forward.
    diverged : bool
        Whether it diverged.
    saturated_fraction : dict of str to float or None
        By axis that moves, the share of ticks of the window with the command or a current at its
        limit.
    max_abs_following_error : dict of str to float or None
        By axis that moves, in the window, m.
    """

    variant: str
    label: str
    law: str
    feedforward: bool
    diverged: bool
    saturated_fraction: dict[str, float | None]
    max_abs_following_error: dict[str, float | None]

    @property
    def limited(self) -> bool:
        """Whether it is at a limit at some tick, or diverged."""
        return self.diverged or any(self.saturated_fraction.values())


@dataclass(frozen=True)
class Loops:
    """The loops of a scenario on its motion.

    Attributes
    ----------
    loops : list of LoopCheck or None
        Of each variant; None if they were not run.
    loops_window : tuple of float or None
        Start and end of the window, s.
    loops_not_run : str or None
        Why they were not run.
    """

    loops: list[LoopCheck] | None = None
    loops_window: tuple[float, float] | None = None
    loops_not_run: str | None = None

    def document(self) -> dict[str, Any]:
        """Return the fields of an answer."""
        checks = None if self.loops is None else [vars(each) for each in self.loops]
        return vars(self) | {"loops": checks}


def run_loops(
    scenario: Scenario, examined: Examination, hold: Callable[[int], None] = lambda _size: None
) -> Loops:
    """Run every variant of a scenario along its motion.

    They are not run where the motion is infeasible or takes longer than `LONGEST`, all together
    longer than `WORK_MAX`, or where an event or the window lies after the end of the motion.

    Parameters
    ----------
    scenario : Scenario
        With its trajectory, motor and controllers.
    examined : Examination
        The check of its motion.
    hold : callable, optional
        Called with the size of the recording before the run, bytes.
    """
    duration, count = examined.duration, len(scenario.variants)
    if not examined.feasible:
        return Loops(loops_not_run="the motor cannot follow the motion")
    if duration > LONGEST:
        return Loops(loops_not_run=f"the motion takes {duration:.6g} s, more than {LONGEST:g} s")
    if count * duration > WORK_MAX:
        return Loops(
            loops_not_run=f"{count} variants of {duration:.6g} s each are more than "
            f"{WORK_MAX:g} s of simulated time"
        )
    try:
        prepared = prepare(scenario)
    except ConfigError as error:
        return Loops(loops_not_run="; ".join(map(str, error.errors)))
    hold(prepared.recording_size())
    recording = run(prepared)
    checks = []
    for name, variant in scenario.variants.items():
        metrics = variant_metrics(
            recording,
            name,
            prepared.reference,
            prepared.window,
            settling_band=scenario.settling_band,
        )["axes"]
        shares, errors = (
            {axis: metrics[axis][key] for axis in AXES if axis in metrics}
            for key in ("saturated_fraction", "max_abs_following_error")
        )
        controller = variant.controller
        compensation = controller.compensation
        checks.append(
            LoopCheck(
                variant=name,
                label=variant.label,
                law=compensation.law if compensation.enabled else "off",
                feedforward=controller.feedforward,
                diverged=recording.variants[name].diverged is not None,
                saturated_fraction=shares,
                max_abs_following_error=errors,
            )
        )
    start, end = prepared.window
    return Loops(checks, (start * CONTROL_PERIOD, end * CONTROL_PERIOD))
