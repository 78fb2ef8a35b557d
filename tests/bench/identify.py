"""Identification of friction: how far from the simulated motor's own, and how long it takes."""

from __future__ import annotations

import time
from collections.abc import Iterator

from motionlab.studies.identify import experiment
from motionlab.studies.identify.documents import IdentificationDocument, read_request
from motionlab.studies.identify.experiment import plan
from tests.bench.table import Row
from tests.simulated import true_map

_TARGET = 0.02
_MODEL = "variants.A.controller.model"
_SLIDING = ("F_c", "F_s", "v_s", "sigma_2")
"""The four; sigma_0 and sigma_1 come from other motions and have no target."""


def identify() -> Iterator[Row]:
    """Identify both axes of each motor by the default experiment, the true map in control."""
    begin = time.perf_counter()
    found = _identified("nominal")
    took = time.perf_counter() - begin
    yield from _rows("worst of four: nominal motor", found, _TARGET)
    yield from _rows("worst of four: as-measured, its map", _identified("as-measured"), _TARGET)
    for law in ("least-norm", "sine"):
        yield from _rows(f"worst of four: FEM map, {law}", _by_table(law), _TARGET)
    # The amplifiers of this one add up to 0.1 A that no map knows: no target holds for it.
    yield from _rows("worst of four: matched, its map", _identified("matched"), None)
    yield Row(
        f"  the experiment: {found.simulated_time:.0f} s of motion",
        "",
        f"{took:.1f} s",
        "",
        f"{found.simulated_time / took:.0f}",
    )


def _identified(plant: str) -> IdentificationDocument:
    request = read_request({"set": {"plant": plant, **true_map(plant)}})
    return experiment.identify(plan(request))


def _by_table(law: str) -> IdentificationDocument:
    """Identify with a map by finite elements in motor and controller."""
    table = {"kind": "table", "name": "new-design"}
    axes = ("x", "y")
    maps = [f"{part}.{a}.force_map" for part in ("plant", _MODEL) for a in axes]
    request = {"set": dict.fromkeys(maps, table) | {"variants.A.controller.sharing.law": law}}
    return experiment.identify(plan(read_request(request)))


def _rows(motor: str, found: IdentificationDocument, target: float | None) -> Iterator[Row]:
    for axis, part in found.axes.items():
        errors = {name: (part.sliding.parameters[name].ratio or 0.0) - 1.0 for name in _SLIDING}
        worst = max(errors, key=lambda name: abs(errors[name]))
        yield Row(
            f"{motor}, {axis}",
            "" if target is None else f"<= {target:.0%}",
            f"{errors[worst]:+.2%}",
            f"true {worst}",
            "",
            None if target is None else abs(errors[worst]) <= target,
        )
