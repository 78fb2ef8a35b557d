"""Driving the kernel directly: parameters of lanes, reference motions, runs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.control.compensation import Compensation
from motionlab.control.filters import PASS
from motionlab.control.position import PositionController
from motionlab.force_sharing.functions import CLOSED_FORM, PARAMETERS, SharingParameters
from motionlab.force_sharing.share import ForceModel, Sharing
from motionlab.kernel.law_calls import law_number
from motionlab.kernel.layout import (
    INPUT_ROWS,
    PARAMETER_ROWS,
    SAMPLE_ROWS,
    STATE_ROWS,
    Inputs,
    LawParameters,
    Limits,
    Parameters,
    column,
    state_row,
)
from motionlab.kernel.tick import run_ticks
from motionlab.lanes import WIDTH
from motionlab.laws import LAWS
from motionlab.plant.current import Amplifiers
from motionlab.plant.encoder import Encoder, Subdivision
from motionlab.plant.friction import LuGre
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.mechanics import Mechanics
from motionlab.plant.resonance import sampled
from motionlab.plant.table_map import ANALYTIC, MotorMap
from motionlab.telemetry.channels import Sample
from motionlab.timing import PLANT_STEP as H
from tests import nominal_motor
from tests.nominal_motor import CONTROL_PERIOD, Axis

Array = NDArray[np.float64]

IDEAL: dict[str, Any] = {"controller.ideal_force": 1.0, "encoder.resolution": 0.0}
"""Changes to a lane: the plant gives any force commanded, the encoder is exact."""


_USUAL = {
    "law.from_reference": 0.0,
    "law.z_limit": math.inf,
    "law.gain": 40.0,
    "law.alpha": nominal_motor.low_pass(30.0),
    "law.regularisation": 0.4,
    "law.k_d_share": 0.0,
}


def lane(axis: Axis, law: str = "off", changes: Mapping[str, float] | None = None) -> Parameters:
    """Return the parameters of one axis of the nominal motor.

    Parameters
    ----------
    axis : Axis
        Which axis; the controller's model is the same.
    law : str
        Name of its law; any but ``off`` is also switched on.
    changes : mapping of str to float, optional
        Fields to change, such as ``{"encoder.resolution": 0.0}``; ``law.gain`` is one of the
        law's own.
    """
    friction = LuGre(axis.sigma_0, axis.sigma_1, axis.sigma_2, axis.F_c, axis.F_s, axis.v_s)
    formula = AnalyticMap(
        tau=nominal_motor.POLE_PITCH,
        offset=0.0,
        F_pk=nominal_motor.PEAK_FORCE,
        N_pk=nominal_motor.PEAK_NORMAL_FORCE,
        I_pk=nominal_motor.PEAK_CURRENT,
        I_knee=nominal_motor.KNEE_CURRENT,
        h_2=0.0,
        h_3=0.0,
    )
    force_map = MotorMap(formula, ANALYTIC)
    sharing = Sharing(CLOSED_FORM, -1.0, -1.0, nominal_motor.PEAK_CURRENT)
    defaults = (each.default for each in PARAMETERS.values())
    parameters = Parameters(
        friction=friction,
        force_map=force_map,
        amplifiers=Amplifiers(
            half_step=math.exp(-2.0 * math.pi * nominal_motor.CURRENT_BANDWIDTH * 0.5 * H),
            gain_a=1.0,
            gain_b=1.0,
            gain_c=1.0,
            offset_a=0.0,
            offset_b=0.0,
            offset_c=0.0,
            limit=nominal_motor.PEAK_CURRENT,
        ),
        encoder=Encoder(
            resolution=nominal_motor.ENCODER_COUNT, sde_amplitude=0.0, sde_period=20e-6
        ),
        mechanics=Mechanics(
            M=axis.M,
            stop=nominal_motor.STROKE["x" if axis.M == nominal_motor.X.M else "y"] + 1e-3,
            stop_stiffness=1e7,
            stop_damping=1e4,
        ),
        resonance=sampled(frequency=150.0, damping=0.02, coupling=0.0, mass=axis.M, h=H),
        controller=PositionController(
            k_p=axis.k_p,
            k_d=axis.k_d,
            M=axis.M,
            force_limit=nominal_motor.FORCE_LIMIT,
            feedforward=0.0,
            observer=0.0,
            observer_alpha=nominal_motor.low_pass(30.0),
            delay=0.0,
            ideal_force=0.0,
            learnt=0.0,
        ),
        notch=PASS,
        filter_1=PASS,
        filter_2=PASS,
        filter_3=PASS,
        compensation=Compensation(law_number(law), float(LAWS[law].adds)),
        model_friction=friction,
        model_subdivision=Subdivision(sine=0.0, cosine=0.0, period=20e-6),
        force_model=ForceModel(force_map, sharing, SharingParameters(*defaults)),
        limits=Limits(error=0.02),
        law=LawParameters(*[0.0] * len(LawParameters._fields)),
    )
    own = [f"law.{name}" for name in LAWS[law].Parameters._fields]
    rows = {f"law.p_{k}": _USUAL[name] for k, name in enumerate(own)}
    rows |= {f"law.p_{own.index(k)}" if k in own else k: v for k, v in (changes or {}).items()}
    return changed(parameters, rows)


def changed(record: Any, changes: Mapping[str, float]) -> Any:
    """Return `Parameters`, or a group of them, with fields such as ``mechanics.M`` replaced."""
    for key, value in changes.items():
        group, _, field = key.partition(".")
        new = changed(getattr(record, group), {field: value}) if field else value
        record = record._replace(**{group: new})
    return record


def off_and_observer(
    x: Axis, y: Axis, changes: Mapping[str, float] | None = None
) -> list[Parameters]:
    """Return eight lanes: A (off) and B (observer) on both axes, twice."""
    pair = [lane(axis, law, changes) for law in ("off", "lugre-observer") for axis in (x, y)]
    return pair * 2


def rows(lanes: Sequence[Parameters]) -> Array:
    """Return the parameter array of eight lanes, shape (PARAMETER_ROWS, WIDTH)."""
    columns = [column(each) for each in lanes]
    array = np.ascontiguousarray(np.array(columns, dtype=np.float64).T)
    assert array.shape == (PARAMETER_ROWS, WIDTH)
    return array


def at_rest(place: Iterable[float]) -> Array:
    """Return the state of movers at rest at `place`, x and y; shape (STATE_ROWS, WIDTH)."""
    state = np.zeros((STATE_ROWS, WIDTH))
    state[state_row("plant.p")] = np.tile(tuple(place), WIDTH // 2)
    state[state_row("failed")] = -1.0
    return state


def inputs(motion: Array) -> Array:
    """Return the kernel's inputs for a `motion` of shape (ticks, 3, 2): p, v, a of x and y."""
    array = np.zeros((len(motion), INPUT_ROWS, 2))
    for row, name in enumerate(("p_ref", "v_ref", "a_ref")):
        array[:, Inputs._fields.index(name)] = motion[:, row]
    return array


def circle(ticks: int) -> Array:
    """Return a circle about mid-stroke, eased in over half a period; shape (ticks, 3, 2)."""
    w = 2.0 * math.pi * nominal_motor.CIRCLE_FREQUENCY
    t = np.arange(ticks) * CONTROL_PERIOD
    lead = 0.5 / nominal_motor.CIRCLE_FREQUENCY
    s = np.minimum(t / lead, 1.0)
    phase = w * np.where(t < lead, lead * s**4 * (2.5 - 3.0 * s + s**2), t - 0.5 * lead)
    rate = w * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    growth = w * np.where(t < lead, 30.0 * s**2 * (1.0 - s) ** 2 / lead, 0.0)
    unit = np.stack((np.cos(phase), np.sin(phase)), axis=1)
    along = np.stack((-unit[:, 1], unit[:, 0]), axis=1)
    v = along * rate[:, None]
    a = along * growth[:, None] - unit * (rate**2)[:, None]
    return nominal_motor.CIRCLE_RADIUS * np.stack((unit, v, a), axis=1)


def trapezoid(ticks: int) -> Array:
    """Return 290 mm on y at 0.15 m/s and 1.6 m/s^2 after 50 ms at rest; shape (ticks, 3, 2)."""
    v_max, a_max, length, wait = 0.15, 1.6, 0.29, 0.05
    t = np.maximum(np.arange(ticks) * CONTROL_PERIOD - wait, 0.0)
    rise = v_max / a_max
    end = length / v_max + rise
    late = np.clip(end - t, 0.0, rise)  # time left, while braking
    early = np.minimum(t, rise)
    cruise = np.clip(t - rise, 0.0, end - 2.0 * rise)
    motion = np.zeros((ticks, 3, 2))
    covered = 0.5 * a_max * early**2 + v_max * cruise
    braked = 0.5 * a_max * (rise**2 - late**2)
    motion[:, 0, 1] = -0.5 * length + covered + braked
    motion[:, 1, 1] = a_max * np.minimum(early, late)
    accelerating = (t > 0.0) & (t < rise)
    braking = (t > end - rise) & (t < end)
    motion[:, 2, 1] = a_max * (accelerating.astype(float) - braking.astype(float))
    return motion


def run(lanes: Array, state: Array, driven: Array) -> NDArray[np.float32]:
    """Advance `state` over all of `driven`; return samples of shape (ticks, SAMPLE_ROWS, WIDTH)."""
    samples = np.empty((len(driven), SAMPLE_ROWS, WIDTH), dtype=np.float32)
    run_ticks(lanes, state, driven, samples)
    return samples


def positions(lanes: Array, state: Array, driven: Array) -> Array:
    """Advance `state`; return positions after each tick in double precision, (ticks, WIDTH)."""
    row = state_row("plant.p")
    result = np.empty((len(driven), WIDTH))
    for k in range(len(driven)):
        run(lanes, state, driven[k : k + 1])
        result[k] = state[row]
    return result


def channel(samples: NDArray[np.float32], name: str) -> Array:
    """Return one channel of `samples` in double precision, shape (ticks, WIDTH)."""
    return samples[:, Sample._fields.index(name)].astype(np.float64)
