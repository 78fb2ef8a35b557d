"""Whether learning converges, on the scenario's motor and on drawn ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.studies.learn.documents import Prediction
from motionlab.studies.learn.learning_filter import modelled
from motionlab.studies.learn.plan import LearnPlan, band, factors
from motionlab.studies.montecarlo.documents import DEFAULT
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.studies.study import Progress

Array = NDArray[np.float64]

SHARE = 0.3
"""Of the progress of learning that is predicting's."""


def drawn_motors(planned: LearnPlan) -> list[Scenario]:
    """Return the scenario with motors drawn as Monte Carlo draws them."""
    request, scenario = planned.request, planned.scenario
    document = scenario.model_dump(mode="json")
    absent = missing(document["plant"], DEFAULT)
    vary = [each for each in DEFAULT if each.path not in absent]
    seed = scenario.seed if request.seed is None else request.seed
    draws = draw(document["plant"], vary, cases=request.motors, seed=seed)
    return [validate(apply_changes(document, changes)) for changes in draws]


def predictions(planned: LearnPlan, progress: Progress) -> dict[str, Prediction]:
    """Return what is predicted of each axis that moves."""
    drawn: dict[str, list[Array]] = {axis: [] for axis in planned.filters}
    bands = {axis: band(each) for axis, each in planned.filters.items()}
    motors = drawn_motors(planned)
    for number, motor in enumerate(motors):
        for axis, at in bands.items():
            drawn[axis].append(factors(planned, axis, motor, at))
        progress(SHARE * (number + 1) / len(motors), None)
    return {axis: _prediction(planned, axis, bands[axis], drawn[axis]) for axis in bands}


def _prediction(
    planned: LearnPlan, axis: str, at: NDArray[np.intp], drawn: Sequence[Array]
) -> Prediction:
    frequency = planned.filters[axis].frequency[at]
    motor = factors(planned, axis, planned.scenario, at)
    model = factors(planned, axis, modelled(planned.scenario, planned.variant), at)
    worst = int(motor.argmax())
    low, high = np.quantile(drawn, (0.05, 0.95), axis=0) if drawn else (None, None)
    return Prediction(
        frequency=rounded(frequency),
        motor=rounded(motor),
        model=rounded(model),
        low=None if low is None else rounded(low),
        high=None if high is None else rounded(high),
        worst=float(motor[worst]),
        worst_frequency=float(frequency[worst]),
        converging=float(np.mean([each.max() < 1.0 for each in drawn])) if drawn else None,
    )


def rounded(values: Array) -> list[float]:
    """Return values with six digits, as documents have them."""
    return [float(f"{value:.6g}") for value in values.tolist()]
