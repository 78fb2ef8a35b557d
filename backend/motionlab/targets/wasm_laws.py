"""The laws of friction compensation in the WebAssembly module: all of them, one chosen by a run."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.law_calls import SHIPPED_BY_NUMBER, SHIPPED_CARRIED
from motionlab.kernel.layout import (
    LAW_NUMBER,
    LAW_OF_STATE,
    LAW_STATE,
    LawParameters,
    LawState,
)
from motionlab.lanes import Lanes, compiled, select
from motionlab.laws.law import Estimate, Seen

Array = NDArray[np.float64]
Choice = Callable[[int, LawParameters, LawState, Seen], tuple[Estimate, LawState]]


@compiled
def _lanes(value: Lanes, known: Seen) -> Lanes:
    """Return a number in every lane, as a law may give one for all."""
    return select(known.age >= 0.0, value, value)


def quotients() -> list[list[str]]:
    """Return of each law, by number, the parameters above 0 with which it has no linearisation."""
    names = []
    for law in SHIPPED_BY_NUMBER:
        zero = dict.fromkeys(law.Parameters._fields, 0.0)
        rows = [
            f"law.p_{row}"
            for row, name in enumerate(zero)
            if law.quotient({**zero, name: 1.0}) is not None
        ]
        names.append(["compensation.enabled"] if law.quotient(zero) is not None else rows)
    return names


def _choice() -> Choice:
    """Return the function that calls a law by its number in the kernel.

    Its text has a branch for each law, with the law's own records: compiled code cannot choose
    between functions.
    """
    scope: dict[str, Any] = {"Estimate": Estimate, "LawState": LawState, "lanes": _lanes}
    lines = ["def estimate_friction(number, par, state, known):"]
    for number, law in enumerate(SHIPPED_BY_NUMBER):
        parameters = "".join(f"par[{k}]," for k in range(len(law.Parameters._fields)))
        rows = len(law.State._fields)
        own = "".join(f"state[{k}]," for k in range(rows))
        after = (f"lanes(after[{k}], known)" for k in range(rows))
        rest = (f"state[{k}]" for k in range(rows, len(LawState._fields)))
        scope |= {
            f"step_{number}": law.step,
            f"Parameters_{number}": law.Parameters,
            f"State_{number}": law.State,
        }
        last = number == len(SHIPPED_BY_NUMBER) - 1
        lines += [
            "    if True:" if last else f"    if number == {number}:",
            f"        own, before = Parameters_{number}({parameters}), State_{number}({own})",
            f"        estimate, after = step_{number}(own, before, known)",
            "        force, z, K = estimate",
            "        force, z, K = lanes(force, known), lanes(z, known), lanes(K, known)",
            f"        return Estimate(force, z, K), LawState({', '.join((*after, *rest))})",
        ]
    exec("\n".join(lines), scope)
    return scope["estimate_friction"]


estimate_friction: Choice = compiled(_choice())
"""Return the friction estimate by the law of a number, and the law's next state."""


def _carrying() -> Callable[[int, int, Array, int], None]:
    """Return the function that carries the state of one law over to another.

    As text with a branch for each way to do it: the module has no memory for a table.
    """
    same = list(range(len(LawState._fields)))
    ways: dict[tuple[int, ...], list[str]] = {}
    for before, after in itertools.permutations(range(len(SHIPPED_BY_NUMBER)), 2):
        if (sources := SHIPPED_CARRIED[before, after].tolist()) != same:
            pair = f"(before == {before} and after == {after})"
            ways.setdefault(tuple(sources), []).append(pair)
    lines = ["def carry_over(before, after, state, place):"]
    for sources, pairs in ways.items():
        old = (f"state[{LAW_STATE + row}, place]" if row >= 0 else "0.0" for row in sources)
        lines.append(f"    if {' or '.join(pairs)}:")
        lines.append(f"        {', '.join(f'v_{row}' for row in same)} = {', '.join(old)}")
        lines += [f"        state[{LAW_STATE + row}, place] = v_{row}" for row in same]
    scope: dict[str, Any] = {}
    exec("\n".join([*lines, "    return"]), scope)
    return scope["carry_over"]


_carry_over = compiled(_carrying())


@compiled
def adopt_states(parameters: Array, state: Array) -> None:
    """Give lanes whose law has changed a state of their new one, as `law_calls.adopt_states`."""
    for place in range(state.shape[1]):
        before, after = int(state[LAW_OF_STATE, place]), int(parameters[LAW_NUMBER, place])
        if before != after:
            _carry_over(before, after, state, place)
            state[LAW_OF_STATE, place] = after
