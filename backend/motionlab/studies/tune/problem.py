"""The tuning problem: a variant's axes, the motors and motion of its trials, their simulation.

A trial moves one set of gains through the motion in lanes of its own, each axis by itself.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig, GainsConfig
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario, WindowConfig
from motionlab.errors import ConfigError, FieldError, Infeasible
from motionlab.kernel.build import mover_parameters
from motionlab.kernel.layout import parameter_row
from motionlab.loop.family import stability_limits
from motionlab.loop.linearise import SLIDING, linearise
from motionlab.simulation.batch_runner import BatchRunner, Scores
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.tune.documents import LandscapeRequest, TuneRequest
from motionlab.studies.tune.further_numbers import check_further
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]


class Outcome(NamedTuple):
    """Metrics of one axis under one set of gains, over the window.

    Attributes
    ----------
    peak, rms : float
        Of the following error, m.
    itae : float
        Integral of time times abs(e), m s^2.
    settling : float
        Longest settling time of a hold, s; the window's length where it never settles or none is.
    effort : float
        Root mean square of the thrust, N.
    force : float
        Largest thrust, N.
    saturated : float
        Share of ticks with force or current at its limit.
    diverged : bool
        Whether it diverged; then the others are infinite.
    """

    peak: float
    rms: float
    itae: float
    settling: float
    effort: float
    force: float
    saturated: float
    diverged: bool


DIVERGED = Outcome(*[math.inf] * 7, diverged=True)

METRICS = {
    "peak": "max_abs_following_error",
    "rms": "rms_following_error",
    "itae": "itae",
    "settling": "settling_time",
    "effort": "rms_force",
    "force": "max_abs_force",
    "saturated": "saturated_fraction",
}
"""Names in `motionlab.analysis.metrics`."""

_K_P, _K_D = parameter_row("controller.k_p"), parameter_row("controller.k_d")


class TrialSetup:
    """Trial setup of gain sets: motor, motion, window.

    Parameters
    ----------
    prepared : Prepared
        Motor, motion, load and noise, in effect all the time; its variants do not matter.
    window : tuple of int
        Ticks [start, end); a trial ends with it.
    """

    def __init__(self, prepared: Prepared, window: tuple[int, int]) -> None:
        self._arguments = prepared, window
        start, end = window
        whole = prepared.reference
        self.scenario: Scenario = prepared.scenario.model_copy(
            update={
                "window": WindowConfig(start=start * CONTROL_PERIOD, end=end * CONTROL_PERIOD),
                "schedule": (),
            }
        )
        self.window = window
        self.reference = dataclasses.replace(
            whole,
            position=whole.position[:end],
            velocity=whole.velocity[:end],
            acceleration=whole.acceleration[:end],
            holds=tuple((a, b) for a, b in whole.holds if a < end),
        )
        load = prepared.load[:end]
        self._runner = BatchRunner(
            Prepared(self.scenario, self.reference, load, epochs=((0, self.scenario),))
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Return its pickled form: another process computes the inputs again."""
        return TrialSetup, self._arguments

    @property
    def seconds(self) -> float:
        """Simulated time of a trial, s."""
        return self.window[1] * CONTROL_PERIOD

    def run(self, controllers: Sequence[ControllerConfig]) -> list[dict[str, Outcome]]:
        """Return the outcome of each axis under each controller."""
        movers = np.array([mover_parameters(self.scenario, one) for one in controllers])
        scores = self._runner.score(movers.transpose(0, 2, 1)[None])
        return [
            {axis: self._outcome(scores, mover, a) for a, axis in enumerate(AXES)}
            for mover in range(len(controllers))
        ]

    def over_gains(
        self,
        controller: ControllerConfig,
        k_p: Array,
        k_d: Array,
        progress: Callable[[float], None] | None = None,
        *,
        threads: int | None = None,
    ) -> dict[str, Array]:
        """Return metrics, shape (n, 2), of both axes under n pairs of gains, the same for both.

        Parameters
        ----------
        controller : ControllerConfig
            All but its gains.
        k_p, k_d : ndarray, shape (n,)
            N/m and N s/m.
        progress : callable, optional
            Takes the share done; what it raises ends the work.
        threads : int, optional
            How many threads to use; one for each core when left out.
        """
        one = np.array(mover_parameters(self.scenario, controller)).T
        movers = np.repeat(one[None], len(k_p), axis=0)
        movers[:, _K_P], movers[:, _K_D] = k_p[:, None], k_d[:, None]
        scores = self._runner.score(movers[None], threads=threads, progress=progress)
        metrics = {name: scores.metrics[metric] for name, metric in METRICS.items()}
        metrics["settling"] = np.where(
            np.isnan(metrics["settling"]), self._never, metrics["settling"]
        )
        return {
            name: np.where(scores.failed >= 0, math.inf, values) for name, values in metrics.items()
        }

    @property
    def _never(self) -> float:
        return (self.window[1] - self.window[0]) * CONTROL_PERIOD

    def _outcome(self, scores: Scores, mover: int, axis: int) -> Outcome:
        if scores.failed[mover, axis] >= 0:
            return DIVERGED
        metrics = {name: float(scores.metrics[m][mover, axis]) for name, m in METRICS.items()}
        if math.isnan(metrics["settling"]):
            metrics["settling"] = self._never
        return Outcome(**metrics, diverged=False)


Source = str | Path | Mapping[str, Any]


@dataclass(frozen=True)
class TuningProblem:
    """A tuning problem that has passed every check.

    Attributes
    ----------
    request : TuneRequest or LandscapeRequest
        As validated.
    scenario : Scenario
        Parameters in effect at the window's end, of the one variant, without a schedule.
    variant : str
        Variant to tune.
    axes : tuple of str
        Axes that are tuned: the requested ones that move.
    setups : dict of str to TrialSetup
        By name of the motor; the scenario's own is the first.
    """

    request: TuneRequest | LandscapeRequest
    scenario: Scenario
    variant: str
    axes: tuple[str, ...]
    setups: dict[str, TrialSetup]

    @property
    def controller(self) -> ControllerConfig:
        """The controller as it is."""
        return self.scenario.variants[self.variant].controller

    @property
    def own(self) -> TrialSetup:
        """The trials on the scenario's own motor."""
        return next(iter(self.setups.values()))

    @property
    def seconds(self) -> float:
        """Simulated time of all trials, summed over axes, s."""
        request = self.request
        if isinstance(request, TuneRequest):
            trials = request.starts * request.evaluations
        else:
            trials = request.points**2
        return self.own.seconds * trials * len(self.setups) * len(self.axes)

    def published(self, axis: str) -> GainsConfig:
        """Return the paper's gains for the motion of this scenario; see `published_gains`."""
        return published_gains(self.scenario.name, axis)

    def path(self, field: str) -> str:
        """Return the scenario path of a controller's field."""
        return f"variants.{self.variant}.controller.{field}"


def published_gains(scenario: str, axis: str) -> GainsConfig:
    """Return the gains that the paper prints for the motion of a shipped scenario.

    They are those of its first controller, and of the circle for another scenario: the pentagram's.
    """
    shipped = load_scenario(scenario if scenario in names("scenarios") else "circle")
    return getattr(next(iter(shipped.variants.values())).controller, axis)


def plan(request: TuneRequest | LandscapeRequest, source: Source | None = None) -> TuningProblem:
    """Return the validated tuning problem of a request.

    Raises
    ------
    ConfigError
        Naming every field that is wrong.
    Infeasible
        If the motor cannot follow the motion.
    """
    source = request.scenario if source is None else source
    own = _trials(request, source, {})
    scenario = own.scenario
    setups = {plant_name(scenario.plant): own}
    for name in request.plants:
        other = _also_on(request, source, name)
        if other.scenario.plant != scenario.plant:
            setups[f"{name} as shipped" if name in setups else name] = other
    (variant,) = scenario.variants
    axes = _moving(request, own)
    if isinstance(request, TuneRequest):
        check_further(request, scenario, variant)
    if "settling" in request.objective:
        _refuse_without_hold(own)
    return TuningProblem(request, scenario, variant, axes, setups)


def unstable_warnings(problem: TuningProblem) -> list[str]:
    """Return a sentence for each axis whose present gains are unstable, with the gain's limit."""
    try:
        return [
            warning
            for axis in problem.axes
            for speed in (SLIDING, 0.0)
            if (warning := _unstable_warning(problem, axis, speed))
        ]
    except ConfigError as error:
        return [f"{error.errors[0].loc} {error.errors[0].message}: margins are not looked at"]


def _unstable_warning(problem: TuningProblem, axis: str, speed: float) -> str:
    scenario, variant = problem.scenario, problem.variant
    v = speed * getattr(scenario.plant, axis).friction.v_s
    if linearise(scenario, variant, axis, v=v).stable:
        return ""
    gains = getattr(problem.controller, axis)
    units = {"k_p": "N/m", "k_d": "N s/m"}
    named = [
        f"{problem.path(f'{axis}.{gain}')} = {getattr(gains, gain):.6g} {units[gain]}"
        + (f" (the stability boundary, moved alone: {limit:.6g})" if limit else "")
        for gain, limit in stability_limits(scenario, variant, axis, speed).items()
    ]
    where = "" if speed else " at standstill"
    return f"the present gains are unstable{where}: {', '.join(named)}"


def _trials(
    request: TuneRequest | LandscapeRequest, source: Source, changes: dict[str, Any]
) -> TrialSetup:
    """Return the trial runs of the variant."""
    loaded = load_scenario(source, request.set | changes)
    variant = request.chosen(loaded)
    if request.window is not None:
        loaded = loaded.model_copy(update={"window": request.window})
    whole = prepare(loaded)
    window = whole.window
    period = whole.reference.period
    if loaded.window is None and period:
        window = (window[0], min(window[1], window[0] + period))
    effect = [scenario for tick, scenario in whole.epochs if tick < window[1]][-1]
    steady = effect.model_copy(
        update={"variants": {variant: effect.variants[variant]}, "schedule": ()}
    )
    return TrialSetup(dataclasses.replace(whole, scenario=steady), window)


def _also_on(request: TuneRequest | LandscapeRequest, source: Source, motor: str) -> TrialSetup:
    """Return the trial runs on another motor; errors name it."""
    try:
        return _trials(request, source, {"plant": motor})
    except Infeasible as error:
        message = f"this motor cannot follow the motion: {error}"
        raise ConfigError(FieldError("plants", message, motor)) from None


def _moving(request: TuneRequest | LandscapeRequest, trials: TrialSetup) -> tuple[str, ...]:
    moving = trials.reference.moving
    axes = tuple(axis for axis in request.axes if axis in moving)
    if not axes:
        raise ConfigError(
            FieldError(
                loc="axis",
                message="does not move in this scenario",
                value=request.axis,
                range="one of " + ", ".join(moving) if moving else "none moves",
            )
        )
    return axes


def _refuse_without_hold(trials: TrialSetup) -> None:
    start, end = trials.window
    if not any(start <= begin < end for begin, _ in trials.reference.holds):
        raise ConfigError(
            FieldError(
                loc="objective.settling",
                message="needs a motion that comes to rest; there is none in the window",
            )
        )
