"""Other motions learnt first, and what they teach carried over to the first lap of a motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.kernel.force_maps import pole_pitch
from motionlab.simulation.prepare import Prepared
from motionlab.studies.learn.carry_over import Course, Lesson, LessonFit, fit_lessons
from motionlab.studies.learn.laps import Learning
from motionlab.studies.learn.learning_filter import modelled

Array = NDArray[np.float64]

LAPS = 16
"""Of a motion that is learnt first."""
SIMULATED_LAPS = 10
"""Of the motor of the controller's model, in which what was taught becomes a force."""
MEAN_LAPS = 4
"""Over which the force that a motion needs is averaged, after it was learnt."""


def lesson_fits(learnings: Sequence[Learning]) -> dict[str, LessonFit]:
    """Return what motions that were learnt by one controller teach, by axis."""
    lessons: dict[str, list[Lesson]] = {}
    for learning in learnings:
        force = learning.needed(MEAN_LAPS)
        for axis in learning.axes:
            lesson = Lesson(_course(learning, axis), force[:, AXES.index(axis)])
            lessons.setdefault(axis, []).append(lesson)
    first = learnings[0]
    model = first.prepared.scenario.variants[first.variant].controller.model
    return {
        axis: fit_lessons(each, getattr(model, axis), pole_pitch(getattr(model, axis).force_map))
        for axis, each in lessons.items()
    }


def carry_over(
    learning: Learning, fits: dict[str, LessonFit], begin: Callable[[Prepared], Learning]
) -> None:
    """Give learning, before its first lap, the force of a motor with what lessons teach.

    Parameters
    ----------
    learning : Learning
        Whose axes get a force, where there is something known of them.
    fits : dict of str to LessonFit
        By axis.
    begin : callable
        Returns learning of the same motion, of another scenario, that knows nothing.
    """
    scenario = modelled(learning.prepared.scenario, learning.variant)
    simulated = begin(replace(learning.prepared, scenario=scenario, epochs=((0, scenario),)))
    load = {
        axis: each.beyond_model(_course(learning, axis))
        for axis, each in fits.items()
        if axis in learning.axes
    }
    simulated.load(load)
    for _ in simulated.run(SIMULATED_LAPS):
        pass
    for axis in load:
        learning.axes[axis].force = simulated.axes[axis].force
    learning.take_up()


def _course(learning: Learning, axis: str) -> Course:
    """Return the lap of an axis."""
    (first, ticks), number = learning.lap, AXES.index(axis)
    reference, span = learning.prepared.reference, slice(first, first + ticks)
    return Course(
        position=reference.position[span, number],
        velocity=reference.velocity[span, number],
        acceleration=reference.acceleration[span, number],
        q=learning.axes[axis].filter.q,
    )
