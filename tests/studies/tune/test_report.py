"""The table of a search: the worst of each quantity, with the motor that it is of."""

from __future__ import annotations

import math

from motionlab.loop.document import WorstMargin
from motionlab.studies.tune.documents import GainMargins, GainMetrics, TunedAxis
from motionlab.studies.tune.report import WorstMotor, worst_of


def metrics(peak: float | None, effort: float | None) -> GainMetrics:
    return GainMetrics(
        peak=peak, rms=peak, itae=peak, settling=peak, effort=effort, force=effort, saturated=0.0
    )


def margins(gain: float | None, phase: float, velocity: float) -> GainMargins:
    factor = None if gain is None else WorstMargin(value=gain, velocity=velocity)
    return GainMargins(
        stable=True,
        gain_margin=factor,
        phase_margin=WorstMargin(value=phase, velocity=velocity),
        Ms=WorstMargin(value=1.0 / phase, velocity=velocity),
    )


def axis(**changes: object) -> TunedAxis:
    found = {
        "k_p": 2e5,
        "k_d": 1500.0,
        "metrics": {"nominal": metrics(1e-6, 3.0), "matched": metrics(2e-6, 2.0)},
        "margins": {"nominal": margins(2.64, 0.58, 0.1), "matched": margins(2.22, 0.6, 0.03)},
    }
    return TunedAxis.model_validate(found | changes)


def test_the_worst_of_each_quantity_is_that_of_the_motor_it_names() -> None:
    found = worst_of(axis())
    assert found == {
        "peak": WorstMotor(2e-6, "matched", None),
        "rms": WorstMotor(2e-6, "matched", None),
        "effort": WorstMotor(3.0, "nominal", None),
        "gain_margin": WorstMotor(2.22, "matched", 0.03),
        "phase_margin": WorstMotor(0.58, "nominal", 0.1),
        "Ms": WorstMotor(1.0 / 0.58, "nominal", 0.1),
    }


def test_a_motor_that_ran_away_is_the_worst() -> None:
    away = {"nominal": metrics(None, None), "matched": metrics(2e-6, 2.0)}
    assert worst_of(axis(metrics=away))["peak"] == WorstMotor(math.inf, "nominal", None)


def test_an_unstable_motor_leaves_no_margins() -> None:
    bad = GainMargins(stable=False, gain_margin=None, phase_margin=None, Ms=None)
    found = worst_of(axis(margins={"nominal": margins(2.64, 0.58, 0.1), "matched": bad}))
    assert set(found) == {"peak", "rms", "effort"}


def test_a_margin_that_one_motor_lacks_is_that_of_the_others() -> None:
    some = {"nominal": margins(None, 0.58, 0.1), "matched": margins(9.0, 0.6, 0.03)}
    assert worst_of(axis(margins=some))["gain_margin"] == WorstMotor(9.0, "matched", 0.03)
    none = {"nominal": margins(None, 0.58, 0.1)}
    assert "gain_margin" not in worst_of(axis(margins=none))
