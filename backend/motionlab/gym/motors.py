"""Motors in episodes of their own: begun with cases and noise drawn for each, advanced together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.gym.step import MOTORS, OBSERVED, RING, TURNED, Observed, Weights, advance
from motionlab.kernel.build import initial_state, mover_parameters
from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.layout import parameter_row, reads_tables
from motionlab.lanes.bank import TABLES
from motionlab.simulation.batch import acting, changed, naming
from motionlab.simulation.inputs import PAGE, input_rows, page_inputs
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD, to_ticks

Array = NDArray[np.float64]
Changes = Mapping[str, Any]
Cases = Sequence[Changes] | Callable[[np.random.Generator], Changes]

SCALES = Observed(
    following_error=1e-5,
    following_error_rate=1e-3,
    position_reference=0.1,
    velocity_reference=0.1,
    acceleration_reference=1.0,
    position_measured=0.1,
    velocity_measured=0.1,
    force_realised=10.0,
)
"""What a scaled observation of 1 stands for, SI."""

WEIGHTS = {"error_scale": 1e-5, "effort": 0.01, "divergence": 0.0}
"""Of the reward: scale of the following error, m; of the squared action; once on divergence."""

RESIDUAL_SCALE = 5.0
"""Force of a residual action of 1, N: a little above the breakaway friction of shipped motors."""

_CONTROLLER_OFF = [
    parameter_row(path)
    for path in (
        "controller.k_p",
        "controller.k_d",
        "controller.feedforward",
        "controller.observer",
        "compensation.enabled",
    )
]


class _Motion:
    """Reference, load and noise of an episode, by page."""

    def __init__(self, prepared: Prepared) -> None:
        self._scenario = prepared.scenario
        self._timeline = Timeline(prepared.reference, prepared.load)
        self._pages: dict[int, Array] | None = None if _noisy(prepared.scenario) else {}

    def page(self, page: int, seed: int) -> Array:
        """Return one page of inputs; as `page_inputs`, with another seed of the noise."""
        if self._pages is None:
            scenario = self._scenario.model_copy(update={"seed": seed})
            return page_inputs(scenario, self._timeline, page)
        if page not in self._pages:
            self._pages[page] = page_inputs(self._scenario, self._timeline, page)
        return self._pages[page]


@dataclass(frozen=True)
class _Case:
    """A motor and its motion, ready to begin.

    Attributes
    ----------
    lanes : ndarray, shape (PARAMETER_ROWS, 2)
        Of x and y; the tables that it refers to stay in place as long as this array.
    state : ndarray, shape (STATE_ROWS, 2)
        At rest where the trajectory begins.
    motion : _Motion
        Inputs.
    ticks : int
        Length of the trajectory.
    """

    lanes: Array
    state: Array
    motion: _Motion
    ticks: int


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of an environment.

    Attributes
    ----------
    scenario : str, Path or mapping
        As `motionlab.config.load.load_scenario` takes it.
    set : mapping, optional
        Changes of it, dotted path to value.
    variant : str, optional
        Letter of the controller; the last one when left out.
    action : {"residual", "force"}
        Whether actions are added to the controller's force or replace it.
    action_scale : float, optional
        Force of an action of 1, N; left out: 5 N for residuals, else the force limit.
    scaled : bool
        Whether observations are divided by `SCALES`; else SI.
    reward : mapping, optional
        Differences from `WEIGHTS`.
    ticks : int
        Control periods of a step, over which its action is held.
    duration : float, optional
        Where episodes are cut off, s; at the trajectory's end when left out.
    cases : sequence of mapping, or callable, optional
        Further changes, one of which is drawn for each episode; or what returns those of an
        episode, given the generator of its environment.
    """

    scenario: str | Path | Changes = "circle"
    set: Changes | None = None
    variant: str | None = None
    action: Literal["residual", "force"] = "residual"
    action_scale: float | None = None
    scaled: bool = True
    reward: Mapping[str, float] | None = None
    ticks: int = 1
    duration: float | None = None
    cases: Cases | None = None


class Motors:
    """Motors of one scenario under actions, each in an episode of its own.

    Attributes
    ----------
    observation, reward, over : ndarray
        Of the last step, as `motionlab.gym.step.advance` writes them.

    Raises
    ------
    ConfigError
        Naming the option that cannot be used, and the case that it is in.
    """

    def __init__(self, count: int, options: Options) -> None:
        base = load_scenario(options.scenario, options.set)
        self._document = base.model_dump(mode="json")
        variant = options.variant or list(base.variants)[-1]
        self._variant = _one_of("variant", variant, base.variants)
        self._replaces = _one_of("action", options.action, ("residual", "force")) == "force"
        self._ticks = whole("ticks", options.ticks, f">= 1, of {CONTROL_PERIOD:g} s each")
        self._most = _episode(options.duration)
        self._motions: WeakValueDictionary[object, _Motion] = WeakValueDictionary()
        plain = self._make({}, "scenario")
        self._tabled = any(reads_tables(plain.lanes))
        self._draw = options.cases if callable(options.cases) else None
        self._cases = [plain]
        if options.cases is not None and not callable(options.cases):
            self._cases = [self._make(each, f"cases.{k}") for k, each in enumerate(options.cases)]
            if not self._cases:
                raise ConfigError(FieldError("cases", "needs at least one", 0, ">= 1"))

        force_limit = base.variants[variant].controller.force_limit
        self._weights = _weights(options, force_limit if self._replaces else RESIDUAL_SCALE)
        scale = np.array(SCALES) if options.scaled else np.ones(OBSERVED)
        most = np.array([_largest(base, axis, force_limit) for axis in AXES]).T
        self._scales = np.stack([np.tile(1.0 / scale, (2, 1)).T, most / scale[:, None]])

        blocks = -(-count // MOTORS)
        self._parameters = np.tile(plain.lanes, (blocks, 1, MOTORS))
        self._state = initial_state(blocks, (0.0, 0.0))
        self._inputs = np.zeros((count, RING, input_rows(), 2))
        self._clock = np.zeros(count, dtype=np.int64)
        self._end = np.zeros(count, dtype=np.int64)
        self._seeds = np.zeros(count, dtype=np.int64)
        self._running = [plain] * count
        self.observation = np.zeros((count, 2 * OBSERVED), dtype=np.float32)
        self.reward = np.zeros(count)
        self.over = np.zeros((count, 2), dtype=np.bool_)

    @property
    def largest(self) -> NDArray[np.float32]:
        """Largest magnitude of each number of an observation, shape (2 * OBSERVED,)."""
        return self._scales[1].T.ravel().astype(np.float32)

    def begin(
        self, number: int, random: np.random.Generator, options: Mapping[str, Any] | None = None
    ) -> dict[str, Any]:
        """Begin an episode of one motor, and return what was drawn for it.

        Parameters
        ----------
        number : int
            Which motor.
        random : Generator
            Where case and seed come from: two draws.
        options : mapping, optional
            ``case``, the index of a case, and ``seed``, that of the noise, in place of what is
            drawn.
        """
        options = options or {}
        if self._draw is None:
            index = int(random.integers(len(self._cases)))
            index = _below("options.case", options.get("case", index), len(self._cases))
            case, drawn = self._cases[index], {"case": index}
        else:
            case, drawn = self._make(self._draw(random), "cases"), {}
        seed = int(random.integers(2**32))
        seed = _below("options.seed", options.get("seed", seed), 2**53)

        block, place = divmod(number, MOTORS)
        lanes = slice(2 * place, 2 * place + 2)
        self._parameters[block, :, lanes] = case.lanes
        self._laws = laws_of(self._parameters)
        self._state[block, :, lanes] = case.state
        self._clock[number], self._end[number] = 0, self._length(case)
        self._seeds[number], self._running[number] = seed, case
        for page in (0, 1):
            self._load(number, page)
        self._observe(number)
        return drawn | {"seed": seed}

    def advance(self, actions: NDArray[np.float32]) -> int:
        """Advance every motor by one step; see `motionlab.gym.step.advance`."""
        events = advance(
            self._parameters,
            self._state,
            self._inputs,
            self._clock,
            self._end,
            actions,
            self._ticks,
            self._scales,
            self._weights,
            self.observation,
            self.reward,
            self.over,
            TABLES.values if self._tabled else None,
            self._laws,
        )
        if events & TURNED:
            page = self._clock // PAGE
            for number in np.flatnonzero(page != (self._clock - self._ticks) // PAGE).tolist():
                self._load(number, int(page[number]) + 1)
        return events

    def _observe(self, number: int) -> None:
        """Overwrite the observation of one motor, which stays as it is."""
        block, place = divmod(number, MOTORS)
        own = slice(2 * place, 2 * place + 2)
        parameters, state = self._parameters[[block]], self._state[[block]]
        parameters[0, :, :2] = parameters[0, :, own].copy()
        state[0, :, :2] = state[0, :, own].copy()
        here = slice(number, number + 1)
        advance(
            parameters,
            state,
            self._inputs[here],
            self._clock[here],
            self._end[here],
            np.zeros((1, 2), dtype=np.float32),
            0,
            self._scales,
            self._weights,
            self.observation[here],
            np.zeros(1),
            np.zeros((1, 2), dtype=np.bool_),
            TABLES.values if self._tabled else None,
            self._laws,
        )

    def _load(self, number: int, page: int) -> None:
        """Place a page of inputs in a motor's ring; the last tick is held for one tick more."""
        case, ring = self._running[number], self._inputs[number]
        begin, needed = page * PAGE, int(self._end[number]) + 1
        if begin >= needed:
            return
        at = begin % RING
        if begin == case.ticks:
            ring[at] = ring[at - 1]
            return
        rows = case.motion.page(page, int(self._seeds[number]))[: needed - begin]
        ring[at : at + len(rows)] = rows
        if len(rows) < min(PAGE, needed - begin):
            ring[at + len(rows)] = rows[-1]

    def _length(self, case: _Case) -> int:
        return case.ticks if self._most is None else min(self._most, case.ticks)

    def _make(self, changes: Changes, where: str) -> _Case:
        """Prepare the scenario with some changes."""
        with naming(where, changes):
            prepared = prepare(changed(self._document, changes, {}))
            scenario = prepared.scenario
            if scenario.schedule:
                message = "an episode's motor keeps its parameters"
                raise ConfigError(FieldError("schedule", message, len(scenario.schedule), "none"))
            with TABLES.lease() as lease:
                controller = scenario.variants[self._variant].controller
                lanes = np.array(mover_parameters(scenario, controller)).T.copy()
            lease.keep_with(lanes)
            if where != "scenario" and any(reads_tables(lanes)) != self._tabled:
                message = "all or none of them read tables of force maps or sharing functions"
                raise ConfigError(FieldError("cases", message))
            if self._replaces:
                lanes[_CONTROLLER_OFF] = 0.0
            key = (scenario.trajectory, acting(scenario))
            motion = self._motions.get(key) or _Motion(prepared)
            self._motions[key] = motion
            x, y = prepared.reference.position[0]
            state = initial_state(1, (float(x), float(y)), width=2)[0]
            case = _Case(lanes, state, motion, prepared.reference.ticks)
            longest = min(PAGE, self._length(case))
            if not 1 <= self._ticks <= longest:
                allowed = f"1 to {longest}, of {CONTROL_PERIOD:g} s each"
                message = "is no length of a step"
                raise ConfigError(FieldError("ticks", message, self._ticks, allowed))
            return case


def whole(loc: str, value: Any, allowed: str) -> int:
    """Return a count, which has no fraction.

    Raises
    ------
    ConfigError
        If it is no whole number.
    """
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not float(value).is_integer():
        raise ConfigError(FieldError(loc, "is no whole number", value, allowed))
    return int(value)


def _episode(duration: float | None) -> int | None:
    """Return the longest episode in control periods."""
    if duration is None:
        return None
    if not CONTROL_PERIOD <= duration < np.inf:
        message = "is no length of an episode"
        raise ConfigError(FieldError("duration", message, duration, f">= {CONTROL_PERIOD:g}", "s"))
    return to_ticks(duration)


def _weights(options: Options, action_scale: float) -> Array:
    """Return the fields of `Weights`."""
    weights = WEIGHTS | dict(options.reward or {})
    for name in weights:
        _one_of("reward", name, WEIGHTS)
    if options.action_scale is not None:
        action_scale = options.action_scale
    error_scale = weights["error_scale"]
    for loc, value, unit in (
        ("action_scale", action_scale, "N"),
        ("reward.error_scale", error_scale, "m"),
    ):
        if not 0.0 < value < np.inf:
            raise ConfigError(FieldError(loc, "is no scale", value, "> 0", unit))
    return np.array(
        Weights(action_scale, 1.0 / error_scale, weights["effort"], weights["divergence"])
    )


def _noisy(scenario: Scenario) -> bool:
    return acting(scenario)[-1] is not None


def _largest(scenario: Scenario, axis: str, force_limit: float) -> Observed:
    """Return the bounds of an axis' observations, SI."""
    plant = getattr(scenario.plant, axis)
    position, velocity = 2.0 * plant.stroke, 2.0 * plant.velocity_max
    return Observed(
        following_error=scenario.divergence_error,
        following_error_rate=2.0 * velocity,
        position_reference=position,
        velocity_reference=velocity,
        acceleration_reference=2.0 * plant.acceleration_max,
        position_measured=position,
        velocity_measured=velocity,
        force_realised=force_limit,
    )


def _one_of(loc: str, value: str, allowed: Any) -> str:
    if value not in allowed:
        raise ConfigError(FieldError(loc, "is not known", value, f"one of {', '.join(allowed)}"))
    return value


def _below(loc: str, value: int, end: int) -> int:
    allowed = f"0 to {end - 1}"
    if not 0 <= (number := whole(loc, value, allowed)) < end:
        raise ConfigError(FieldError(loc, "is out of range", value, allowed))
    return number
