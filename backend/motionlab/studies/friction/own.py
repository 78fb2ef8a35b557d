"""An effect of friction, such as one of one's own, as a friction model that a record is tried with.

Its force follows from its step along the recorded motion; nothing of it is linear, so every
parameter is a shape number. With a lower bound above zero the shape number x is the parameter p
itself, elsewhere ``p = c (x - 1/x)/2``, so that p may pass zero where a search steps in log(x).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from motionlab.declarations import Parameter
from motionlab.effects import EFFECTS, PROBLEMS, SOURCES
from motionlab.effects.effect import STATE_ROWS, Effect, MidStep
from motionlab.errors import ConfigError, FieldError
from motionlab.lanes import WIDTH, Lanes, cached, pack, unpack
from motionlab.plant.friction import LuGre
from motionlab.studies.friction.candidates import CANDIDATES, Candidate, Path, Shape
from motionlab.studies.friction.documents import comparable
from motionlab.studies.friction.units import Machine
from motionlab.targets.record_law import lane_error
from motionlab.timing import PLANT_STEP

Array = NDArray[np.float64]

_STARTS = 63
"""Points at which a search may begin, besides that of the defaults."""
_APART = 30.0
"""Factor about a default between which these lie, where a parameter has no usual range."""
_LEAST = 1e-6
"""Of a default: what stands for a bound of zero that a parameter may not reach."""
_SMALL = 0.1
"""Of a default: the scale c of a parameter that may be zero."""
_SUBSTEPS = 20
_COMMON = frozenset({"M", "f_0", "lag"})
_UNKNOWN = ("current_a", "current_b", "current_c", "thrust", "M")
"""What an effect may know of a step, and a record of another machine does not have."""


@dataclass(frozen=True)
class _Number:
    """A parameter that is fitted: p as a function of its shape number x, and back."""

    parameter: Parameter
    start: float

    @property
    def scale(self) -> float | None:
        """Return c; None where x is p."""
        each = self.parameter
        low = each.ge if each.ge is not None else each.gt
        if low is None or low < 0.0 or (low == 0.0 and each.gt is None):
            size = self.start if self.start != 0.0 else max(map(abs, self._usual))
            return _SMALL * abs(size)
        return None

    @property
    def _usual(self) -> tuple[float, float]:
        each = self.parameter
        if each.usual is not None:
            return each.usual
        low, high = _bounds(each)
        if self.start == 0.0:
            return max(low, -0.1 * abs(high)), 0.1 * high
        ends = sorted((self.start / _APART, self.start * _APART))
        return max(low, ends[0]), min(high, ends[1])

    def of(self, x: Any) -> Any:
        """Return p."""
        return x if self.scale is None else 0.5 * self.scale * (x - 1.0 / x)

    def back(self, p: float) -> float:
        """Return x."""
        return p if self.scale is None else math.exp(math.asinh(p / self.scale))

    def shape(self, name: str) -> Shape:
        """Return the range and the start."""
        low, high = _bounds(self.parameter)
        if self.scale is None:
            low = max(low, _LEAST * abs(self.start))
        ends = self.back(low), self.back(high)
        return Shape(name, ends[0], ends[1], (self.back(self.start),))

    def between(self, shares: Array) -> Array:
        """Return numbers x within the usual range, at shares of it in log(x)."""
        low, high = self._usual
        if self.scale is None:
            low = max(low, _LEAST * abs(self.start))
        ends = np.log([self.back(low), self.back(high)])
        return np.exp(ends[0] + shares * (ends[1] - ends[0]))


def _bounds(each: Parameter) -> tuple[float, float]:
    low = each.ge if each.ge is not None else each.gt
    high = each.le if each.le is not None else each.lt
    assert low is not None and high is not None  # as declarations are checked
    return low, high


def candidates_of(
    names: list[str], friction: LuGre, machine: Machine, taken: str = "effects"
) -> tuple[Candidate, ...]:
    """Return effects of friction as candidates.

    Parameters
    ----------
    names : list of str
        Of effects.
    friction : LuGre
        Plain numbers: where parameters begin that an effect takes of the guide.
    machine : Machine
        Units of the record.
    taken : str
        Field of the request.

    Raises
    ------
    ConfigError
        If there is no such effect, it is no friction, cannot be run, needs what the record does not
        have, or the record is not in m and N.
    """
    errors = [
        FieldError(f"{taken}.{k}", *wrong)
        for k, name in enumerate(names)
        if (wrong := next(_wrong(names[:k], name, friction, machine), None))
    ]
    if errors:
        unknown = any(name not in EFFECTS for name in names)
        raise ConfigError(*errors, *(PROBLEMS if unknown else ()))
    return tuple(_candidate(EFFECTS[name], friction) for name in names)


def _wrong(
    before: list[str], name: str, friction: LuGre, machine: Machine
) -> Iterator[tuple[Any, ...]]:
    """Yield why an effect cannot be compared: message, value and what is allowed instead.

    Each holds only where there is none before it.
    """
    allowed = "one of " + ", ".join(each.name for each in comparable())
    if name not in EFFECTS:
        yield "is no effect", name, allowed
    if name in {each.name for each in CANDIDATES}:
        yield "has the name of a model that is compared anyway", name
    if name in before:
        yield "is named twice", name
    effect = EFFECTS[name]
    if not effect.friction:
        yield "is no friction", name, allowed
    if reason := lane_error(effect):
        yield f"is not made of lanes: {reason}", name
    if (machine.length, machine.force) != ("m", "N"):
        units = f"{machine.length} and {machine.force}"
        yield f"has parameters of m and N, the record is in {units}", name
    numbers, par = _numbers(effect, friction)
    if not numbers:
        yield "has no parameter that could be fitted", name
    if reason := effect.refuse(par):
        yield f"cannot begin at its defaults: {reason}", name
    if needed := _needed(effect, par):
        yield f"depends on {needed}, which is not known of a record", name


def _values(effect: Effect, friction: LuGre) -> dict[str, Any]:
    """Return defaults, those of the guide in place of what is left out."""
    return {
        each.name: getattr(friction, each.name, None) if each.default is None else each.default
        for each in effect.parameters
    }


def _numbers(effect: Effect, friction: LuGre) -> tuple[list[_Number], Any]:
    """Return what is fitted, and `Parameters` at the defaults."""
    values = _values(effect, friction)
    numbers = [
        _Number(each, float(values[each.name]))
        for each in effect.parameters
        if not each.choices and values[each.name] is not None
    ]
    return numbers, effect.lane_parameters(values, friction)


def _needed(effect: Effect, par: Any) -> str:
    """Return what an effect depends on and a record does not have; empty if nothing."""
    numbers = type(par)(*map(np.float64, par))
    state = effect.State(*np.zeros(len(effect.State._fields)))
    known = {name: np.float64(1e-3) for name in MidStep._fields}
    with np.errstate(all="ignore"):
        for name in _UNKNOWN:
            seen = MidStep(**known | {name: np.float64(np.nan)})
            if np.isnan(effect.step(numbers, state, seen)[0].force):
                return name
    return ""


def _candidate(effect: Effect, friction: LuGre) -> Candidate:
    numbers, _ = _numbers(effect, friction)
    names = [each.parameter.name for each in numbers]
    keys = [f"{effect.name}.{name}" if name in _COMMON else name for name in names]
    inside = [f"{effect.name}: {name}" for name in names]
    values = _values(effect, friction)

    def lane(shape: Array) -> Any:
        of = {n: each.of(x) for n, each, x in zip(names, numbers, shape.tolist(), strict=True)}
        return effect.lane_parameters(values | of, friction)

    def parameters(n: dict[str, float]) -> dict[str, float]:
        plain = zip(keys, inside, numbers, strict=True)
        return {key: each.of(n[name]) for key, name, each in plain}

    shares = qmc.Halton(len(numbers), scramble=False).random(_STARTS + 1)[1:]
    columns = [each.between(share) for each, share in zip(numbers, shares.T, strict=True)]
    shapes = tuple(each.shape(name) for each, name in zip(numbers, inside, strict=True))
    defaults = np.array([[shape.starts[0] for shape in shapes]])
    return Candidate(
        name=effect.name,
        label=effect.label,
        order=len(numbers),
        shapes=shapes,
        forces=partial(_forces, _follower(effect), lane),
        linear=("force",),
        parameters=parameters,
        whole=True,
        starts=np.concatenate([defaults, np.stack(columns, axis=1)]),
        refused=lambda shape: effect.refuse(lane(shape)) is not None,
        units={key: each.parameter.unit for key, each in zip(keys, numbers, strict=True)},
        may_be_zero=frozenset(
            key for key, each in zip(keys, numbers, strict=True) if each.scale is not None
        ),
    )


class _Force(NamedTuple):
    force: Lanes


Follower = Callable[[Array, Array, float, int, Array], None]


def _forces(
    follow: Follower, lane: Callable[[Array], Any], path: Path, shapes: Array
) -> Iterator[Sequence[Array]]:
    """Yield the force of each set of parameters at the samples."""
    n = len(path.position)
    seen = np.zeros((n, 3))
    seen[:, 0] = path.position
    if path.normal is not None:
        seen[:, 1] = np.nan_to_num(path.normal)
    seen[:, 2] = path.lost
    steps = min(math.ceil(path.period / PLANT_STEP - 1e-6), _SUBSTEPS)
    for first in range(0, len(shapes), WIDTH):
        some = shapes[first : first + WIDTH]
        par = np.array([lane(shape) for shape in some], dtype=np.float64)
        par = np.concatenate([par, np.repeat(par[-1:], WIDTH - len(some), 0)]).T.copy()
        within = np.zeros((n, 1, WIDTH))
        follow(par, seen, path.period, steps, within)
        at = within[:, 0, : len(some)].T
        at[:, 1:] = 0.5 * (at[:, 1:] + at[:, :-1])  # at the samples
        for force in at:
            yield (force,)


def _follower(effect: Effect) -> Follower:
    """Return the compiled function that steps an effect along a motion.

    It writes the mean force of eight sets of parameters from each sample to the next, (n, 1, 8). A
    step of the effect is as long as in the plant, or a twentieth of a sample; at gaps and rests its
    state stays.
    """
    step, par_record, state_record = effect.step, effect.Parameters, effect.State
    count = len(state_record._fields)

    def follow(parameters: Array, seen: Array, period: float, steps: int, force: Array) -> None:
        par = unpack(par_record, parameters, 0)
        rows = np.zeros((STATE_ROWS, WIDTH))
        zero = 0.0 * unpack(_Force, rows, 0).force
        h = period / steps
        for k in range(len(seen) - 1):
            v = (seen[k + 1, 0] - seen[k, 0]) / period
            total = zero
            for i in range(steps):
                share = (i + 0.5) / steps
                p = seen[k, 0] + share * period * v
                N = seen[k, 1] + share * (seen[k + 1, 1] - seen[k, 1])
                time = (k + share) * period
                at = MidStep(
                    zero + p,
                    zero + v,
                    zero + time,
                    zero,
                    zero,
                    zero,
                    zero + N,
                    zero,
                    zero,
                    zero + h,
                )
                resistance, after = step(par, unpack(state_record, rows, 0), at)
                total = total + resistance.force
                if count > 0 and seen[k, 2] == 0.0:
                    pack(after, rows[:count])
            pack(_Force(total / steps), force[k])

    if source := SOURCES.get(effect.name):  # compiled code is kept under this name
        follow.__qualname__ += f"-{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    return cached(follow)
