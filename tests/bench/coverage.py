"""How often the 95 % intervals of an identification hold the truth, over seeded draws of motors.

``make bench BENCH=coverage`` identifies `DRAWS` motors, half of them with noise; the variable
``MOTIONLAB_DRAWS`` gives another number. A draw is one axis, x and y by turns, whose friction
parameters are each within a quarter of the nominal ones, under the default experiment.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.studies.identify.experiment import identify
from motionlab.studies.identify.plan import plan
from motionlab.studies.identify.request import read_request
from tests.bench.table import Row

DRAWS = 200
SEED = 30_000
"""Of the first draw; none below it has been looked at when the method was chosen or after."""

SLIDING = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
PRESLIDING = ("sigma_0", "sigma_1", "M")
FRICTION = ("F_c", "F_s", "v_s", "sigma_2", "sigma_0", "sigma_1")
_ENCODER_NOISE = 20e-9  # m rms
_CURRENT_NOISE = 10e-3  # A rms
_LOW, _HIGH = 0.93, 0.97


class Draw(NamedTuple):
    """One motor to be identified."""

    seed: int
    axis: str
    noisy: bool
    request: Mapping[str, Any]


class Outcome(NamedTuple):
    """What became of one draw: error, half of the interval and true value by name."""

    axis: str
    noisy: bool
    parameters: dict[str, tuple[float, float, float]]

    def holds(self, name: str) -> bool:
        """Return whether the interval of a parameter holds its true value."""
        error, half, _ = self.parameters[name]
        return abs(error) <= half


def draws(count: int, seed: int, request: Mapping[str, Any] | None = None) -> list[Draw]:
    """Return motors: quiet and noisy by turns, two of x, two of y, and so on."""
    return [
        Draw(seed + k, "xy"[k // 2 % 2], bool(k % 2), {} if request is None else request)
        for k in range(count)
    ]


def outcome(draw: Draw) -> Outcome:
    """Identify one motor and compare with what it is."""
    rng = np.random.default_rng(draw.seed)
    at = f"plant.{draw.axis}"
    known = getattr(load_scenario("circle").plant, draw.axis)
    changes: dict[str, float] = {
        f"{at}.friction.{name}": getattr(known.friction, name) * rng.uniform(0.75, 1.25)
        for name in FRICTION
    }
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
        true = p.true or 0.0  # f_0: no load pulls
        half = np.inf if p.high is None else p.high - p.value
        parameters[name] = (p.value - true, half, true)
    return Outcome(draw.axis, draw.noisy, parameters)


def coverage() -> Iterator[Row]:
    """Identify many motors, one process a core; count what the intervals hold."""
    count = int(os.environ.get("MOTIONLAB_DRAWS", DRAWS))
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        outcomes = [*pool.map(outcome, draws(count, SEED))]
    for name in (*SLIDING, *PRESLIDING):
        yield _held(f"{name}: {count} draws", [(o, name) for o in outcomes], judged=True)
    for noisy in (False, True):
        for axis in "xy":
            group = [o for o in outcomes if (o.noisy, o.axis) == (noisy, axis)]
            kind = f"{axis} {'with' if noisy else 'without'} noise"
            for label, names in (("sliding", SLIDING), ("presliding", PRESLIDING)):
                yield _held(f"  {label}, {kind}", [(o, n) for o in group for n in names])
            for name in (*SLIDING, *PRESLIDING):
                yield _held(f"    {name}, {kind}", [(o, name) for o in group], widths=True)


def _held(
    label: str, cases: list[tuple[Outcome, str]], *, judged: bool = False, widths: bool = False
) -> Row:
    held = sum(o.holds(name) for o, name in cases)
    share = held / len(cases) if cases else float("nan")
    measured = f"{share:.1%}"
    if widths and cases:
        half, true = (np.median([o.parameters[n][k] for o, n in cases]) for k in (1, 2))
        measured += f", +-{half / true:.1e}" if true else f", +-{half:.1e} N"
    return Row(
        label,
        f"{_LOW:.0%} to {_HIGH:.0%}" if judged else "",
        measured,
        f"{held} of {len(cases)}",
        "",
        _LOW <= share <= _HIGH if judged else None,
    )
