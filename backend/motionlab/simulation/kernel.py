"""The compiled kernel: what happens in one control period, for eight lanes side by side."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD, PLANT_STEP, SUBSTEPS
from motionlab.control.compensation import (
    Compensation,
    adaptation,
    estimate_friction,
    residual_force,
)
from motionlab.control.force_sharing import share_force
from motionlab.control.position import (
    PositionController,
    disturbance_estimate,
    estimate_motion,
    pd_force,
)
from motionlab.lanes import (
    Lanes,
    axes_at,
    compiled,
    flush_subnormals,
    pack,
    record,
    restore_mode,
    select,
    unpack,
)
from motionlab.lanes.functions import clip
from motionlab.plant.current import Amplifiers, half_step, settled_current
from motionlab.plant.encoder import Encoder, measure
from motionlab.plant.friction import LuGre, friction_force
from motionlab.plant.magnetics import ForceMap, Phases, normal_force, thrust
from motionlab.plant.mechanics import Mechanics, advance, end_stop_force
from motionlab.telemetry.channels import Sample

T_S = CONTROL_PERIOD
H = PLANT_STEP


class Inputs(NamedTuple):
    """What acts on all variants of a run alike: one value an axis and tick."""

    p_ref: Lanes  # m
    v_ref: Lanes  # m/s
    a_ref: Lanes  # m/s^2
    load: Lanes  # external load force f_d, N
    encoder_noise: Lanes  # m
    current_a: Lanes  # ripple and noise of the currents, A
    current_b: Lanes
    current_c: Lanes


class State(NamedTuple):
    """Everything a lane remembers from one tick to the next."""

    p: Lanes  # plant: position, m
    v: Lanes  # velocity, m/s
    z: Lanes  # bristle state, m
    i_a: Lanes  # phase currents, A
    i_b: Lanes
    i_c: Lanes
    p_last: Lanes  # controller: last measured position, m
    v_last: Lanes  # and velocity, m/s
    e_last: Lanes  # last following error, m
    z_hat: Lanes  # bristle estimate, m
    residual: Lanes  # filtered force balance, N
    d: Lanes  # disturbance estimate, N
    f_acting: Lanes  # in effect over the last period: realised force, N
    f_hat_acting: Lanes  # the friction estimate it was made with, N
    f_added_acting: Lanes  # the part of the estimate that was added, N
    K_acting: Lanes  # m/s
    f_pending: Lanes  # the same, computed but not yet in effect (loop delay)
    f_hat_pending: Lanes
    f_added_pending: Lanes
    K_pending: Lanes
    c_a_pending: Lanes  # current commands not yet in effect, A
    c_b_pending: Lanes
    c_c_pending: Lanes
    age: Lanes  # ticks since the start
    failed: Lanes  # tick at which the lane diverged; -1 while it has not


class Limits(NamedTuple):
    """Limits of each lane."""

    current: Lanes  # largest current command, A
    error: Lanes  # following error beyond which the lane has diverged, m


class Parameters(NamedTuple):
    """The parameter groups of a lane; the plant's truth and the controller's model are apart."""

    friction: LuGre
    force_map: ForceMap
    amplifiers: Amplifiers
    encoder: Encoder
    mechanics: Mechanics
    controller: PositionController
    compensation: Compensation
    model_friction: LuGre
    model_force_map: ForceMap
    limits: Limits


_GROUPS: tuple[type, ...] = (
    LuGre,
    ForceMap,
    Amplifiers,
    Encoder,
    Mechanics,
    PositionController,
    Compensation,
    LuGre,
    ForceMap,
    Limits,
)
_SIZES = [len(group._fields) for group in _GROUPS]
(_R0, _R1, _R2, _R3, _R4, _R5, _R6, _R7, _R8, _R9, PARAMETER_ROWS) = (
    sum(_SIZES[:i]) for i in range(len(_SIZES) + 1)
)
FORCE_LIMIT_ROW = _R5 + PositionController._fields.index("force_limit")
STATE_ROWS = len(State._fields)
INPUT_ROWS = len(Inputs._fields)
SAMPLE_ROWS = len(Sample._fields)


@compiled
def tick(par: Parameters, s: State, at: Inputs) -> tuple[State, Sample]:
    """Return the state one control period later, and the sample taken at the period's start."""
    controller, law, model = par.controller, par.compensation, par.model_friction
    first = s.age == 0.0

    # measure
    p_meas = measure(par.encoder, s.p, at.encoder_noise)
    motion = estimate_motion(at.p_ref, p_meas, s.p_last, s.v_last, s.e_last, first, T_S)

    # compensate
    u = pd_force(controller, motion)
    inertia = controller.M * motion.a
    residual = residual_force(
        law, model, s.residual, inertia, s.f_acting - s.f_hat_acting, s.K_acting
    )
    residual = select(first, 0.0, residual)
    v_hat = select(law.from_reference > 0.0, at.v_ref, motion.v)
    K = adaptation(law, model, motion, v_hat, u, controller.k_d, inertia, residual)
    estimate = estimate_friction(law, model, s.z_hat, v_hat, K, residual, T_S)
    added = select(law.enabled > 0.0, estimate.force, 0.0)

    # control
    d = disturbance_estimate(controller, s.d, s.f_acting - s.f_added_acting, motion.a)
    d = select(first, 0.0, d)
    wanted = u + added
    wanted = wanted + select(controller.feedforward > 0.0, controller.M * at.a_ref, 0.0)
    wanted = wanted + select(controller.observer > 0.0, d, 0.0)
    f_command = clip(wanted, -controller.force_limit, controller.force_limit)

    # share
    share = share_force(par.model_force_map, par.limits.current, p_meas, f_command)
    ideal = controller.ideal_force > 0.0
    realised = select(ideal, f_command, share.force)
    late = controller.delay > 0.0
    f_acting = select(late, s.f_pending, realised)
    f_hat_acting = select(late, s.f_hat_pending, estimate.force)
    f_added_acting = select(late, s.f_added_pending, added)
    K_acting = select(late, s.K_pending, K)
    command = Phases(
        select(late, s.c_a_pending, share.current.a),
        select(late, s.c_b_pending, share.current.b),
        select(late, s.c_c_pending, share.current.c),
    )

    # record
    current = Phases(s.i_a, s.i_b, s.i_c)
    force = select(ideal, f_acting, thrust(par.force_map, s.p, current))
    f_friction = friction_force(par.friction, s.v, s.z)
    stop = end_stop_force(par.mechanics, s.p, s.v)
    sample = Sample(
        position=s.p,
        position_measured=p_meas,
        following_error=motion.error,
        velocity=s.v,
        velocity_measured=motion.v,
        acceleration=(force + stop - at.load - f_friction) / par.mechanics.M,
        pd_force=u,
        friction=f_friction,
        friction_estimate=estimate.force,
        bristle=s.z,
        bristle_estimate=estimate.z,
        K=K,
        disturbance_estimate=d,
        force_command=f_command,
        force_realised=f_acting,
        thrust=force,
        normal_force=select(ideal, 0.0, normal_force(par.force_map, s.p, current)),
        current_a=s.i_a,
        current_b=s.i_b,
        current_c=s.i_c,
        current_command_a=share.current.a,
        current_command_b=share.current.b,
        current_command_c=share.current.c,
        force_saturated=select(abs(f_command) >= controller.force_limit, 1.0, 0.0),
        current_saturated=select(share.limited & ~ideal, 1.0, 0.0),
    )

    # drive and move
    disturbance = Phases(at.current_a, at.current_b, at.current_c)
    target = settled_current(par.amplifiers, command, disturbance)
    p, v, z = s.p, s.v, s.z
    for _ in range(SUBSTEPS):
        middle = half_step(par.amplifiers, current, target)
        p_mid = p + (0.5 * H) * v
        force = select(ideal, f_acting, thrust(par.force_map, p_mid, middle))
        net = force - at.load + end_stop_force(par.mechanics, p_mid, v)
        p, v, z = advance(par.mechanics, par.friction, p, v, z, net, H)
        current = half_step(par.amplifiers, middle, target)

    healthy = (abs(motion.error) <= par.limits.error) & (abs(f_command) < np.inf)
    state = State(
        p=p,
        v=v,
        z=z,
        i_a=current.a,
        i_b=current.b,
        i_c=current.c,
        p_last=p_meas,
        v_last=motion.v,
        e_last=motion.error,
        z_hat=estimate.z,
        residual=residual,
        d=d,
        f_acting=f_acting,
        f_hat_acting=f_hat_acting,
        f_added_acting=f_added_acting,
        K_acting=K_acting,
        f_pending=realised,
        f_hat_pending=estimate.force,
        f_added_pending=added,
        K_pending=K,
        c_a_pending=share.current.a,
        c_b_pending=share.current.b,
        c_c_pending=share.current.c,
        age=s.age + 1.0,
        failed=select((s.failed < 0.0) & ~healthy, s.age, s.failed),
    )
    return state, sample


@numba.njit(error_model="numpy", nogil=True, cache=True)
def run_ticks(
    parameters: NDArray[np.float64],
    state: NDArray[np.float64],
    inputs: NDArray[np.float64],
    samples: NDArray[np.float32],
) -> None:
    """Advance eight lanes by ``len(inputs)`` control periods.

    Parameters
    ----------
    parameters : ndarray, shape (PARAMETER_ROWS, WIDTH)
        The groups of `Parameters`, one after another.
    state : ndarray, shape (STATE_ROWS, WIDTH)
        Fields of `State`; overwritten by the state at the end.
    inputs : ndarray, shape (ticks, INPUT_ROWS, 2)
        Fields of `Inputs` for axis x and axis y; even lanes are x, odd lanes y.
    samples : ndarray of float32, shape (ticks, SAMPLE_ROWS, WIDTH)
        Overwritten by the samples of each tick.
    """
    par = Parameters(
        unpack(LuGre, parameters, _R0),
        unpack(ForceMap, parameters, _R1),
        unpack(Amplifiers, parameters, _R2),
        unpack(Encoder, parameters, _R3),
        unpack(Mechanics, parameters, _R4),
        unpack(PositionController, parameters, _R5),
        unpack(Compensation, parameters, _R6),
        unpack(LuGre, parameters, _R7),
        unpack(ForceMap, parameters, _R8),
        unpack(Limits, parameters, _R9),
    )
    s = unpack(State, state, 0)
    mode = flush_subnormals()
    for k in range(inputs.shape[0]):
        s, sample = tick(par, s, axes_at(Inputs, inputs, k))
        record(sample, samples, k)
    restore_mode(mode)
    pack(s, state)
