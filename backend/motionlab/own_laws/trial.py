"""A trial of a law's file, which this process has imported: `own_laws.check` runs it in a child."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.declarations import DeclarationError
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
    """Return what is wrong with the law of a file that this process has, or that nothing is."""
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


def _no_lanes(law: Law, path: Path) -> Checked | None:
    if not (reason := lane_error(law)):
        return None
    reason = reason.replace(law.step.__module__, path.name)
    line = re.search(r"\bline (\d+)", reason)
    place = f"{path}:{line[1]}" if line else str(path)
    problem = FieldError(law.name, f"is not made of lanes: {reason}", place=place)
    return Checked(law.name, (problem,))


def _run(name: str, path: Path) -> Checked:
    try:
        problem = problem_of(name)
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
    recording = run(prepare(load_scenario("circle", _SHORT | law), checked=True))
    for axis in "xy":
        force = recording.variants["B"].channel("friction_estimate", axis)
        wrong = np.flatnonzero(~np.isfinite(force))
        if len(wrong):
            at = f"{wrong[0] * CONTROL_PERIOD:.4f} s of a circle, on {axis}"
            return FieldError(name, f"gives a force that is {force[wrong[0]]} at {at}")
    return None
