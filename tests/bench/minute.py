"""Recorded stretches under another law: motors, frictions, loads and laws drawn at random."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ExperimentFailed
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run
from motionlab.studies.minute.documents import MinuteRequest
from motionlab.studies.minute.predict import Prediction, inside, predict
from motionlab.studies.minute.recorded import MinutePlan, RecordedAxis
from motionlab.studies.montecarlo.documents import DEFAULT
from motionlab.studies.montecarlo.draw import draw
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD
from tests.bench.table import Row
from tests.library.sample_runs import sample

Array = NDArray[np.float64]

_DRAWS = int(os.environ.get("MOTIONLAB_DRAWS", "40"))
_FIRST = 100  # draws before were for building it
_LAPS = 6  # of the circle, 20 s
_RECORDED = ("pd", "pd", "lugre-observer")
_SIMILAR = ("pd", "lugre-observer", "reversed-k", "residual-k")
_STIFF = ("lugre-full", "lugre-reference")
_FRICTIONS: tuple[tuple[str, dict[str, Any] | None], ...] = (
    ("LuGre", None),
    ("GMS", {"effect": "gms"}),
    ("Dahl", {"effect": "dahl"}),
    ("mu N, mu 0.01", {"effect": "lugre", "mu": 0.01}),
)
_GAINS = {"x": {"k_p": 200300.0, "k_d": 1530.0}, "y": {"k_p": 280500.0, "k_d": 1080.0}}
_HELD = 0.93, 0.97
_OFF = {"similar": 1.0, "stiff": 5.0}  # %


@dataclass(frozen=True)
class Outcome:
    """What became of one axis."""

    kind: str
    friction: str
    inside: float
    held: bool
    off: float
    rms_held: bool


def minute() -> Iterator[Row]:
    """Predict all, and hold them against what the other law does."""
    begun = time.perf_counter()
    outcomes: list[Outcome] = []
    refused = 0
    for number in range(_FIRST, _FIRST + _DRAWS):
        try:
            outcomes += _outcomes(number)
        except ExperimentFailed:
            refused += 1
    took = (time.perf_counter() - begun) / _DRAWS
    of_lugre = [each for each in outcomes if each.friction == "LuGre"]
    for kind, most in _OFF.items():
        yield _off(f"{kind} laws, LuGre friction", kind, of_lugre, most)
        yield _off(f"{kind} laws, other frictions", kind, _others(outcomes), most)
    for what, some in (("LuGre friction", of_lugre), ("other frictions", _others(outcomes))):
        points = float(np.mean([each.inside for each in some]))
        maxima = float(np.mean([each.held for each in some]))
        for name, share in (("points", points), ("maxima", maxima)):
            yield Row(
                f"{name} of the other law inside the band, {what}",
                f"{100 * _HELD[0]:.0f} to {100 * _HELD[1]:.0f} %",
                f"{100 * share:.1f} %",
                f"{len(some)} axes",
                f"{share:.3f}",
                _HELD[0] <= share <= _HELD[1],
            )
    seconds = _LAPS * 3.0
    yield Row(
        f"a stretch of {seconds:.0f} s, both axes, 24 members", "", f"{took:.1f} s", "", "", None
    )
    yield Row("stretches that are refused, since members diverge", "", f"{refused} of {_DRAWS}")


def _others(outcomes: list[Outcome]) -> list[Outcome]:
    return [each for each in outcomes if each.friction != "LuGre"]


def _off(what: str, kind: str, outcomes: list[Outcome], most: float) -> Row:
    off = 100.0 * np.array([each.off for each in outcomes if each.kind == kind])
    middle = float(np.median(off))
    return Row(
        f"max error of {what}, median by which it is off",
        f"<= {most:g} %",
        f"{middle:.1f} %",
        f"largest {off.max():.0f} %, {len(off)} axes",
        f"{middle / most:.2f}",
        middle <= most,
    )


def _outcomes(number: int) -> Iterator[Outcome]:
    rng = np.random.default_rng(number)
    recorded = str(rng.choice(_RECORDED))
    kind = "stiff" if number % 2 else "similar"
    laws = [law for law in (_STIFF if number % 2 else _SIMILAR) if law != recorded]
    other = str(rng.choice(laws))
    friction, effect = _FRICTIONS[0 if rng.random() < 0.6 else 1 + rng.integers(3)]
    planned, truth = _stretch(number, (recorded, other), effect, rng)
    prediction = predict(planned)
    for axis in planned.reversing_axes:
        yield _outcome(prediction, axis, truth, kind, friction)


def _outcome(
    prediction: Prediction, axis: str, truth: VariantRecord, kind: str, friction: str
) -> Outcome:
    document = prediction.document.axes[axis]
    error = inside(truth.channel("following_error", axis).astype(np.float64))
    low, high = (inside(prediction.curves[f"{axis}.{end}"]) for end in ("low", "high"))
    peak, rms = float(np.abs(error).max()), float(np.sqrt(np.mean(error**2)))
    of_max, of_rms = document.max_predicted, document.rms_predicted
    return Outcome(
        kind,
        friction,
        float(np.mean((error >= low) & (error <= high))),
        of_max.low <= peak <= of_max.high,
        abs(of_max.value / peak - 1.0),
        of_rms.low <= rms <= of_rms.high,
    )


def _stretch(
    number: int, laws: tuple[str, str], effect: dict[str, Any] | None, rng: np.random.Generator
) -> tuple[MinutePlan, VariantRecord]:
    """Return a stretch that was recorded under one law, and what the other does in truth."""
    sets: dict[str, Any] = {"plant": "matched", "trajectory.laps": _LAPS}
    for letter, law in zip("AB", laws, strict=True):
        sets[f"variants.{letter}"] = {"label": law, "controller": {"base": law, **_GAINS}}
    for axis in AXES:
        sets[f"plant.{axis}.amplifiers.noise"] = 0.01
        sets[f"plant.{axis}.encoder.noise"] = 10e-9
    believed = load_scenario("circle", sets)
    tables = believed.plant.model_dump(mode="json")
    motor = draw(tables, DEFAULT, cases=number + 1, seed=1)[number]
    if effect is not None:
        motor = {path: value for path, value in motor.items() if ".friction." not in path}
        for axis in AXES:
            motor |= {f"plant.{axis}.friction.enabled": False, f"plant.{axis}.effects": [effect]}
    true = load_scenario("circle", sets | motor | {"seed": 1000 + number, "load.noise": 0.03})
    prepared = prepare(true, checked=True)
    prepared = replace(prepared, load=_load(prepared, rng))
    records = run(prepared).variants
    axes = {axis: _recorded(prepared, records["A"], axis) for axis in AXES}
    request = MinuteRequest(run="r-aaaaaaaaaaaa", members=24)
    moving = prepared.reference.moving
    detail = sample()
    plan = MinutePlan(request, detail, 0, believed, believed, "A", "B", axes, moving, ())
    return plan, records["B"]


def _recorded(prepared: Prepared, record: VariantRecord, axis: str) -> RecordedAxis:
    reference, lane = prepared.reference, AXES.index(axis)
    rows = (reference.position, reference.velocity, reference.acceleration)
    motion = np.stack([row[:, lane] for row in rows]).astype(np.float32).astype(np.float64)
    error, force = (
        record.channel(name, axis).astype(np.float64)
        for name in ("following_error", "force_realised")
    )
    return RecordedAxis(motion, error, force, 2 * _LAPS)


def _load(prepared: Prepared, rng: np.random.Generator) -> Array:
    """Return a load that drifts, hums and knocks once, N, (ticks, 2)."""
    ticks = prepared.reference.ticks
    time = np.arange(ticks) * CONTROL_PERIOD
    load = np.cumsum(0.1 * np.sqrt(CONTROL_PERIOD) * rng.standard_normal((ticks, 2)), axis=0)
    for axis in range(2):
        for _ in range(3):
            size, frequency, phase = rng.uniform((0.0, 2.0, 0.0), (0.3, 15.0, 2.0 * np.pi))
            load[:, axis] += size * np.sin(2.0 * np.pi * frequency * time + phase)
        begin = int(rng.integers(ticks // 4, 3 * ticks // 4))
        load[begin : begin + 40, axis] += 0.8
    return load
