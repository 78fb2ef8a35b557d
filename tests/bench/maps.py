"""Force maps by finite elements: time, and every check of their accuracy."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.field import FieldModel
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.fem.gap_permeance import Cell
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.workers import FieldTask, fields
from tests.bench.table import Row
from tests.motor_design.carter import carter

_DEFAULT, _PREVIEW = 60.0, 0.3  # s
_REFERENCE = 0.3  # N
_ZERO, _STRESS = 0.02, 0.1  # N
_CARTER = 3e-3  # relative
_OFF_GRID, _OFF_GRID_RMS = 0.15, 0.03  # N

Array = NDArray[np.float64]


def maps() -> Iterator[Row]:
    """Measure the presets, and hold the model against what it must obey."""
    g = Geometry()
    _, took_preview = _timed(g, "preview")
    yield _row("map, preview", _PREVIEW, took_preview, "s", "")
    default, took = _timed(g, "default")
    points = len(default.document.positions) * (len(default.document.currents) - 1)
    yield _row(f"map, default, {points} points", _DEFAULT, took, "s", "four processes at most")
    reference, took_reference = _timed(g, "reference")
    apart = np.abs(_everywhere(default) - _everywhere(reference))
    note = f"rms {_rms(apart):.3f} N; reference {took_reference:.0f} s"
    yield _row("  thrust against the reference", _REFERENCE, float(apart.max()), "N", note)
    for name, found in (("default", default), ("reference", reference)):
        off = _stress(found)
        note = f"rms {_rms(off):.3f} N"
        yield _row(f"  dW'/dx against the stress, {name}", _STRESS, float(off.max()), "N", note)
    yield _row("  thrust aligned and unaligned", _ZERO, _zero(default), "N", "stress, 1 to 10 A")
    cell = Cell(g, Resolution(48, 2), smooth_stator=True).permeance(0)
    off = abs(cell / carter(g) - 1)
    yield Row(
        "Carter's cell, h = 0.15 mm",
        f"< {_CARTER:.1%}",
        f"{off:.2%}",
        "closed form",
        f"{cell / carter(g):.4f}",
        off < _CARTER,
    )
    for name, resolution, currents, stride in (
        ("between positions", Resolution(48, 2), 6, (2, 1)),
        ("between currents", Resolution(24, 2), 21, (1, 2)),
    ):
        off = _off_grid(g, resolution, currents, stride)
        yield _row(f"cells {name}, thrust", _OFF_GRID, float(off.max()), "N", "twice the nodes")
        yield _row("  rms", _OFF_GRID_RMS, _rms(off), "N", "")


def _row(what: str, target: float, measured: float, unit: str, reference: str) -> Row:
    figure = f"{measured:.3g} {unit}"
    return Row(what, f"< {target:g} {unit}", figure, reference, "", measured < target)


def _timed(geometry: Geometry, preset) -> tuple[ForceMap, float]:
    before = time.perf_counter()
    found = compute(geometry, preset)
    return found, time.perf_counter() - before


def _everywhere(force_map: ForceMap) -> Array:
    x = np.linspace(-force_map.tau / 2, force_map.tau / 2, 289)
    i = np.linspace(0.0, force_map.i_max, 41)
    return force_map.thrust(x[:, None], i[None, :])


def _stress(force_map: ForceMap) -> Array:
    """Return how far thrust lies from the stress tensor's at the nodes, N."""
    d = force_map.document
    x, i = np.array(d.positions)[:, None], np.array(d.currents)[None, :]
    return np.abs(force_map.thrust(x, i) - np.array(d.thrust))


def _zero(force_map: ForceMap) -> float:
    """Return the largest thrust by the stress where there should be none, N."""
    table = np.array(force_map.document.thrust)
    return float(np.max(np.abs(table[[0, len(table) // 2, -1]])))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _off_grid(g: Geometry, resolution: Resolution, count: int, stride: tuple[int, int]) -> Array:
    """Return how far a map on every so many nodes lies from one on all of them, N.

    Both of the same quadratic elements: linear ones are rougher than the step between nodes.
    """
    currents = np.linspace(0.0, g.i, count)
    half = FieldModel(g, resolution).cells_per_pitch // 2
    work = FieldTask(g, resolution, currents, list(range(half + 1)))
    found = np.array(fields(work, workers=None, progress=None))
    whole = np.concatenate([found[:0:-1], found])
    k, m = stride
    fine, coarse = _map(g, whole, currents), _map(g, whole[::k, ::m], currents[::m])
    x = np.linspace(-g.tau / 2, g.tau / 2, len(whole))
    where = x[:, None], currents[None, :]
    return np.abs(fine.thrust(*where) - coarse.thrust(*where))


def _map(g: Geometry, tables: Array, currents: Array) -> ForceMap:
    like = compute(g, "preview").document.model_dump()
    x = np.linspace(-g.tau / 2, g.tau / 2, len(tables))
    columns = {
        name: tables[:, :, k].tolist()
        for k, name in enumerate(("coenergy", "linkage", "thrust", "normal_force"))
    }
    changed = columns | {"positions": x.tolist(), "currents": currents.tolist()}
    return ForceMap.from_tables(like | changed)
