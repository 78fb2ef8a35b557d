"""The motion by which commissioning measures a frequency response: a multisine with low gains.

Its size follows from the linearised loop: the reference R brings about the force command
``R C/(1 + L)`` and the following error ``R/(1 + L)``, which are bounded by the currents and by the
window of the axis. The multisine is eased in and out with the velocity of each slide.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from motionlab.config.drive import DriveAxisConfig
from motionlab.config.load import load_scenario
from motionlab.config.multisine import Multisine
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.field import SCENARIO, VARIANT
from motionlab.drive.commissioning.hold import low_gain_changes
from motionlab.drive.commissioning.run import StepRun, Stopped
from motionlab.drive.motion import on_drives
from motionlab.kernel.force_maps import pole_pitch
from motionlab.loop.linearise import linearise
from motionlab.trajectories.multisine import lines_of, slide_seconds, slides

FORCE = 2.0
"""RMS of the multisine's force, N; at most `SHARE` of the largest force."""
SHARE = 0.05
FOLLOWING = 0.1
"""RMS of the following error that it brings about, of the window, at most."""
REFERENCE = 0.12
"""RMS of the force that would follow the multisine, of the largest force, at most."""
CORNER = 4.0
"""Frequency above which the sines keep their velocity, over the crossover."""
SPEED = 0.044
"""Largest velocity of the slides, m/s; rounded down to whole pole pitches in a period."""
SLIDES = 14
"""To and fro; 28 s in all."""
_ROOM = 0.8  # of the range of positions
LOWEST = 2.0
"""Hz; a period of it."""
_LINES = 40
_SIZES = np.geomspace(20.0, 1e-3, 200)  # m/s^2


def shaking(run: StepRun, axis: str, mass: float | None) -> Scenario:
    """Return slides of an axis to and fro under a multisine, with low gains.

    Parameters
    ----------
    run : StepRun
        The step.
    axis : str
        ``x`` or ``y``.
    mass : float or None
        As identified, kg; None: as in the model.

    Raises
    ------
    Stopped
        If the range of positions is shorter than a slide takes.
    """
    config = getattr(run.config, axis)
    changes = low_gain_changes()
    identified = {} if mass is None else {f"plant.{axis}.mass": mass}
    scenario = load_scenario(SCENARIO, changes | identified)
    pitch = pole_pitch(getattr(scenario.plant, axis).force_map)
    middles = {each: _middle(getattr(run.config, each)) for each in AXES}
    fixed = {"axis": axis, "center": middles, "low": LOWEST, "lines": _LINES, "slides": SLIDES}
    seconds = slide_seconds(Multisine.model_validate(fixed))
    span = config.position_max - config.position_min
    pitches = int(min(SPEED, _ROOM * span / seconds) / (pitch * LOWEST))
    if pitches < 1:
        needs = pitch * LOWEST * seconds / _ROOM
        raise Stopped(f"{axis}: positions range over {span:.3g} m, a slide takes {needs:.3g} m")
    fixed["velocity"] = pitches * pitch * LOWEST
    trajectory = {"kind": "multisine"} | _sized(scenario, fixed, config)
    return on_drives(
        load_scenario(SCENARIO, changes | {"name": "commissioning", "trajectory": trajectory}),
        VARIANT,
    )


def largest_force(scenario: Scenario, current: float) -> float:
    """Return what an axis surely pulls with a current, N; with less, thrust goes by its square."""
    controller = scenario.variants[VARIANT].controller
    return controller.force_limit * min(1.0, current / controller.current_limit) ** 2


def _middle(limits: DriveAxisConfig) -> float:
    return (limits.position_min + limits.position_max) / 2


def _sized(
    scenario: Scenario, fixed: Mapping[str, object], limits: DriveAxisConfig
) -> dict[str, object]:
    """Return the motion with the largest acceleration that force and following error allow."""
    motion = Multisine.model_validate(fixed)
    frequency = lines_of(motion).frequency
    loop = linearise(scenario, VARIANT, motion.axis, v=motion.velocity)
    L = loop.open(frequency)
    # Above the crossover the command falls with frequency, unless the sines grow.
    corner = CORNER * max(1.0, float(frequency[np.argmax(np.abs(L) < 1.0)]))
    mass = getattr(scenario.plant, motion.axis).mass
    largest = largest_force(scenario, limits.current_max)
    bounds = (
        (np.abs(loop.controller.response(frequency) / (1.0 + L)), min(FORCE, SHARE * largest)),
        (1.0 / np.abs(1.0 + L), FOLLOWING * limits.following_error),
        # What would follow the reference, as `prepare` asks of every motion.
        (mass * (2.0 * np.pi * frequency) ** 2, REFERENCE * largest),
    )
    for acceleration in _SIZES.tolist():
        sized = dict(fixed) | {"corner": corner, "acceleration": acceleration}
        size = np.abs(next(slides(Multisine.model_validate(sized))).amplitudes) / math.sqrt(2.0)
        if all(np.linalg.norm(size * gain) <= most for gain, most in bounds):
            return sized
    raise Stopped(f"{motion.axis}: no multisine is small enough for its currents and its window")
