"""A trial of a file of a law or an effect, which this process has imported.

`own_laws.check` runs it in a child.
"""

from __future__ import annotations

import re
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.declarations import DeclarationError
from motionlab.effects import EFFECTS, Effect
from motionlab.effects import FILES as EFFECT_FILES
from motionlab.errors import FieldError
from motionlab.kernel.law_calls import renew_law
from motionlab.laws import FILES, LAWS, Law
from motionlab.own_laws.check import LINE, Checked
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.targets.record_law import lane_error
from motionlab.timing import CONTROL_PERIOD

_SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}


def try_file(path: Path) -> Checked:
    """Return what is wrong with the law or effect of a file of this process, or nothing."""
    for name, file in EFFECT_FILES.items():
        if file.path == path:
            return _no_lanes(EFFECTS[name], path) or _run(name, path, effect=True)
    name = next(name for name, file in FILES.items() if file.path == path)
    return _no_lanes(LAWS[name], path) or _run(name, path)


def try_version(name: str, text: str, path: Path) -> Checked:
    """Return what is wrong with another version of a law that this process has, or nothing."""
    try:
        law, _ = FILES[name].declared("LAW", text)
        if problem := _no_lanes(law, path):
            return problem
        renew_law(name, text)
    except DeclarationError as error:
        return Checked(name, (error.error.at(str(path)),))
    except Exception as error:
        return Checked(name, (_raised(name, path, error),))
    return _run(name, path)


def _no_lanes(law: Law | Effect, path: Path) -> Checked | None:
    if not (reason := lane_error(law)):
        return None
    reason = reason.replace(law.step.__module__, path.name)
    line = re.search(r"\bline (\d+)", reason)
    place = f"{path}:{line[1]}" if line else str(path)
    problem = FieldError(law.name, f"is not made of lanes: {reason}", place=place)
    return Checked(law.name, (problem,))


def _run(name: str, path: Path, *, effect: bool = False) -> Checked:
    try:
        problem = problem_of_effect(name) if effect else problem_of(name)
    except Exception as error:
        problem = _raised(name, path, error)
    return Checked(name, () if problem is None else (problem.at(str(path)),))


def _raised(name: str, path: Path, error: Exception) -> FieldError:
    """Return why a law cannot be compiled or run, with the line of its file where there is one."""
    lines = [line for file, line in LINE.findall(str(error)) if file == str(path)]
    lines += [
        str(each.lineno)
        for each in traceback.extract_tb(error.__traceback__)
        if each.filename == str(path)
    ]
    reason = next((line for line in str(error).splitlines() if line.strip()), "")
    message = f"cannot be compiled or run: {type(error).__name__}: {reason}"
    return FieldError(name, message, place=f"{path}:{lines[-1]}" if lines else str(path))


def problem_of(name: str) -> FieldError | None:
    """Simulate a circle with the law in controller B, and say where its force is not finite."""
    law = {"variants.B.controller.compensation.law": name}
    return _not_finite(name, law, "friction_estimate")


def problem_of_effect(name: str) -> FieldError | None:
    """Simulate a circle with the effect on both axes, and say where its force is not finite."""
    effects = {f"plant.{axis}.effects": [{"effect": name}] for axis in AXES}
    return _not_finite(name, effects, "acceleration")


def _not_finite(name: str, changes: dict[str, Any], channel: str) -> FieldError | None:
    recording = run(prepare(load_scenario("circle", _SHORT | changes), checked=True))
    for axis in AXES:
        force = recording.variants["B"].channel(channel, axis)
        wrong = np.flatnonzero(~np.isfinite(force))
        if len(wrong):
            at = f"{wrong[0] * CONTROL_PERIOD:.4f} s of a circle, on {axis}"
            return FieldError(name, f"gives a force that is {force[wrong[0]]} at {at}")
    return None
