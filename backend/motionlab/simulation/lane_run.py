"""A what-if as numbers, for the kernel that a browser runs."""

from __future__ import annotations

import functools
import hashlib
import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.metrics import holds_within
from motionlab.analysis.variant_comparison import RATIOS
from motionlab.config.load import Epochs
from motionlab.config.planar import AXES
from motionlab.errors import MotionLabError
from motionlab.kernel.build import LANES_PER_VARIANT, initial_state
from motionlab.kernel.force_maps import map_digests
from motionlab.kernel.layout import Inputs, reads_tables
from motionlab.kernel.own_tables import own_tables
from motionlab.lanes import model_hash, module_hash
from motionlab.lanes.bank import TABLES
from motionlab.laws import OWN
from motionlab.simulation.batch import acting, lanes_of
from motionlab.simulation.inputs import inputs_over
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import Window, effective, identity, segments, variant_identity
from motionlab.simulation.simulation import Snapshot, variant_lanes
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import REFERENCES
from motionlab.telemetry.packed import packed
from motionlab.timing import CONTROL_PERIOD, to_ticks

Array = NDArray[np.float64]

TICKS_MAX = to_ticks(60.0)
"""Longest run that is handed out, summed over variants: in a browser it takes about 50 MB."""

_REFERENCE_ROWS = ("p_ref", "v_ref", "a_ref", "load")
"""Rows of the inputs that hold REFERENCES; of a noisy load, its row is `_LOAD`."""
_LOAD = "load_force"


class Row(NamedTuple):
    """A row of inputs, one number a tick; rows that are left out are zero."""

    name: str  # field of Inputs, or `load_force`, which the load is without its noise
    axis: str


class Known(NamedTuple):
    """Keys of the inputs and tables that whoever asks has already."""

    inputs: str = ""
    tables: str = ""


class Obstacle(MotionLabError):
    """A run that only the server's kernel can carry out."""


@dataclass(frozen=True)
class LaneRun:
    """Numbers of a run, for another build of the kernel.

    Attributes
    ----------
    prepared : Prepared
        The scenario.
    first, stop : int
        Ticks [first, stop) of the run.
    epochs : tuple of int
        Ticks from which each set of lane parameters holds; the first set holds at `first`.
    lanes : ndarray, shape (epochs, variants, PARAMETER_ROWS, 2)
        Lane parameters of x and y.
    state : ndarray, shape (variants, STATE_ROWS, 2)
        At `first`.
    tabled : list of bool
        Of each variant, whether its lanes read tables.
    keys : Known
        Names of inputs and tables: what changes none of them keeps them.
    rows : list of Row
        Rows of `inputs`.
    inputs : ndarray, shape (rows, ticks), or None
        None where they are known.
    tables : ndarray, shape (n,), or None
        The tables that lanes read; None where they are known.
    """

    prepared: Prepared
    first: int
    stop: int
    epochs: tuple[int, ...]
    lanes: Array
    state: Array
    tabled: list[bool]
    keys: Known
    rows: list[Row]
    inputs: Array | None
    tables: Array | None

    def packed(self, **more: Any) -> bytes:
        """Return all of it in one piece, with `more` in its head: docs/rest.md."""
        arrays = self.arrays
        head = {
            **self._document(),
            "module": module_hash(),
            "how": "window" if self.first else "whole",
            "period": CONTROL_PERIOD,
            "ticks": self.prepared.reference.ticks,
            "first": self.first,
            "stop": self.stop,
            "epochs": self.epochs,
            "tabled": self.tabled,
            "keys": self.keys._asdict(),
            "rows": self.rows,
            "arrays": _places(arrays),
            **more,
        }
        return packed(head, list(arrays.values()), "<f8")

    @property
    def arrays(self) -> dict[str, Array]:
        """Its numbers, without those that are known."""
        named = {
            "lanes": self.lanes,
            "state": self.state,
            "inputs": self.inputs,
            "tables": self.tables,
        }
        return {name: array for name, array in named.items() if array is not None}

    def _document(self) -> dict[str, Any]:
        """Return what the result document of the run needs beside its samples, in types of JSON."""
        prepared = self.prepared
        inside = [each for each in segments(prepared) if self._holds(each)]
        windows = list(dict.fromkeys([prepared.window, *inside]))
        return {
            "result": identity(prepared),
            "moving": list(prepared.reference.moving),
            "windows": [_window(prepared, each) for each in windows],
            "segments": [windows.index(each) for each in inside],
            "ratios": RATIOS,
            "references": dict(
                zip((each.name for each in REFERENCES), _reference_rows(prepared), strict=True)
            ),
        }

    def _holds(self, window: Window) -> bool:
        return self.first <= window[0] and window[1] <= self.stop


def lane_run(prepared: Prepared, start: Snapshot | None, stop: int, known: Known) -> LaneRun:
    """Return the numbers of a run from a state, or from rest at tick 0, to tick `stop`.

    Raises
    ------
    Obstacle
        If it is too long, has effects or a law of one's own, or a variant reads tables on one of
        its axes only.
    """
    first = 0 if start is None else start.tick
    if (stop - first) * len(prepared.scenario.variants) > TICKS_MAX:
        longest = TICKS_MAX * CONTROL_PERIOD
        raise Obstacle(f"it takes more than {longest:g} s, summed over variants")
    in_effect = _in_effect(prepared.epochs, first, stop)
    _refuse_own(in_effect)
    with TABLES.lease():
        lanes = lanes_of(in_effect)
        own = own_tables(lanes)
        keys = Known(
            _digest(prepared.scenario.trajectory, _acting(prepared.epochs), first, stop),
            _digest(map_digests(in_effect), own.sizes),
        )
        tables = None if keys.tables == known.tables else own.numbers()
    rows, inputs = ([], None) if keys.inputs == known.inputs else _inputs(prepared, first, stop)
    return LaneRun(
        prepared,
        first,
        stop,
        tuple(tick for tick, _ in in_effect),
        own.lanes,
        _state(prepared, start),
        _tabled(lanes),
        keys,
        rows,
        inputs,
        tables,
    )


def _refuse_own(epochs: Epochs) -> None:
    for _, scenario in epochs:
        if any(getattr(scenario.plant, axis).effects for axis in AXES):
            raise Obstacle("the motor has effects, which the page does not have")
        for variant in scenario.variants.values():
            if (law := variant.controller.compensation.law) in OWN:
                raise Obstacle(f"the law {law} is of a file of one's own, which it does not have")


def _places(arrays: Mapping[str, Array]) -> dict[str, dict[str, Any]]:
    """Return of each array the index of its first number, and its shape."""
    ends = itertools.accumulate(array.size for array in arrays.values())
    return {
        name: {"first": end - array.size, "shape": array.shape}
        for (name, array), end in zip(arrays.items(), ends, strict=True)
    }


def _in_effect(epochs: Epochs, first: int, stop: int) -> Epochs:
    """Return the parameter sets that hold within [first, stop)."""
    now = max(index for index, (tick, _) in enumerate(epochs) if tick <= first)
    return tuple(each for each in epochs[now:] if each[0] < stop)


def _state(prepared: Prepared, start: Snapshot | None) -> Array:
    """Return the state of each variant, shape (variants, STATE_ROWS, 2)."""
    variants = range(len(prepared.scenario.variants))
    if start is not None:
        return np.stack([variant_lanes(start.state, each) for each in variants])
    x, y = prepared.reference.position[0]
    rest = initial_state(1, (float(x), float(y)), width=LANES_PER_VARIANT)
    return np.concatenate([rest for _ in variants])


def _tabled(lanes: Array) -> list[bool]:
    """Return of each variant whether its lanes read tables."""
    flags = [
        [any(axis) for axis in zip(*(reads_tables(each) for each in epochs), strict=True)]
        for epochs in lanes.transpose(1, 0, 2, 3)
    ]
    if any(any(axes) != all(axes) for axes in flags):
        raise Obstacle("one axis has a force map or a sharing function that is a table")
    return [all(axes) for axes in flags]


def _inputs(prepared: Prepared, first: int, stop: int) -> tuple[list[Row], Array]:
    """Return the rows that are not zero throughout, and their numbers, shape (rows, ticks)."""
    timeline = Timeline(prepared.reference, prepared.load)
    inputs = inputs_over(prepared.epochs, timeline, first, stop).transpose(1, 2, 0)
    numbers = {
        Row(name, axis): inputs[row, lane]
        for row, name in enumerate(Inputs._fields)
        for lane, axis in enumerate(AXES)
    }
    if _reference_rows(prepared)[-1] == _LOAD:
        load = prepared.load[first:stop].T
        numbers |= {Row(_LOAD, axis): load[lane] for lane, axis in enumerate(AXES)}
    used = {row: each for row, each in numbers.items() if each.any()}
    return list(used), np.array(list(used.values())).reshape(len(used), stop - first)


def _reference_rows(prepared: Prepared) -> tuple[str, ...]:
    noisy = any(scenario.load.noise > 0.0 for _, scenario in prepared.epochs)
    return (*_REFERENCE_ROWS[:-1], _LOAD) if noisy else _REFERENCE_ROWS


def _acting(epochs: Epochs) -> tuple[Any, ...]:
    return tuple((tick, acting(scenario)) for tick, scenario in epochs)


def _hexadecimal(*values: object) -> str:
    return hashlib.sha256(repr((model_hash(), values)).encode()).hexdigest()[:32]


_digest = cast("Callable[..., str]", functools.lru_cache(maxsize=16)(_hexadecimal))
"""Name some values, the same in every process."""


def _window(prepared: Prepared, window: Window) -> dict[str, Any]:
    """Return what the metrics of a window need beside the samples.

    Notes leave out warnings: those that need no run take twice as long as all else here.
    """
    scenario, reference = effective(prepared, window), prepared.reference
    return {
        "start": window[0],
        "end": window[1],
        "settling_band": scenario.settling_band,
        "holds": {
            axis: holds_within(reference, AXES.index(axis), window) for axis in reference.moving
        },
        "variants": {
            name: variant_identity(scenario, reference, variant)
            for name, variant in scenario.variants.items()
        },
    }
