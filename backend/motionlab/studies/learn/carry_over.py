"""What laps of other motions teach of a motor, as a force for a motion that was never run.

Where an axis has learnt a motion, the force it needs is known, tick by tick. Of all such laps it is
fitted by what depends on the motion only::

    F = M a + s_2 v + LuGre(p, v) + f_0 + sum_m (c_m + d_m f + e_m abs(f)) cos, sin(2 pi m p/tau)

with f the force that the controller's model asks for: mass and viscous friction, the friction of a
bristle, and errors of force map, amplifiers and offsets, which repeat with the pole pitch. Five
numbers of the bristle are searched; for each, all others are a linear least-squares fit.

What the fit says of another motion is more than the controller's model gives. A motor of that model
with the difference as its load learns it in some laps, simulated: its force is the first of the
other motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from motionlab.config.controller import AxisModelConfig
from motionlab.plant.friction import LuGre
from motionlab.studies.identify.presliding import bristle
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

HARMONICS = 6
"""Of the pole pitch, in errors of map and amplifiers."""
_SEARCHED = ("sigma_0", "sigma_1", "F_c", "F_s", "v_s")
_RIDGE, _PRIOR = 1e-5, 2e-3
_FARTHEST = 2.5  # e-folds from the model


@dataclass(frozen=True)
class Course:
    """A lap of one axis as its controller sees it: what the model says, and the shapes of a fit.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (ticks,)
        Of the reference, m, m/s, m/s^2.
    q : ndarray, shape (n,)
        Weight of each frequency of the lap, as in learning.
    """

    position: Array
    velocity: Array
    acceleration: Array
    q: Array

    def friction(self, friction: LuGre) -> Array:
        """Return LuGre friction without its viscous part over a lap that repeats, N, (ticks,)."""
        ticks = len(self.position)
        twice = [np.concatenate([each, each]) for each in (self.position, self.velocity)]
        z = bristle(*twice, np.zeros(2 * ticks, dtype=bool), friction)
        rate = np.diff(z, prepend=z[:1]) / CONTROL_PERIOD
        return (friction.sigma_0 * z + friction.sigma_1 * rate)[ticks:]

    def modelled(self, model: AxisModelConfig) -> Array:
        """Return the force that the model of a controller asks for, N, (ticks,)."""
        friction = model.friction.parameters()
        viscous = friction.sigma_2 * self.velocity
        return model.mass * self.acceleration + viscous + self.friction(friction)

    def shapes(self, model: AxisModelConfig, tau: float) -> Array:
        """Return what the fit is linear in, (ticks, shapes)."""
        f = self.modelled(model)
        columns = [self.acceleration, self.velocity, np.ones_like(f), f, np.abs(f)]
        for m in range(1, HARMONICS + 1):
            angle = 2.0 * np.pi * m * self.position / tau
            for shape in (np.cos(angle), np.sin(angle)):
                columns += [shape, shape * f, shape * np.abs(f)]
        return np.stack(columns, axis=1)

    def smooth(self, values: Array) -> Array:
        """Return values with the frequencies that are learnt, (ticks,) or (ticks, columns)."""
        weight = self.q if values.ndim == 1 else self.q[:, None]
        lap = np.fft.irfft(np.fft.rfft(values, axis=0) * weight, len(values), axis=0)
        return np.asarray(lap, dtype=np.float64)


@dataclass(frozen=True)
class Lesson:
    """A lap of one axis that was learnt, and the force that it needs, N, (ticks,)."""

    course: Course
    force: Array


@dataclass(frozen=True)
class LessonFit:
    """What lessons teach of an axis.

    Attributes
    ----------
    model : AxisModelConfig
        Of the controller.
    tau : float
        Pole pitch, m.
    friction : LuGre
        Of the bristle that was fitted.
    weights : ndarray, shape (shapes,)
        Of `Course.shapes`.
    explained : float
        Share of the variance of what the model leaves that the fit explains.
    """

    model: AxisModelConfig
    tau: float
    friction: LuGre
    weights: Array
    explained: float

    def beyond_model(self, course: Course) -> Array:
        """Return the force of a lap beyond that of the controller's model, N, (ticks,)."""
        fitted = self.model.mass * course.acceleration + course.friction(self.friction)
        fitted += course.shapes(self.model, self.tau) @ self.weights
        return course.smooth(fitted - course.modelled(self.model))


def fit_lessons(lessons: Sequence[Lesson], model: AxisModelConfig, tau: float) -> LessonFit:
    """Return what lessons teach of one axis.

    Parameters
    ----------
    lessons : sequence of Lesson
        At least one.
    model : AxisModelConfig
        Of the controller that has learnt.
    tau : float
        Pole pitch of its force map, m.
    """
    scales = [1.0 / math.sqrt(len(each.force)) for each in lessons]
    shapes = np.concatenate(
        [
            scale * each.course.smooth(each.course.shapes(model, tau))
            for each, scale in zip(lessons, scales, strict=True)
        ]
    )
    sizes = np.sqrt((shapes**2).sum(axis=0)) + 1e-12
    shapes = shapes / sizes
    gram = shapes.T @ shapes + _RIDGE * np.eye(shapes.shape[1])
    solve = np.linalg.solve(gram, shapes.T)
    known = model.friction.parameters()

    def friction(steps: Array) -> LuGre:
        values = {
            name: getattr(known, name) * math.exp(step)
            for name, step in zip(_SEARCHED, steps.tolist(), strict=True)
        }
        return known._replace(**values | {"F_s": max(values["F_s"], values["F_c"])})

    def rest(steps: Array) -> Array:
        """Return what the bristle leaves to the linear shapes, N, scaled, of all lessons."""
        fitted = friction(steps)
        parts = []
        for each, scale in zip(lessons, scales, strict=True):
            inertia = model.mass * each.course.acceleration
            left = each.force - inertia - each.course.friction(fitted)
            parts.append(scale * each.course.smooth(left))
        return np.concatenate(parts)

    def misses(steps: Array) -> Array:
        left = rest(steps)
        return np.concatenate([left - shapes @ (solve @ left), _PRIOR * steps])

    best = least_squares(
        misses,
        np.zeros(len(_SEARCHED)),
        bounds=(-_FARTHEST, _FARTHEST),
        x_scale=0.1,
        diff_step=1e-3,
        max_nfev=40,
    )
    left = rest(best.x)
    missed = left - shapes @ (solve @ left)
    beyond = np.concatenate(
        [
            scale * each.course.smooth(each.force - each.course.modelled(model))
            for each, scale in zip(lessons, scales, strict=True)
        ]
    )
    return LessonFit(
        model=model,
        tau=tau,
        friction=friction(best.x),
        weights=solve @ left / sizes,
        explained=1.0 - float(np.var(missed) / np.var(beyond)),
    )
