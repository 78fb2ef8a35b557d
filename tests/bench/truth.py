"""How often the friction model of a machine is selected right from a record of it.

``make bench BENCH=truth`` draws `DRAWS` motors of each kind of friction, half of them the lab's
with an effect, recorded by their currents, and half a machine that is not the lab's, with a
resonance, cogging and a measured normal force. ``MOTIONLAB_DRAWS`` gives another number. Each is
moved by five sines, from 20 to 50 mm down to 20 to 60 um, imported from CSV, and judged. A fifth as
many have friction of each kind that none of the models has, and must be noted as such.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motionlab.studies.friction.study import FrictionModelsStudy
from tests.bench.table import Row
from tests.studies.friction import lab_motor, one_axis_machine
from tests.studies.identify.measured_runs import imported

DRAWS = 100
KINDS = ("coulomb", "stribeck", "lugre", "lugre-load", "gms")
_SEED = 80_000
"""Of the first draw; none of them was looked at when the method was chosen."""
_RIGHT = 0.95
_FALSE, _NOTED = 0.02, 0.8
"""Records with a false note at most, and with the note of a friction that no model has at least."""
_BESIDE = 20_000
_COGGING = re.compile(r"period of 7\.(1[5-9]|2[0-5]?) mm")
_CANNOT_TELL = "cannot tell"


def drawn_sines(rng: np.random.Generator) -> list[tuple[float, float, int]]:
    """Return sines that a person would record: large, fast, slow, and two small ones."""
    u = rng.uniform
    return [
        (u(0.02, 0.05), u(0.2, 0.3), 2),
        (u(0.01, 0.02), u(0.7, 1.2), 3),
        (u(2e-3, 5e-3), u(0.3, 0.5), 2),
        (u(1e-4, 4e-4), u(0.5, 0.8), 2),
        (u(2e-5, 6e-5), u(1.0, 1.5), 3),
    ]


def drawn_motor(rng: np.random.Generator) -> dict[str, float]:
    """Return friction and mass of a motor, each within the range that guides have."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    F_c = between(0.3, 2.5)
    F_s = F_c * between(1.5, 5.0)
    sigma_0 = F_s / between(3e-6, 3e-5)
    return {
        "M": 5.9 * rng.uniform(0.9, 1.1),
        "F_c": F_c,
        "F_s": F_s,
        "v_s": between(4e-3, 0.04),
        "sigma_0": sigma_0,
        "sigma_1": sigma_0 * between(2e-3, 15e-3),
        "sigma_2": rng.uniform(4.0, 30.0),
        "mu": between(0.005, 0.05),
        "attraction": between(30.0, 1000.0),
    }


OUTSIDE = {
    "cogging": "depends on the position",
    "cable": "depends on the position",
    "tight": "depends on the position",
    "warming": "changes over time",
    "power": "depends on the velocity",
    "hump": "depends on the velocity",
    "skew": "differs between the directions",
    "memory": "since a reversal",
}
"""Parts of `one_axis_machine.Machine` that no model has, and what a note says of each."""


def drawn_part(kind: str, F_c: float, rng: np.random.Generator) -> dict[str, float]:
    """Return a friction that no model has: 20 to 60 % of F_c, or of what it changes."""
    size, u = rng.uniform(0.2, 0.6), rng.uniform
    parts = {
        "cogging": {"cogging": size * F_c, "pitch": u(3e-3, 25e-3)},
        "cable": {"cable": size * F_c},
        "tight": {"tight": size, "pitch": u(3e-3, 60e-3)},
        "warming": {"warming": size, "settling": u(3.0, 15.0)},
        "power": {"power": 2.0 * size * F_c},
        "hump": {"hump": size * F_c},
        "skew": {"skew": size},
        "memory": {"memory": size * F_c, "length": u(0.5e-3, 3e-3)},
    }
    return parts[kind]


class Verdict(NamedTuple):
    """Where a motor is from, its kind, what is selected, and what is noted of what is left."""

    source: str
    kind: str
    selected: str
    describes: bool
    notes: list[str]


def verdict(job: tuple[str, str, int]) -> Verdict:
    """Return what is selected for a motor."""
    source, kind, number = job
    outside = kind in OUTSIDE
    seed = _SEED + number
    seed += 1000 * (_BESIDE // 1000 + [*OUTSIDE].index(kind) if outside else KINDS.index(kind))
    rng = np.random.default_rng(seed)
    motor, parts = drawn_motor(rng), drawn_sines(rng)
    request: dict[str, Any] = {"axis": "x"}
    if source == "lab":
        columns = lab_motor.recorded(kind, motor, parts, seed)
    else:
        if kind != "lugre-load":
            motor["mu"] = 0.0
        resonance, cogging = rng.uniform(100.0, 300.0), rng.uniform(0.0, 0.02)
        more = {"cogging": cogging}
        if outside:
            more |= drawn_part(kind, motor["F_c"], rng)
        base = ("stribeck", "lugre")[number % 2] if outside else kind
        machine = one_axis_machine.Machine(base, **motor, resonance=resonance, **more)
        columns = one_axis_machine.recorded(machine, one_axis_machine.sines(parts), seed)
        names = {"position": "slide", "force": "push", "normal_force": "preload"}
        request |= {f"{kind}_column": name for kind, name in names.items()}
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MOTIONLAB_DATA"] = folder
        mapping = () if source == "lab" else ("slide=", "push=", "preload=")
        run = imported(Path(folder), columns, *mapping)
        study = FrictionModelsStudy()
        result = study.run(study.plan(request | {"run": run}), lambda *_: None)
    notes = [note for note in result.notes if "leaves over" in note]
    return Verdict(source, kind, result.selected or _CANNOT_TELL, result.describes, notes)


def truth() -> Iterator[Row]:
    """Record and judge many motors of each kind, one process a core."""
    count = int(os.environ.get("MOTIONLAB_DRAWS", DRAWS))
    jobs = [
        (("lab", "other")[number % 2], kind, number) for kind in KINDS for number in range(count)
    ]
    jobs += [("other", kind, number) for kind in OUTSIDE for number in range(max(1, count // 5))]
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        verdicts = [*pool.map(verdict, jobs)]
    for kind in KINDS:
        yield _judged(kind, Counter(v.selected for v in verdicts if v.kind == kind), judged=True)
        for source in ("lab", "other"):
            some = Counter(v.selected for v in verdicts if v[:2] == (source, kind))
            yield _judged(kind, some, f"  {source}")
    yield _falsely_noted([v for v in verdicts if v.kind in KINDS])
    yield _noted([v for v in verdicts if v.kind in OUTSIDE], "no model's friction", judged=True)
    for kind in OUTSIDE:
        yield _noted([v for v in verdicts if v.kind == kind], f"  {kind}")


def _falsely_noted(family: list[Verdict]) -> Row:
    """Judge notes of machines that follow a model; that of their cogging, over 7.2 mm, is right."""
    noted = [v for v in family if any(not _COGGING.search(note) for note in v.notes)]
    share = len(noted) / len(family)
    kinds = ", ".join(f"{v.source} {v.kind}" for v in noted)
    return Row(
        f"a model's friction: {len(family)} draws",
        f"noted <= {_FALSE:.0%}",
        f"{len(noted)} falsely noted",
        f"{sum(not v.describes for v in family)} not described",
        kinds,
        share <= _FALSE,
    )


def _noted(some: list[Verdict], label: str, judged: bool = False) -> Row:
    right = sum(any(OUTSIDE[v.kind] in note for note in v.notes[:1]) for v in some)
    others = sum(bool(v.notes) for v in some) - right
    selected = sum(v.selected != _CANNOT_TELL for v in some)
    return Row(
        f"{label}: {len(some)} draws",
        f"noted >= {_NOTED:.0%}" if judged else "",
        f"{right} noted right",
        f"{sum(not v.describes for v in some)} not described",
        f"{others} noted otherwise, {selected} selected",
        right >= _NOTED * len(some) if judged else None,
    )


def _judged(kind: str, chosen: Counter[str], label: str = "", judged: bool = False) -> Row:
    total, right, unsure = chosen.total(), chosen[kind], chosen[_CANNOT_TELL]
    wrong = total - right - unsure
    others = [f"{n} {name}" for name, n in chosen.items() if name not in {kind, _CANNOT_TELL}]
    return Row(
        label or f"{kind}: {total} draws",
        f"wrong <= {1.0 - _RIGHT:.0%}" if judged else "",
        f"{right} right",
        f"{unsure} cannot tell",
        ", ".join(others) or "0 wrong",
        wrong <= (1.0 - _RIGHT) * total if judged else None,
    )
