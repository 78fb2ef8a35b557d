"""Cost of a set of gains: a weighted sum of metrics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.tune.request import Metric
from motionlab.studies.tune.trials import Outcome

Values = TypeVar("Values", float, NDArray[np.float64])

SCALES: dict[Metric, float] = {
    "peak": 1e-6,
    "rms": 1e-6,
    "itae": 1e-6,
    "settling": 1e-2,
    "effort": 1.0,
}
"""Units of the weights: um, um, um s^2, 10 ms and N, in SI."""


def cost(objective: Mapping[Metric, float], metrics: Mapping[str, Values]) -> Values:
    """Return ``sum w m/unit`` over the metrics of an objective; infinite after a divergence.

    Parameters
    ----------
    objective : mapping
        Weight of each metric.
    metrics : mapping of str to float or ndarray
        Of one axis under one set of gains, or under many.
    """
    terms = [weight * metrics[name] / SCALES[name] for name, weight in objective.items()]
    return sum(terms[1:], start=terms[0])


def on_worst(objective: Mapping[Metric, float], tried: Mapping[tuple[str, str], Outcome]) -> float:
    """Return the cost on the worst motor, summed over axes; `tried` is by motor and axis."""
    motors = {motor for motor, _ in tried}
    return max(
        sum(
            cost(objective, outcome._asdict())
            for (name, _), outcome in tried.items()
            if name == motor
        )
        for motor in motors
    )
