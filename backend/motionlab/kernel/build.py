"""Kernel inputs of a scenario: lane parameters, initial state, motion limits."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import (
    CompensationConfig,
    ControllerConfig,
    ModelConfig,
    SharingConfig,
)
from motionlab.config.planar import AXES
from motionlab.config.plant import (
    AmplifierConfig,
    AxisConfig,
    PlantConfig,
    ResonanceConfig,
)
from motionlab.config.scenario import Scenario
from motionlab.control.compensation import Compensation
from motionlab.control.filters import sampled_filter, sampled_notch
from motionlab.control.position import PositionController
from motionlab.effects import EFFECTS
from motionlab.force_sharing.functions import CLOSED_FORM
from motionlab.force_sharing.ripple import reachable_over
from motionlab.force_sharing.share import ForceModel
from motionlab.kernel.effect_calls import effect_numbers
from motionlab.kernel.force_maps import force_model, map_lanes
from motionlab.kernel.law_calls import law_number
from motionlab.kernel.layout import (
    PARAMETER_ROWS,
    STATE_ROWS,
    LawParameters,
    Limits,
    Parameters,
    column,
    state_row,
)
from motionlab.lanes import WIDTH
from motionlab.lanes.bank import TABLES
from motionlab.laws import LAWS
from motionlab.plant.current import Amplifiers
from motionlab.plant.encoder import Encoder, Subdivision
from motionlab.plant.friction import LuGre, steady_friction
from motionlab.plant.magnetics import force_fraction, thrust_shape
from motionlab.plant.mechanics import Mechanics
from motionlab.plant.resonance import Resonance, sampled
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP
from motionlab.trajectories.motion_limits import MotionLimits

LANES_PER_VARIANT = len(AXES)
VARIANTS_PER_BLOCK = WIDTH // LANES_PER_VARIANT

_POSITIONS_PER_PITCH = 361


def lane_parameters(scenario: Scenario) -> NDArray[np.float64]:
    """Return the parameters of every lane of a scenario.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario.

    Returns
    -------
    ndarray, shape (blocks, PARAMETER_ROWS, WIDTH)
        Lane ``2 i + a`` holds axis a of variant i; lanes left over repeat the first variant. The
        tables that it refers to stay in place as long as this array.
    """
    with TABLES.lease() as lease:
        columns = [
            column
            for variant in scenario.variants.values()
            for column in mover_parameters(scenario, variant.controller)
        ]
    blocks = -(-len(columns) // WIDTH)
    while len(columns) < blocks * WIDTH:
        columns.append(columns[len(columns) % LANES_PER_VARIANT])
    lanes = np.array(columns, dtype=np.float64).reshape(blocks, WIDTH, PARAMETER_ROWS)
    parameters = np.array(lanes.transpose(0, 2, 1), order="C")  # no view: it keeps the lease
    lease.keep_with(parameters)
    return parameters


def mover_parameters(scenario: Scenario, controller: ControllerConfig) -> list[list[float]]:
    """Return the lane parameters of both axes of one variant, shape (2, PARAMETER_ROWS)."""
    axes = ((axis, getattr(scenario.plant, axis)) for axis in AXES)
    return [
        column(lane(scenario, controller, axis), effect_numbers(plant.effect_lanes()))
        for axis, plant in axes
    ]


def initial_state(
    blocks: int, start: tuple[float, float], *, width: int = WIDTH
) -> NDArray[np.float64]:
    """Return the state of movers at rest at `start`, m; shape (blocks, STATE_ROWS, `width`)."""
    state = np.zeros((blocks, STATE_ROWS, width))
    state[:, state_row("plant.p")] = np.tile(start, width // LANES_PER_VARIANT)
    state[:, state_row("failed")] = -1.0
    return state


def motion_limits(  # noqa: PLR0913 - what decides, and nothing else
    plant: PlantConfig,
    model: ModelConfig,
    *,
    sharing: SharingConfig,
    force_limit: float,
    current_limit: float,
    reserve: float,
) -> MotionLimits:
    """Return the motion limits of a motor under a controller's model and limits.

    The available thrust is the largest command, up to the force limit, that the controller's
    force-sharing function realises in full at a position in the pole pitch; of it a share
    `reserve` is left to feedback.
    """
    axes = (plant.x, plant.y)
    with TABLES.lease():
        models = [
            force_model(axis.force_map, sharing, current_limit) for axis in (model.x, model.y)
        ]
        ranges = [np.minimum(_linear_range(each), force_limit) for each in models]

    def friction(axis: int, v: NDArray[np.float64]) -> NDArray[np.float64]:
        f = axes[axis].friction.parameters()
        force = steady_friction(v, f.F_c, f.F_s, f.v_s, f.sigma_2)
        for name, par in axes[axis].effect_lanes():
            if (level := EFFECTS[name].level) is not None:
                force = force + level(par, v)
        return force

    if plant.force == "ideal":
        ranges = [np.full_like(each, force_limit) for each in ranges]
    tables = [(1.0 - reserve) * each for each in ranges]

    def available(
        axis: int, position: NDArray[np.float64], sign: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        table = tables[axis]
        turns = position / models[axis].map.formula.tau
        turns = (turns - np.floor(turns)) * (table.shape[1] - 1)
        low = turns.astype(np.int64)
        rows = (sign > 0.0).astype(np.int64)
        first, second = table[rows, low], table[rows, np.minimum(low + 1, table.shape[1] - 1)]
        return first + (second - first) * (turns - low)

    return MotionLimits(
        stroke=(plant.x.stroke, plant.y.stroke),
        v_max=(plant.x.velocity_max, plant.y.velocity_max),
        a_max=(plant.x.acceleration_max, plant.y.acceleration_max),
        mass=(plant.x.mass, plant.y.mass),
        friction=friction,
        available_thrust=available,
        sure_thrust=(float(tables[0].min()), float(tables[1].min())),
        reserve=reserve,
    )


def _linear_range(model: ForceModel) -> NDArray[np.float64]:
    """Return the largest commands that are realised in full over a pole pitch, backward first."""
    if model.map.table.thrust >= 0.0 or max(model.sharing.inverse, model.sharing.table) >= 0.0:
        return _searched_range(model)  # tables change under their place
    return _untabled_range(model)


@functools.lru_cache(maxsize=64)
def _untabled_range(model: ForceModel) -> NDArray[np.float64]:
    if model.sharing.law == CLOSED_FORM:
        return _closed_form_range(model)
    return _searched_range(model)


def _searched_range(model: ForceModel) -> NDArray[np.float64]:
    pitch = _pitch(model)
    return np.array(
        [reachable_over(model, position=pitch, forward=forward) for forward in (False, True)]
    )


def _closed_form_range(model: ForceModel) -> NDArray[np.float64]:
    """Return the same by its formula, not compiled: a fresh machine's first curves wait for it.

    The phase that pulls most is the first to reach its current limit, at
    ``abs(f) = F(i_max) sum x_j**2 / max x_j`` with x_j as in `share_in_closed_form`.
    """
    formula = model.map.formula
    shapes = np.array(thrust_shape(formula, _pitch(model)))
    pulls = np.maximum([-shapes, shapes], 0.0)  # (2, phases, n)
    most = formula.F_pk * force_fraction(formula, model.sharing.current_limit)
    return most * (pulls**2).sum(axis=1) / pulls.max(axis=1)


def _pitch(model: ForceModel) -> NDArray[np.float64]:
    return np.linspace(0.0, model.map.formula.tau, _POSITIONS_PER_PITCH)


def lane(scenario: Scenario, controller: ControllerConfig, axis: str) -> Parameters:
    """Return the parameter groups of one axis of one variant, as plain numbers."""
    plant: AxisConfig = getattr(scenario.plant, axis)
    model = getattr(controller.model, axis)
    gains = getattr(controller, axis)
    compensation = controller.compensation
    enabled = compensation.enabled and LAWS[compensation.law].adds and model.friction.enabled
    return Parameters(
        friction=plant.friction.parameters(),
        force_map=map_lanes(plant.force_map),
        amplifiers=_amplifiers(plant.amplifiers),
        encoder=Encoder(
            resolution=plant.encoder.resolution,
            sde_amplitude=plant.encoder.sde_amplitude,
            sde_period=plant.encoder.sde_period,
        ),
        mechanics=Mechanics(
            M=plant.mass,
            stop=plant.stroke + plant.stop_distance,
            stop_stiffness=plant.stop_stiffness,
            stop_damping=plant.stop_damping,
        ),
        resonance=_resonance(plant.resonance, plant.mass),
        controller=_position_controller(scenario, controller, axis),
        notch=sampled_notch(**gains.notch.model_dump()),
        filter_1=sampled_filter(**gains.filter_1.model_dump()),
        filter_2=sampled_filter(**gains.filter_2.model_dump()),
        filter_3=sampled_filter(**gains.filter_3.model_dump()),
        compensation=Compensation(law_number(compensation.law), float(enabled)),
        model_friction=model.friction.parameters(),
        model_subdivision=Subdivision(
            sine=model.subdivision.sine,
            cosine=model.subdivision.cosine,
            period=model.subdivision.period,
        ),
        force_model=force_model(model.force_map, controller.sharing, controller.current_limit),
        limits=Limits(error=scenario.divergence_error),
        law=_law(compensation, model.friction.parameters()),
    )


def _position_controller(
    scenario: Scenario, controller: ControllerConfig, axis: str
) -> PositionController:
    gains = getattr(controller, axis)
    observer = controller.disturbance_observer
    return PositionController(
        k_p=gains.k_p,
        k_d=gains.k_d,
        M=getattr(controller.model, axis).mass,
        force_limit=controller.force_limit,
        feedforward=float(controller.feedforward),
        observer=float(observer.enabled),
        observer_alpha=_alpha(observer.bandwidth),
        delay=float(controller.delay),
        ideal_force=float(scenario.plant.force == "ideal"),
        learnt=float(controller.learnt),
    )


def _law(config: CompensationConfig, model: LuGre) -> LawParameters:
    law = LAWS[config.law]
    own = law.lane_parameters(config.values(), model)
    return LawParameters(*own, *[0.0] * (len(LawParameters._fields) - len(own)))


def _amplifiers(config: AmplifierConfig) -> Amplifiers:
    half = 0.5 * PLANT_STEP
    rest = 0.0 if config.bandwidth is None else math.exp(-2.0 * math.pi * config.bandwidth * half)
    return Amplifiers(rest, *config.gain, *config.offset, config.limit)


def _resonance(config: ResonanceConfig, mass: float) -> Resonance:
    return sampled(
        frequency=config.frequency,
        damping=config.damping,
        coupling=config.coupling,
        mass=mass,
        h=PLANT_STEP,
    )


def _alpha(bandwidth: float) -> float:
    """Return the coefficient of a first-order low-pass filter of `bandwidth`, Hz."""
    return 1.0 - math.exp(-2.0 * math.pi * bandwidth * CONTROL_PERIOD)
