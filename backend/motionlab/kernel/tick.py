"""The compiled kernel: what happens in one control period, for eight lanes side by side."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD, PLANT_STEP, SUBSTEPS
from motionlab.control.compensation import (
    adaptation,
    estimate_friction,
    residual_force,
)
from motionlab.control.notch import notched
from motionlab.control.position import (
    disturbance_estimate,
    estimate_motion,
    pd_force,
)
from motionlab.force_sharing.functions import share_by_law
from motionlab.kernel.layout import (
    Inputs,
    Parameters,
    State,
    groups,
    reads_tables,
)
from motionlab.lanes import (
    axes_at,
    compiled,
    flush_subnormals,
    pack,
    record,
    restore_mode,
    select,
    unpack,
)
from motionlab.lanes.bank import TABLES
from motionlab.lanes.functions import clip
from motionlab.plant.current import half_step, settled_current
from motionlab.plant.encoder import measure
from motionlab.plant.friction import friction_force
from motionlab.plant.magnetics import Phases
from motionlab.plant.mechanics import advance, end_stop_force
from motionlab.plant.resonance import ring
from motionlab.plant.table_map import normal_force_of, thrust_of
from motionlab.telemetry.channels import Sample

T_S = CONTROL_PERIOD
H = PLANT_STEP


@compiled
def tick(
    par: Parameters, s: State, at: Inputs, tables: NDArray[np.float64] | None
) -> tuple[State, Sample]:
    """Return the state one control period later, and the sample taken at the period's start.

    Without `tables` every lane has analytic maps and shares its force by the closed form.
    """
    controller, law, model = par.controller, par.compensation, par.model_friction
    first = s.age == 0.0

    # measure
    p_meas = measure(par.encoder, s.p + s.y, at.encoder_noise)
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
    asked = select(controller.observer > 0.0, d, 0.0)
    wanted, n_1, n_2 = notched(par.notch, wanted + asked, u + asked, s.n_1, s.n_2)
    f_command = clip(wanted, -controller.force_limit, controller.force_limit)

    # share
    share = share_by_law(
        par.model_force_map,
        par.model_table,
        par.sharing,
        tables,
        par.limits.current,
        p_meas,
        f_command,
    )
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
    force = select(ideal, f_acting, thrust_of(par.force_map, par.table, tables, s.p, current))
    attraction = normal_force_of(par.force_map, par.table, tables, s.p, current)
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
        normal_force=select(ideal, 0.0, attraction),
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
    p, v, z, y, y_rate = s.p, s.v, s.z, s.y, s.y_rate
    for _ in range(SUBSTEPS):
        middle = half_step(par.amplifiers, current, target)
        p_mid = p + (0.5 * H) * v
        force = select(ideal, f_acting, thrust_of(par.force_map, par.table, tables, p_mid, middle))
        net = force - at.load + end_stop_force(par.mechanics, p_mid, v)
        p, v, z = advance(par.mechanics, par.friction, p, v, z, net, H)
        y, y_rate = ring(par.resonance, y, y_rate, force)
        current = half_step(par.amplifiers, middle, target)

    healthy = (abs(motion.error) <= par.limits.error) & (abs(f_command) < np.inf)
    state = State(
        p=p,
        v=v,
        z=z,
        y=y,
        y_rate=y_rate,
        i_a=current.a,
        i_b=current.b,
        i_c=current.c,
        p_last=p_meas,
        v_last=motion.v,
        e_last=motion.error,
        z_hat=estimate.z,
        residual=residual,
        d=d,
        n_1=n_1,
        n_2=n_2,
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


def run_ticks(
    parameters: NDArray[np.float64],
    state: NDArray[np.float64],
    inputs: NDArray[np.float64],
    samples: NDArray[np.float32],
    tabled: list[bool] | None = None,
) -> None:
    """Advance eight lanes by ``len(inputs)`` control periods.

    Lanes that read no table run in a kernel of their own, and so give the same bits whatever lanes
    are beside them: where both kinds meet, all eight run twice, and each lane's result is kept of
    the run that is its own.

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
    tabled : list of bool, optional
        `reads_tables` of `parameters`, for callers with few ticks at a time.
    """
    tabled = reads_tables(parameters) if tabled is None else tabled
    if not any(tabled):
        _run_ticks(parameters, state, inputs, samples, None)
    elif all(tabled):
        _run_ticks(parameters, state, inputs, samples, TABLES.values)
    else:
        other_state, other_samples = state.copy(), np.empty_like(samples)
        _run_ticks(parameters, state, inputs, samples, None)
        _run_ticks(parameters, other_state, inputs, other_samples, TABLES.values)
        state[:, tabled] = other_state[:, tabled]
        samples[:, :, tabled] = other_samples[:, :, tabled]


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _run_ticks(
    parameters: NDArray[np.float64],
    state: NDArray[np.float64],
    inputs: NDArray[np.float64],
    samples: NDArray[np.float32],
    tables: NDArray[np.float64] | None,
) -> None:
    s = unpack(State, state, 0)
    par = groups(parameters, s.p)
    mode = flush_subnormals()
    for k in range(inputs.shape[0]):
        s, sample = tick(par, s, axes_at(Inputs, inputs, k), tables)
        record(sample, samples, k)
    restore_mode(mode)
    pack(s, state)
