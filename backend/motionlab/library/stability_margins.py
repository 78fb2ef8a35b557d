"""Stability margins of a simulated run, among its metrics."""

from __future__ import annotations

import numpy as np

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.library.recorded import scenario_of
from motionlab.library.run import RunDetail
from motionlab.library.search import MARGINS
from motionlab.loop.family import family_of


def stability_margins(scenario: Scenario) -> dict[str, float]:
    """Return the least margins of each loop, at standstill and from 0.5 to 4 Stribeck velocities.

    Returns
    -------
    dict of str to float
        ``B.x.gain_margin``, a factor, up or down, and ``B.x.phase_margin``, rad. A loop that is
        unstable or has no linearisation has none, nor has one whose response never crosses.
    """
    metrics: dict[str, float] = {}
    for variant, owner in scenario.variants.items():
        for axis in AXES:
            try:
                family = family_of(scenario, variant, axis)
            except ConfigError:  # no linearisation, or a force map that is gone
                continue
            gains = getattr(owner.controller, axis)
            worst = family.margins_over(np.array([gains.k_p]), np.array([gains.k_d]))
            for name in MARGINS:
                if np.isfinite(value := float(worst[name][0])):
                    metrics[f"{variant}.{axis}.{name}"] = value
    return metrics


def margins_of(run: RunDetail) -> dict[str, float]:
    """Return the `stability_margins` in effect at the end of a run; none of what is not simulated.

    None either of a capture, which has no scenario of its own.
    """
    if run.kind not in {"simulation", "live"}:
        return {}
    try:
        scenario = scenario_of(run, run.ticks - 1, run.ticks, lambda _: False)
    except ConfigError:  # a change that no longer fits
        return {}
    return {} if isinstance(scenario, str) else stability_margins(scenario)
