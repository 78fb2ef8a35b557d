"""A trial of a file of a law or an effect, which this process has imported.

`own_laws.check` runs it in a child.
"""

from __future__ import annotations

import re
import traceback
from dataclasses import replace
from pathlib import Path

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.declarations import DeclarationError
from motionlab.effects import EFFECTS, Effect, MidStep
from motionlab.effects import FILES as EFFECT_FILES
from motionlab.effects import SHIPPED as SHIPPED_EFFECTS
from motionlab.errors import FieldError
from motionlab.kernel.law_renewal import LawVersion, Renewal
from motionlab.laws import FILES, LAWS, SOURCES, Law, new_law
from motionlab.own_files import OwnFile
from motionlab.own_laws.accepted import renew_accepted
from motionlab.own_laws.check import LINE, Checked
from motionlab.own_laws.cost import cost_of
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.targets.record_law import lane_error
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP

_SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}


def try_file(path: Path) -> Checked:
    """Return what is wrong with the law or effect of a file of this process, or nothing."""
    for name, file in EFFECT_FILES.items():
        if file.path == path:
            return _no_lanes(EFFECTS[name], path) or _run(name, path, effect=True)
    name = next(name for name, file in FILES.items() if file.path == path)
    return _no_lanes(LAWS[name], path) or _run(name, path)


def try_version(name: str, text: str, path: Path) -> Checked:
    """Return what is wrong with another version of a law that the server has, or nothing.

    Parameters
    ----------
    name : str
        Of the law; empty where the file is new.
    text : str
        What the file holds.
    path : Path
        The file.
    """
    file = FILES.get(name, OwnFile(path))
    try:
        renew_accepted(compiles=False)
        if name:
            law, _ = file.declared("LAW", text)
        else:
            law, _ = new_law(file, text)
            name = law.name
        if problem := _no_lanes(law, path):
            return problem
        Renewal([LawVersion(name, text, SOURCES.get(name, text), file)]).take()
    except DeclarationError as error:
        return Checked(name, (error.error.at(str(path)),))
    except Exception as error:
        return Checked(name, (_raised(name or path.stem, path, error),))
    return _run(name, path)


def with_cost(result: Checked) -> Checked:
    """Return a result with what the law costs, where it is a law that can be taken."""
    if result.problems or result.name not in LAWS:
        return result
    cost = cost_of(result.name)
    return replace(result, ns=cost.ns, share=cost.share)


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


def warm_up(path: Path) -> None:
    """Have the kernel compiled that a file's law or effect runs in: that is no time of the file."""
    problem_of("off")
    if any(file.path == path for file in EFFECT_FILES.values()):
        problem_of_effect(next(iter(SHIPPED_EFFECTS)))


def problem_of(name: str) -> FieldError | None:
    """Simulate a circle with the law in controller B, and say where its force is not finite."""
    law = {"variants.B.controller.compensation.law": name}
    recording = run(prepare(load_scenario("circle", _SHORT | law), checked=True))
    return _not_finite(name, recording.variants["B"], "friction_estimate")


def problem_of_effect(name: str) -> FieldError | None:
    """Simulate a circle with the effect on both axes, and say where it gives what it may not."""
    effects = {f"plant.{axis}.effects": [{"effect": name}] for axis in AXES}
    scenario = load_scenario("circle", _SHORT | effects)
    record = run(prepare(scenario, checked=True)).variants["B"]
    for axis in AXES:
        if problem := _wrong_damping(name, scenario, record, axis):
            return problem
    return _not_finite(name, record, "acceleration")


def _wrong_damping(
    name: str, scenario: Scenario, record: VariantRecord, axis: str
) -> FieldError | None:
    """Call the effect along what was recorded, and say where its damping is none.

    Damping is no channel. Between two samples the motion is taken as constant.
    """
    effect, plant = EFFECTS[name], getattr(scenario.plant, axis)
    # Numbers of numpy, which divide by zero as compiled code does.
    values = next(par for each, par in plant.effect_lanes() if each == name)
    par = type(values)(*map(np.float64, values))
    state = effect.State(*np.zeros(len(effect.State._fields)))
    M, h = np.float64(plant.mass), np.float64(PLANT_STEP)
    channels = (*MidStep._fields[:2], *MidStep._fields[3:8])  # all but time, mass and step
    columns = [record.channel(channel, axis).astype(np.float64) for channel in channels]
    with np.errstate(all="ignore"):
        for tick, (position, velocity, *others) in enumerate(zip(*columns, strict=True)):
            time = np.float64(tick * CONTROL_PERIOD)
            seen = MidStep(position, velocity, time, *others, M=M, h=h)
            for _ in range(round(CONTROL_PERIOD / PLANT_STEP)):
                resistance, state = effect.step(par, state, seen)
                damping = float(resistance.damping)
                if not 0.0 <= damping < np.inf:
                    message = (
                        f"gives a damping at {time:.4f} s of a circle, on {axis}, that is none"
                    )
                    return FieldError(name, message, damping, ">= 0", "N s/m")
                if not np.isfinite(resistance.force):
                    return None  # as the channels say
    return None


def _not_finite(name: str, record: VariantRecord, channel: str) -> FieldError | None:
    for axis in AXES:
        force = record.channel(channel, axis)
        wrong = np.flatnonzero(~np.isfinite(force))
        if len(wrong):
            at = f"{wrong[0] * CONTROL_PERIOD:.4f} s of a circle, on {axis}"
            return FieldError(name, f"gives a force that is {force[wrong[0]]} at {at}")
    return None
