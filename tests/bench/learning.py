"""Learning from lap to lap: what every motion of Table 1 reaches, for how long, and predictions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from motionlab.studies.learn.documents import LearnRequest
from motionlab.studies.learn.laps import AxisLearning, LapFigures, Learning
from motionlab.studies.learn.learn import carried_over, learning_of
from motionlab.studies.learn.plan import LearnPlan, band, factors, plan
from motionlab.studies.learn.predictions import drawn_motors
from tests.bench.table import Row

_MOTIONS = (
    "circle",
    "rhombus",
    "pentagram",
    "stair-x-500nm",
    "stair-y-500nm",
    "stair-y-50mm",
    "trapezoid-y",
)
_CONTROLLERS = {"matched": "lugre-reference", "matched-resonant": "lugre-reference-notch"}
_NOISE = {f"plant.{axis}.amplifiers.noise": 0.01 for axis in ("x", "y")}  # A rms
_UNSEEN = ("circle", "rhombus", "pentagram", "stair-y-50mm", "trapezoid-y")
_TAUGHT = ("circle", "rhombus", "pentagram", "trapezoid-y")
_GAIN = 0.7
_FRICTIONS: dict[str, dict[str, Any]] = {
    "GMS": {"effect": "gms"},
    "Dahl": {"effect": "dahl"},
    "static Stribeck": {"effect": "static-stribeck"},
    "mu N, mu 0.01": {"effect": "lugre", "mu": 0.01},
}
_LEAST = 0.3  # um
_LAPS, _LONG, _AFTER = 16, 500, 100
_DRAWN, _DRAWN_LAPS = 300, 40
_NOTHING = 1e-12  # learning gain


def learning() -> Iterator[Row]:
    """Measure all."""
    for motor in _CONTROLLERS:
        for motion in _MOTIONS:
            yield from _motion(motor, motion)
    for motor in _CONTROLLERS:
        yield from _long(motor)
    for motor in _CONTROLLERS:
        for motion in _UNSEEN:
            yield from _carried(motor, motion)
    for name, effect in _FRICTIONS.items():
        yield from _friction(name, effect)
    yield _predicted()


def planned(
    motor: str, motion: str, changes: dict[str, Any] | None = None, **more: Any
) -> LearnPlan:
    """Return learning of a motion of Table 1 on a motor, with noise of its currents."""
    own = {"plant": motor, "variants.B.controller": _CONTROLLERS[motor], **_NOISE}
    request = LearnRequest(
        scenario=motion, set=own | (changes or {}), variant="B", motors=0, **more
    )
    return plan(request)


def learnt(planned: LearnPlan) -> Learning:
    """Return learning after all its laps."""
    run = learning_of(planned)
    for _ in run.run(planned.request.laps):
        pass
    return run


def _motion(motor: str, motion: str) -> Iterator[Row]:
    for axis, each in learnt(planned(motor, motion, laps=_LAPS)).axes.items():
        peaks = [1e6 * lap.peak for lap in each.laps]
        true = 1e6 * np.mean([lap.true_peak for lap in each.laps[-3:]])
        at = " ".join(f"{peaks[lap - 1]:.2f}" for lap in (1, 2, 4, 8, 12, 16))
        yield Row(
            f"{motion} {axis}, {motor}: max error in laps 1 2 4 8 12 16",
            "no worse than lap 1",
            f"{at} um",
            f"true, last 3: {true:.2f} um",
            f"{peaks[-1] / peaks[0]:.3f}",
            peaks[-1] <= peaks[0],
        )


def _friction(name: str, effect: dict[str, Any]) -> Iterator[Row]:
    """Learn on a motor whose friction is not that of the controller's model."""
    changes: dict[str, Any] = {}
    for axis in ("x", "y"):
        changes |= {f"plant.{axis}.friction.enabled": False, f"plant.{axis}.effects": [effect]}
    for axis, each in learnt(planned("matched", "circle", changes, laps=_LAPS)).axes.items():
        first, last = each.laps[0], np.mean([1e6 * lap.peak for lap in each.laps[-4:]])
        true = np.mean([1e6 * lap.true_peak for lap in each.laps[-4:]])
        yield Row(
            f"circle {axis}, matched with friction of {name}: max error, mean of laps 13 to 16",
            f"<= {_LEAST:g} um",
            f"{1e6 * first.peak:.2f} -> {last:.2f} um",
            f"true: {true:.2f} um",
            f"{last / (1e6 * first.peak):.3f}",
            bool(last <= _LEAST),
        )


def _long(motor: str) -> Iterator[Row]:
    for axis, each in learnt(planned(motor, "circle", laps=_LONG)).axes.items():
        last = [1e6 * lap.peak for lap in each.laps[-_AFTER:]]
        true = [1e6 * lap.true_peak for lap in each.laps[-_AFTER:]]
        yield Row(
            f"circle {axis}, {motor}: max error, mean of laps {_LONG - _AFTER} to {_LONG}",
            "<= 0.1 um",
            f"{np.mean(last):.3f} um, largest {max(last):.3f}",
            f"true: {np.mean(true):.3f} um, largest {max(true):.3f}",
            f"{np.mean(last) / (1e6 * each.laps[0].peak):.3f}",
            bool(np.mean(last) <= 0.1),
        )


def _carried(motor: str, motion: str) -> Iterator[Row]:
    """Compare a third lap with what three other motions taught with one without, and one learnt."""
    after = tuple(each for each in _TAUGHT if each != motion)[:3]
    asked = planned(motor, motion, after=after, laps=1)
    begun = learning_of(asked)
    carried = carried_over(asked, begun)
    other, full = learning_of(asked), learnt(planned(motor, motion, laps=_LAPS))
    for each in (begun, other):
        for axis in each.axes.values():
            axis.gain, axis.encoder = _NOTHING, None
        for _ in each.run(3):
            pass
    for axis in carried:
        first, without, last = (
            1e6 * each.axes[axis].laps[-1].peak for each in (begun, other, full)
        )
        gain = (without - first) / (without - last)
        yield Row(
            f"{motion} {axis}, {motor}, never run, after {', '.join(carried[axis].motions)}",
            f">= {100 * _GAIN:.0f} % of the gain",
            f"{without:.2f} -> {first:.2f} um",
            f"learnt: {last:.2f} um",
            f"{gain:.2f}",
            gain >= _GAIN,
        )


def _predicted() -> Row:
    """Draw motors, predict for each whether learning converges, and learn."""
    base = planned("matched", "circle", laps=_DRAWN_LAPS, anyway=True)
    many = replace(base, request=base.request.model_copy(update={"motors": _DRAWN}))
    right, growing = 0, 0
    for motor in drawn_motors(many):
        tables = motor.model_dump(mode="json")
        own = plan(base.request.model_copy(update={"scenario": tables, "set": {}}))
        rho = {axis: factors(own, axis, motor, band(own.filters[axis])) for axis in own.filters}
        run = learnt(own)
        for axis, each in run.axes.items():
            converges = run.laps == _DRAWN_LAPS and fell(each)
            growing += not converges
            right += (rho[axis].max() < 1.0) == converges
    return Row(
        f"predicted right, {_DRAWN} drawn motors, both axes",
        ">= 95 %",
        f"{100 * right / (2 * _DRAWN):.1f} %",
        f"{growing} of {2 * _DRAWN} do not converge",
        f"{right / (2 * _DRAWN):.3f}",
        right >= 0.95 * 2 * _DRAWN,
    )


def fell(axis: AxisLearning) -> bool:
    """Return whether an error fell, and did not rise again."""
    rms = np.array([lap.rms for lap in axis.laps])
    smooth = np.convolve(rms, np.ones(3) / 3, "valid")
    return not _went_back(axis.laps) and bool(smooth[-1] < 1.3 * smooth.min())


def _went_back(laps: list[LapFigures]) -> bool:
    return any(lap.went_back for lap in laps)
