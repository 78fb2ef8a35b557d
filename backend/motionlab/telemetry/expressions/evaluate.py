"""Compiled expressions evaluated on samples, block by block.

Every operation with memory carries its state from block to block: how a record is cut into blocks
changes no bit of the result. What is not finite is a gap, NaN; at the first sample, and after every
gap, operations with memory begin anew.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached
from motionlab.telemetry.expressions.compile import Program, Step

BLOCK = 1 << 16
"""Samples that are evaluated at a time."""

Values = NDArray[np.float64]

_UNARY: dict[str, Callable[[Values], Values]] = {
    "negate": np.negative,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sign": np.sign,
    "sin": np.sin,
    "cos": np.cos,
}
_BINARY: dict[str, Callable[[Values, Values], Values]] = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "hypot": np.hypot,
}


class Evaluation:
    """A program on its way through a record, from the first sample on."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._memories = {
            place: _memory(step) for place, step in enumerate(program.steps) if _remembers(step)
        }

    def __call__(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the values at the next samples.

        Parameters
        ----------
        samples : ndarray of float32, shape (channels, n)
            The channels of the program in their order; they follow those of the last call.

        Returns
        -------
        ndarray of float32, shape (n,)
            NaN where there is no value.
        """
        values = np.empty(samples.shape[1], dtype=np.float32)
        for start in range(0, len(values), BLOCK):
            part = slice(start, start + BLOCK)
            values[part] = self._block(samples[:, part])
        return values

    def _block(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        stack: list[Values] = []
        with np.errstate(all="ignore"):
            for place, step in enumerate(self._program.steps):
                if step.op == "channel":
                    value = samples[int(step.values[0])].astype(np.float64)
                elif step.op == "number":
                    stack.append(np.full(samples.shape[1], step.values[0]))
                    continue
                elif step.op in _UNARY:
                    value = _UNARY[step.op](stack.pop())
                elif step.op in _BINARY:
                    second = stack.pop()
                    value = _BINARY[step.op](stack.pop(), second)
                elif step.op == "power":
                    value = _power(stack.pop(), int(step.values[0]))
                else:
                    value = self._memories[place](stack.pop())
                value[~np.isfinite(value)] = np.nan
                stack.append(value)
            (value,) = stack
            result = value.astype(np.float32)
            result[~np.isfinite(result)] = np.nan
        return result


def evaluate(program: Program, samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the values of a whole record.

    Parameters
    ----------
    program : Program
        From `compile_expression`.
    samples : ndarray of float32, shape (channels, n)
        Its channels, in their order.

    Returns
    -------
    ndarray of float32, shape (n,)
        NaN where there is no value.
    """
    return Evaluation(program)(samples)


def warm_up() -> None:
    """Compile the operations with memory, or load them."""
    steps = (Step("channel", (0,)), Step("filter", (0.0, 1.0, 0.0, 1.0)), Step("mean", (2,)))
    evaluate(Program(("u",), "1", steps), np.zeros((1, 2), np.float32))


def reach(program: Program) -> int | None:
    """Return how many earlier samples a value depends on; None for all of them."""
    total = 0
    for step in program.steps:
        if step.op in {"filter", "mean"}:
            return None
        total += int(step.values[0]) if step.op == "delay" else step.op == "difference"
    return total


def _remembers(step: Step) -> bool:
    return step.op in {"filter", "mean", "delay", "difference"}


def _memory(step: Step) -> Callable[[Values], Values]:
    match step.op:
        case "filter":
            state = np.full(2, np.nan)
            coefficients = np.array(step.values)
            return lambda u: _filter(u, coefficients, state)
        case "mean":
            count = int(step.values[0])
            ring, sums = np.zeros(count), np.zeros(3)
            return lambda u: _mean(u, ring, sums)
        case "delay":
            return _Delay(int(step.values[0]))
        case _:
            last, gain = _Delay(1), step.values[0]
            return lambda u: gain * (u - last(u))


class _Delay:
    """The values so many samples ago."""

    def __init__(self, count: int) -> None:
        self._held = np.full(count, np.nan)

    def __call__(self, u: Values) -> Values:
        both = np.concatenate((self._held, u))
        self._held = both[len(u) :]
        return both[: len(u)].copy()


def _power(u: Values, exponent: int) -> Values:
    """Return a whole power by multiplication, as the page does."""
    result = np.ones_like(u)
    for _ in range(abs(exponent)):
        result = result * u
    return 1.0 / result if exponent < 0 else result


@cached
def _filter(u: Values, coefficients: Values, state: Values) -> Values:
    """Return y_k = a y_(k-1) + b0 u_k + b1 u_(k-1), and y = g u at the first sample after a gap."""
    a, b0, b1, g = coefficients
    y, last = state
    result = np.empty_like(u)
    for k in range(len(u)):
        value = u[k]
        y = g * value if np.isnan(y) or np.isnan(value) else a * y + b0 * value + b1 * last
        if not np.isfinite(y):
            y = np.nan
        last = value
        result[k] = y
    state[0], state[1] = y, last
    return result


@cached
def _mean(u: Values, ring: Values, sums: Values) -> Values:
    """Return the mean of the last samples, or of those since the last gap while they are fewer.

    The sum is taken anew each time that the ring is full, so that rounding does not pile up.
    """
    total, count, place = sums[0], int(sums[1]), int(sums[2])
    size = len(ring)
    result = np.empty_like(u)
    for k in range(len(u)):
        value = u[k]
        if np.isnan(value):
            total, count, place = 0.0, 0, 0
            result[k] = np.nan
            continue
        if count == size:
            total -= ring[place]
        else:
            count += 1
        ring[place] = value
        total += value
        place += 1
        if place == size:
            place = 0
            total = 0.0
            for each in ring:
                total += each
        result[k] = total / count
    sums[0], sums[1], sums[2] = total, count, place
    return result
