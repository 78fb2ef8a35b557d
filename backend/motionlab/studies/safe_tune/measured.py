"""What a kept run measured of a motion, and whether it was the same motion but for its gains."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.columns import of_run
from motionlab.studies.minute.recorded import scenario_at
from motionlab.studies.record.part import kept_run
from motionlab.studies.safe_tune.documents import SafeTuneRequest

_NAMED = 6  # differences that are listed
_PRESENT = 0.95  # least share of samples: late cycles of drives leave some out
_SPOILING = {"change", "law", "push", "stop"}
_END = 200  # last samples, of which one has to be there: it has not diverged


class RunMeasured(NamedTuple):
    """What a motion measured.

    Attributes
    ----------
    run : str or None
        Kept run; None in a rehearsal.
    k_p, k_d : float
        Its gains.
    metric, error : float
        Following error over the window, as requested, and largest from the first tick on, m.
    force : float
        Largest force command, N. All three are infinite where a rehearsed motion diverged.
    delay : int
        Periods from a measurement to its command: drives have one more than a simulation.
    """

    run: str | None
    k_p: float
    k_d: float
    metric: float
    error: float
    force: float
    delay: int = 0


def read_run(  # noqa: PLR0913 - what a run is held against
    run_id: str,
    loc: str,
    *,
    scenario: Scenario,
    variant: str,
    request: SafeTuneRequest,
    window: tuple[int, int],
) -> RunMeasured:
    """Return what a run measured.

    Raises
    ------
    ConfigError
        If there is no such run, its motion or controller is another but for the gains, they were
        changed during it, it does not reach the end of the window, or samples are missing.
    """
    run = kept_run(run_id, loc)
    if run.scenario_document is None:
        message = "is an imported measurement, without the lab's controller"
        raise ConfigError(FieldError(loc, message, run_id))
    if variant not in run.variants:
        allowed = "one of " + ", ".join(run.variants)
        raise ConfigError(FieldError("variant", f"is no variant of run {run_id}", variant, allowed))
    start, end = window
    for event in run.events:
        from_the_start = event.kind == "change" and event.tick <= run.first_tick
        if event.kind in _SPOILING and event.tick < end and not from_the_start:
            message = f"run {run_id} has a {event.kind} in the motion"
            raise ConfigError(FieldError(loc, message, event.tick, unit="ticks"))
    own = scenario_at(run, 0)
    same_but_gains(scenario, own, variant, request.axis, loc)
    gains: Any = getattr(own.variants[variant].controller, request.axis)
    names = [f"{variant}.{request.axis}.{name}" for name in ("following_error", "force_command")]
    if run.first_tick > 0 or run.first_tick + run.ticks < end:
        message = f"run {run_id} has not the whole motion, from its first tick to the window's end"
        raise ConfigError(FieldError(loc, message, run.ticks, f">= {end}", "ticks"))
    samples = of_run(run_id).read(names)[:, :end].astype(np.float64)
    there = np.asarray(np.isfinite(samples).all(axis=0))
    if there.mean() < _PRESENT or not there[-_END:].any():
        message = f"run {run_id} has samples missing, or diverged; share that is there"
        share = float(f"{there.mean():.4g}")
        raise ConfigError(FieldError(loc, message, share, f">= {_PRESENT}"))
    error, force = np.abs(samples[0][there]), np.abs(samples[1][there])
    inside = np.abs(samples[0][start:][there[start:]])
    metric = inside.max() if request.metric == "peak" else np.sqrt(np.mean(inside**2))
    return RunMeasured(
        run_id,
        gains.k_p,
        gains.k_d,
        float(metric),
        float(error.max()),
        float(force.max()),
        own.variants[variant].controller.delay,
    )


def same_but_gains(scenario: Scenario, own: Scenario, variant: str, axis: str, loc: str) -> None:
    """Refuse a run whose motion or controller is another one, but for the gains of the axis.

    Of a response the motion does not matter.

    Raises
    ------
    ConfigError
        Naming what differs.
    """
    here, there = (_essence(each, variant, axis) for each in (scenario, own))
    if loc == "response":
        here["trajectory"], here["learnt"] = there["trajectory"], there["learnt"]
    differing = sorted(_differences(here, there))
    if differing:
        more = f" and {len(differing) - _NAMED} more" if len(differing) > _NAMED else ""
        listed = ", ".join(differing[:_NAMED])
        message = f"is a run of another motion or controller: {listed}{more} differ"
        raise ConfigError(FieldError(loc, message))


def _essence(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    if variant not in scenario.variants:
        return {"variant": None}
    controller = scenario.variants[variant].controller.model_dump(mode="json")
    controller[axis] = {k: v for k, v in controller[axis].items() if k not in {"k_p", "k_d"}}
    other = "y" if axis == "x" else "x"
    for name in (other, "delay"):
        controller.pop(name)
    whole = scenario.model_dump(mode="json", include={"trajectory", "learnt", "schedule"})
    return {**whole, "controller": controller}


def _differences(here: Any, there: Any, path: str = "") -> set[str]:
    if isinstance(here, dict) and isinstance(there, dict):
        differing: set[str] = set()
        for key in here.keys() | there.keys():
            differing |= _differences(
                here.get(key), there.get(key), f"{path}.{key}" if path else key
            )
        return differing
    return set() if here == there else {path}
