"""How often the 95 % intervals of an identification hold the truth, over seeded draws of motors.

``make bench BENCH=coverage`` identifies `DRAWS` motors under the default experiment: half of them
with noise, half of x, half under a constant load, half with friction within a factor of two of the
nominal one and the others within a quarter. ``MOTIONLAB_DRAWS`` gives another number.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.studies.identify.documents import read_request
from motionlab.studies.identify.experiment import identify, plan
from tests.bench.table import Row

DRAWS = 240
SEED = 50_000
"""Of the first draw; none of them was looked at when the method was chosen."""

SLIDING = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
PRESLIDING = ("sigma_0", "sigma_1", "M")
FRICTION = ("F_c", "F_s", "v_s", "sigma_2", "sigma_0", "sigma_1")
_ENCODER_NOISE = 20e-9  # m rms
_CURRENT_NOISE = 10e-3  # A rms
_LOAD = 0.3  # N
_NEAR, _WIDE = 0.25, 2.0
"""Friction within a share of the nominal one, and within a factor."""

_LOW, _HIGH = 0.93, 0.97


class Draw(NamedTuple):
    """One motor to be identified."""

    seed: int
    axis: str
    noisy: bool
    loaded: bool
    wide: bool
    request: Mapping[str, Any]


class Outcome(NamedTuple):
    """What became of one draw: error, half of the interval and true value by name."""

    draw: Draw
    parameters: dict[str, tuple[float, float, float]]

    def holds(self, name: str) -> bool:
        """Return whether the interval of a parameter holds its true value."""
        error, half, _ = self.parameters[name]
        return abs(error) <= half


def draws(count: int, seed: int, request: Mapping[str, Any] | None = None) -> list[Draw]:
    """Return motors: quiet and noisy by turns, two of x, two of y, four loaded, and so on."""
    return [
        Draw(
            seed + k,
            axis="xy"[k // 2 % 2],
            noisy=bool(k % 2),
            loaded=bool(k // 4 % 2),
            wide=bool(k // 8 % 2),
            request={} if request is None else request,
        )
        for k in range(count)
    ]


def outcome(draw: Draw) -> Outcome:
    """Identify one motor and compare with what it is."""
    rng = np.random.default_rng(draw.seed)
    at = f"plant.{draw.axis}"
    known = getattr(load_scenario("circle").plant, draw.axis).friction
    ratio = _WIDE ** rng.uniform(-1, 1, 6) if draw.wide else rng.uniform(1 - _NEAR, 1 + _NEAR, 6)
    changes: dict[str, float] = {
        f"{at}.friction.{name}": getattr(known, name) * float(times)
        for name, times in zip(FRICTION, ratio, strict=True)
    }
    load = rng.uniform(-_LOAD, _LOAD) if draw.loaded else 0.0
    changes[f"load.{draw.axis}"] = load
    if draw.noisy:
        changes |= {
            f"{at}.encoder.noise": _ENCODER_NOISE,
            f"{at}.amplifiers.noise": _CURRENT_NOISE,
        }
    request = {**draw.request, "axis": draw.axis, "set": {**changes, "seed": draw.seed}}
    found = identify(plan(read_request(request))).axes[draw.axis]
    assert found.presliding is not None
    parameters: dict[str, tuple[float, float, float]] = {}
    for name, p in {**found.sliding.parameters, **found.presliding.parameters}.items():
        true = load if name == "f_0" else p.true
        assert true is not None
        half = np.inf if p.high is None else p.high - p.value
        parameters[name] = (p.value - true, half, true)
    return Outcome(draw, parameters)


def coverage() -> Iterator[Row]:
    """Identify many motors, one process a core; count what the intervals hold."""
    count = int(os.environ.get("MOTIONLAB_DRAWS", DRAWS))
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        outcomes = [*pool.map(outcome, draws(count, SEED))]
    for name in (*SLIDING, *PRESLIDING):
        yield _held(f"{name}: {count} draws", [(o, name) for o in outcomes], judged=True)
    for noisy, loaded, wide in itertools.product((False, True), repeat=3):
        group = [o for o in outcomes if o.draw[2:5] == (noisy, loaded, wide)]
        kind = f"{'noisy' if noisy else 'quiet'}, {'loaded' if loaded else 'no load'}"
        kind += ", wide friction" if wide else ""
        for label, names in (("sliding", SLIDING), ("presliding", PRESLIDING)):
            yield _held(f"  {label}, {kind}", [(o, n) for o in group for n in names])
    for noisy, axis in itertools.product((False, True), "xy"):
        group = [o for o in outcomes if (o.draw.noisy, o.draw.axis) == (noisy, axis)]
        for name in (*SLIDING, *PRESLIDING):
            kind = f"{axis} {'with' if noisy else 'without'} noise"
            yield _held(f"    {name}, {kind}", [(o, name) for o in group], widths=True)


def _held(
    label: str, cases: list[tuple[Outcome, str]], *, judged: bool = False, widths: bool = False
) -> Row:
    held = sum(o.holds(name) for o, name in cases)
    share = held / len(cases) if cases else float("nan")
    measured = f"{share:.1%}"
    if widths and cases:
        half, true = (np.median([o.parameters[n][k] for o, n in cases]) for k in (1, 2))
        forces = any(name == "f_0" for _, name in cases)
        measured += f", +-{half:.1e} N" if forces else f", +-{half / true:.1e}"
    return Row(
        label,
        f"{_LOW:.0%} to {_HIGH:.0%}" if judged else "",
        measured,
        f"{held} of {len(cases)}",
        "",
        _LOW <= share <= _HIGH if judged else None,
    )
