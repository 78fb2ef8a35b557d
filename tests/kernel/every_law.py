"""Eight lanes that between them use every law, effect and switch, and a rough ride for them.

``python -m tests.kernel.every_law FILE`` writes their samples to FILE; with NUMBA_DISABLE_JIT=1
they come from the plain-Python kernel.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.control.filters import sampled_filter, sampled_notch
from motionlab.effects import EFFECTS, Effect
from motionlab.kernel.effect_calls import effect_numbers
from motionlab.kernel.layout import (
    EFFECT_PARAMETERS,
    Inputs,
    Parameters,
    parameter_row,
)
from motionlab.plant.friction import FRICTIONLESS, LuGre
from tests.kernel.every_sharing_law import table_lanes
from tests.kernel.lane_runs import Array, at_rest, circle, inputs, lane, rows, run
from tests.nominal_motor import X, Y

TICKS = 192

_IMPERFECT = {
    "force_map.formula.F_pk": 38.4,
    "force_map.formula.h_2": 0.03,
    "force_map.formula.h_3": 0.039,
    "force_map.formula.offset": 5e-5,
    "amplifiers.gain_b": 1.02,
    "amplifiers.offset_a": 0.1,
    "amplifiers.offset_c": -0.05,
    "encoder.sde_amplitude": 40e-9,
    "friction.F_s": 3.0,
    "resonance.compliance": -1e-7,
}
_NOTCH = sampled_notch(frequency=250.0, damping=0.35, gain=0.1)._asdict()
_LOW_PASS = sampled_filter(
    zeros_frequency=0.0, zeros_damping=0.7, poles_frequency=700.0, poles_damping=0.8
)._asdict()
_LEAD = sampled_filter(
    zeros_frequency=90.0, zeros_damping=0.9, poles_frequency=120.0, poles_damping=0.9
)._asdict()
_EVERYTHING = {
    "controller.feedforward": 1.0,
    "controller.observer": 1.0,
    "law.from_reference": 1.0,
} | {
    f"{name}.{key}": value
    for name, values in {"notch": _NOTCH, "filter_1": _LOW_PASS, "filter_3": _LEAD}.items()
    for key, value in values.items()
}
_FOUR = (
    ("residual-k", {"law.z_limit": 4e-5} | _EVERYTHING),
    ("canudas-de-wit", {"law.gain": 300.0, "controller.ideal_force": 1.0}),
    ("lugre-observer", _IMPERFECT | {"mechanics.stop": 0.0148, "mechanics.stop_stiffness": 1e5}),
    ("off", {"controller.delay": 1.0, "controller.observer": 1.0, "controller.k_d": 400.0}),
)
_PUBLISHED_K = {"law.z_limit": 3e-5}


def lanes(resolution: float) -> list[Parameters]:
    """Return eight different lanes with an encoder of `resolution`, m; 0 for an exact one."""
    exact = {"encoder.resolution": resolution}
    return [lane(axis, law, changes | exact) for law, changes in _FOUR for axis in (X, Y)]


def published_lanes() -> list[Parameters]:
    """Return eight lanes with K as published, which is chaotic, on the true scale of z."""
    return [lane(axis, "published-k", _PUBLISHED_K) for axis in (X, Y)] * 4


def reversed_lanes() -> list[Parameters]:
    """Return eight lanes with K reversed: plain, with k_d and a bound, delayed, imperfect."""
    four = (
        {},
        {"law.k_d_share": 1e-3, "law.z_limit": 3e-5},
        {"controller.delay": 1.0, "controller.observer": 1.0},
        _IMPERFECT,
    )
    return [lane(axis, "reversed-k", changes) for changes in four for axis in (X, Y)]


def with_effects(parameters: Array) -> Array:
    """Return rows of lanes with effects in place of the friction that they have."""
    names = [
        ("gms", "cogging"),
        ("static-stribeck",),
        ("lugre", "dahl"),
        ("cogging", "gms", "static-stribeck", "dahl"),
    ] * 2
    changed, first = parameters.copy(), parameter_row("friction.sigma_0")
    last = first + len(LuGre._fields)
    changed[first:last] = np.array(FRICTIONLESS)[:, None]
    for place, own in enumerate(names):
        friction = LuGre(*parameters[first:last, place])
        effects = [(name, _with_all(EFFECTS[name], friction)) for name in own]
        changed[-len(EFFECT_PARAMETERS) :, place] = effect_numbers(effects)
    return changed


def _with_all(effect: Effect, friction: LuGre) -> Any:
    """Return the parameters of an effect with what it depends on."""
    values = {each.name: each.default for each in effect.parameters}
    more = {"mu": 0.01, "position_amplitude": 0.2, "amplitude_3": 0.5}
    own = {name: value for name, value in more.items() if name in values}
    return effect.lane_parameters(values | own, friction)


def ride() -> tuple[Array, Array]:
    """Return initial state and inputs: a cold start into a moving circle, with noise and load."""
    begin = 4500 - TICKS // 2
    motion = circle(begin + TICKS)[begin:]  # x turns round halfway
    driven = inputs(motion)
    noise = np.random.Generator(np.random.Philox(7))
    for name, rms in {"load": 0.3, "encoder_noise": 5e-9, "current_b": 0.02}.items():
        driven[:, Inputs._fields.index(name)] += rms * noise.standard_normal((TICKS, 2))
    return at_rest(motion[0, 0]), driven


def played(parameters: Array) -> dict[str, NDArray[Any]]:
    """Return the recorded samples of a ride, and the state at its end."""
    state, driven = ride()
    with np.errstate(all="ignore"):  # plain Python computes both sides of every selection
        samples = run(parameters, state, driven)
    return {"samples": samples, "state": state}


def results() -> dict[str, NDArray[Any]]:
    """Return what the test compares, by name."""
    named: dict[str, NDArray[Any]] = {}
    cases = {
        "exact": rows(lanes(0.0)),
        "counts": rows(lanes(50e-9)),
        "published": rows(published_lanes()),
        "reversed": rows(reversed_lanes()),
        "tables": rows(table_lanes(0.0)),
        "effects": with_effects(rows(lanes(0.0))),
    }
    for name, case in cases.items():
        for key, value in played(case).items():
            named[f"{name}_{key}"] = value
    return named


if __name__ == "__main__":
    np.savez(sys.argv[1], allow_pickle=False, **results())
