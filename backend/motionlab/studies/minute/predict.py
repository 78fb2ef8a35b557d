"""Another controller on the motor of a recorded stretch, under the stretch's own disturbance.

Members are motors within the errors of the fit, each with the disturbance that is left by its own
mass and friction: the total force of the record is kept, so that only what the controller changes
is unsure. Each has noise of its own, which no record tells.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.planar import AXES
from motionlab.config.plant import AxisConfig, PlantConfig
from motionlab.config.scenario import Scenario
from motionlab.errors import ExperimentFailed
from motionlab.executors.executor import cores
from motionlab.kernel.force_maps import force_model
from motionlab.lanes import model_hash
from motionlab.library.description import labels
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.studies.minute.documents import (
    MinuteAxis,
    MinuteDocument,
    MinuteErrors,
    MotorEstimate,
    PredictedError,
)
from motionlab.studies.minute.motor_fit import (
    DISTURBANCE,
    ELECTRICAL,
    MECHANICAL,
    NAMES,
    Motor,
    MotorFit,
    fit_motor,
    smoothed,
)
from motionlab.studies.minute.recorded import EDGE, MinutePlan
from motionlab.studies.study import Progress
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Errors = NDArray[np.float32]

BAND = (2.5, 97.5)
_DEVIATIONS = 1.96
_BUCKETS = 1000
_UNITS = {
    "M": "kg",
    "sigma_0": "N/m",
    "sigma_1": "N s/m",
    "sigma_2": "N s/m",
    "F_c": "N",
    "F_s": "N",
    "v_s": "m/s",
    "f_0": "N",
} | {name: "1" if name.startswith("gain") else "A" for name in ELECTRICAL}
_ERROR = Sample._fields.index("following_error")
_AT_PEAKS = 1.5
"""By which the members' interval of the largest error is too narrow; tests/bench/minute.py."""
_FIT_SHARE = 0.3  # of the progress
_MISSED = 0.1
"""Share of the recorded error by which the recorded controller, simulated, may miss it."""


@dataclass(frozen=True)
class Prediction:
    """A prediction, whole.

    Attributes
    ----------
    document : MinuteDocument
        For readers.
    time : ndarray, shape (ticks,)
        From the run's first sample on, s.
    curves : dict of str to ndarray, shape (ticks,)
        Errors by axis and name, m.
    """

    document: MinuteDocument
    time: Array
    curves: dict[str, Array]


def predict(planned: MinutePlan, progress: Progress = lambda *_: None) -> Prediction:
    """Predict what another controller would have done.

    Raises
    ------
    ExperimentFailed
        If it diverges in most members, or the recorded one does.
    """
    fits: dict[str, MotorFit] = {}
    for number, axis in enumerate(planned.reversing_axes):
        controller = planned.then.variants[planned.variant].controller
        model, thrust = getattr(controller.model, axis), None
        if planned.then.plant.force != "ideal":
            thrust = force_model(model.force_map, controller.sharing, controller.current_limit)
        fits[axis] = fit_motor(planned.axes[axis], model, thrust, _lag(planned, axis))
        progress(_FIT_SHARE * (number + 1) / len(planned.reversing_axes), None)
    stand = _Stand(planned, fits)
    again = stand.recorded_errors()
    if again is None:
        raise ExperimentFailed("the recorded controller diverges on the motor that was fitted")
    nominal = stand.nominal_errors()
    members = stand.member_errors(progress)
    stable = [each for each in members if each is not None]
    if nominal is None or 2 * len(stable) < len(members):
        raise ExperimentFailed(
            f"the controller of {planned.other} diverges on this motor, in "
            f"{len(members) - len(stable)} of {len(members)} members"
        )
    band = np.array(stable)
    curves: dict[str, Array] = {}
    axes: dict[str, MinuteAxis] = {}
    for axis in planned.reversing_axes:
        column = AXES.index(axis)
        of_axis = _Axis(
            planned.axes[axis].error,
            again[column].astype(np.float64),
            nominal[column].astype(np.float64),
            band[:, column],
        )
        curves |= {f"{axis}.{name}": curve for name, curve in of_axis.curves.items()}
        axes[axis] = _document(planned, axis, fits[axis], of_axis)
    time: Array = (planned.first + np.arange(planned.ticks, dtype=np.float64)) * CONTROL_PERIOD
    warnings = list(planned.warnings)
    warnings += [
        f"on {axis} the recorded controller, simulated on the fitted motor, misses its record by "
        f"{100 * each.miss / each.rms_recorded:.0f} % of the rms error: the motor is no LuGre "
        "motor, or its record was made otherwise"
        for axis, each in axes.items()
        if each.miss > _MISSED * each.rms_recorded
    ]
    if len(stable) < len(members):
        warnings.append(
            f"the controller of {planned.other} diverges in {len(members) - len(stable)} of "
            f"{len(members)} members: the band is of the others"
        )
    document = MinuteDocument(
        run=planned.run.id,
        name=planned.run.name,
        variant=planned.variant,
        label=labels(planned.then)[planned.variant],
        other=planned.other,
        other_label=labels(planned.now)[planned.other],
        start=float(time[EDGE]),
        end=float(time[-EDGE]),
        members=len(members),
        diverged=len(members) - len(stable),
        axes=axes,
        warnings=warnings,
        version=__version__,
        model=model_hash(),
    )
    return Prediction(document, time, curves)


@dataclass(frozen=True)
class _Axis:
    """Following errors of one axis, m: as recorded, simulated, predicted, and of members."""

    recorded: Array
    again: Array
    nominal: Array
    members: Errors

    @property
    def curves(self) -> dict[str, Array]:
        low, high = np.percentile(self.members, BAND, axis=0)
        slow = smoothed(self.recorded - self.again, DISTURBANCE)  # members have noise of their own
        wider = _DEVIATIONS * _rms(inside(slow))
        return {
            "recorded": self.recorded,
            "again": self.again,
            "predicted": self.nominal,
            "low": low - wider,
            "high": high + wider,
        }

    @property
    def miss(self) -> float:
        """RMS by which the recorded controller, simulated, misses its record, m."""
        return _rms(inside(self.recorded - self.again))

    def predicted(self, metric: str) -> PredictedError:
        """Return a metric of the other controller.

        That of the members, widened as far as the recorded controller misses its record. Of the
        largest error their interval is half as wide again: what a motor has beside the model is
        where errors peak.
        """
        of = _peak if metric == "max" else _rms
        each = np.array([of(inside(member.astype(np.float64))) for member in self.members])
        low, value, high = np.percentile(each, (BAND[0], 50.0, BAND[1]))
        wider, times = self.miss, 1.0
        if metric == "max":
            wider, times = _DEVIATIONS * self.miss, _AT_PEAKS
        low = value - times * (value - low) - wider
        high = value + times * (high - value) + wider
        return PredictedError(value=value, low=max(0.0, low), high=high)


def inside(values: Array) -> Array:
    """Return values without the ends of a stretch."""
    return values[..., EDGE:-EDGE]


def _lag(planned: MinutePlan, axis: str) -> float:
    """Return by how much thrust is behind the force in effect, s: held, and through amplifiers."""
    bandwidth = getattr(planned.then.plant, axis).amplifiers.bandwidth
    slow = 0.0 if bandwidth is None or planned.then.plant.force == "ideal" else bandwidth
    return 0.5 * CONTROL_PERIOD + (1.0 / (2.0 * np.pi * slow) if slow else 0.0)


@dataclass(frozen=True)
class _Stand:
    """Simulates a stretch with motors that were fitted to it."""

    planned: MinutePlan
    fits: dict[str, MotorFit]

    def recorded_errors(self) -> Errors | None:
        """Return the errors of the recorded controller on the fitted motor, m."""
        return self._errors(self._fitted, self.planned.then, self.planned.variant)

    def nominal_errors(self) -> Errors | None:
        """Return those of the other controller."""
        return self._errors(self._fitted, self.planned.now, self.planned.other)

    def member_errors(self, progress: Progress) -> list[Errors | None]:
        """Return those of the other controller on motors within the errors of the fit."""
        request = self.planned.request
        rng = np.random.default_rng(request.seed)
        drawn = [
            {axis: fit.drawn(rng) for axis, fit in self.fits.items()}
            for _ in range(request.members)
        ]

        def one(number: int) -> Errors | None:
            noise = request.seed + 1 + number
            return self._errors(drawn[number], self.planned.now, self.planned.other, noise)

        members: list[Errors | None] = []
        with ThreadPoolExecutor(cores()) as pool:
            for number, errors in enumerate(pool.map(one, range(len(drawn)))):
                members.append(errors)
                progress(_FIT_SHARE + (1.0 - _FIT_SHARE) * (number + 1) / len(drawn), None)
        return members

    @property
    def _fitted(self) -> dict[str, Array]:
        return {axis: fit.values for axis, fit in self.fits.items()}

    def _errors(
        self, values: dict[str, Array], scenario: Scenario, variant: str, noise: int | None = None
    ) -> Errors | None:
        """Return the following errors of a controller, m, (2, ticks); None where it diverges."""
        planned = self.planned
        load = np.zeros((planned.ticks, len(AXES)))
        for axis, fit in self.fits.items():
            load[:, AXES.index(axis)] = fit.disturbance(values[axis])
        alone = scenario.model_copy(
            update={
                "plant": self._plant(scenario.plant, values, noisy=noise is not None),
                "variants": {variant: scenario.variants[variant]},
                "seed": scenario.seed if noise is None else noise,
            }
        )
        simulation = Simulation(Prepared(alone, planned.reference, load, ((0, alone),)))
        page, pages = sample_page(1), []
        while count := simulation.advance(page):
            pages.append(variant_columns(page, 0, count)[_ERROR].copy())
            if simulation.failed_ticks[0] is not None:
                return None
        return np.concatenate(pages, axis=1)

    def _plant(self, plant: PlantConfig, values: dict[str, Array], *, noisy: bool) -> PlantConfig:
        """Return a motor whose thrust is what the map of the recorded controller says."""
        model = self.planned.then.variants[self.planned.variant].controller.model
        axes: dict[str, AxisConfig] = {}
        for axis in AXES:
            config, believed = getattr(plant, axis), getattr(model, axis)
            amplifiers: dict[str, Any] = {"gain": (1.0, 1.0, 1.0), "offset": (0.0, 0.0, 0.0)}
            mass, friction = believed.mass, believed.friction.parameters()
            if axis in values:
                motor = Motor.of(values[axis])
                mass, friction = motor.mass, motor.friction
                amplifiers = {"gain": motor.gains, "offset": motor.currents}
            encoder: dict[str, Any] = {}
            if not noisy:
                amplifiers["noise"] = 0.0
                encoder = {"noise": 0.0, "jitter": 0.0}
            changes = {
                "mass": mass,
                "friction": config.friction.model_copy(
                    update={"enabled": True, **friction._asdict()}
                ),
                "force_map": believed.force_map,
                "amplifiers": config.amplifiers.model_copy(update=amplifiers),
                "encoder": config.encoder.model_copy(update=encoder),
                "effects": (),
            }
            axes[axis] = config.model_copy(update=changes)
        return plant.model_copy(update=axes)


def _document(planned: MinutePlan, axis: str, fit: MotorFit, errors: _Axis) -> MinuteAxis:
    recorded = inside(errors.recorded)
    return MinuteAxis(
        reversals=planned.axes[axis].reversals,
        max_recorded=_peak(recorded),
        rms_recorded=_rms(recorded),
        miss=errors.miss,
        max_predicted=errors.predicted("max"),
        rms_predicted=errors.predicted("rms"),
        disturbance=_rms(inside(fit.disturbance(fit.values) - Motor.of(fit.values).offset)),
        motor=_motor(fit),
        errors=_shown(planned, errors.curves),
    )


def _motor(fit: MotorFit) -> dict[str, MotorEstimate]:
    half = _DEVIATIONS * np.sqrt(np.diag(fit.covariance))
    motor: dict[str, MotorEstimate] = {}
    for name, value, wide, prior in zip(NAMES, fit.values, half, fit.prior, strict=False):
        numbers = np.array([value, value - wide, value + wide, prior])
        if name.startswith("gain"):
            numbers += 1.0
        elif name in MECHANICAL[:-1]:
            numbers = np.exp(numbers)
        middle, low, high, believed = numbers.tolist()
        motor[name] = MotorEstimate(
            value=middle, low=low, high=high, believed=believed, unit=_UNITS[name]
        )
    return motor


def _shown(planned: MinutePlan, curves: dict[str, Array]) -> MinuteErrors:
    """Return curves at the instants where the prediction is least and most, bucket by bucket."""
    predicted = curves["predicted"]
    at: set[int] = set()
    for bucket in np.array_split(np.arange(EDGE, planned.ticks - EDGE), _BUCKETS):
        within = predicted[bucket]
        at |= {int(bucket[within.argmin()]), int(bucket[within.argmax()])}
    chosen = np.array(sorted(at))
    time = (planned.first + chosen) * CONTROL_PERIOD
    return MinuteErrors(
        time=_short(time, 7), **{name: _short(curve[chosen], 5) for name, curve in curves.items()}
    )


def _short(values: Array, digits: int) -> list[float]:
    return [float(f"{value:.{digits}g}") for value in values]


def _peak(values: Array) -> float:
    return float(np.abs(values).max())


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
