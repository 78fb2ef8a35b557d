"""One control period: the kernel.

A period has two halves: `control`, without access to the machine, and
`motionlab.kernel.move.move`, the machine under the command in effect.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.control.filters import filtered
from motionlab.control.position import Last, disturbance_estimate, estimate_motion, pd_force
from motionlab.force_sharing.share import share_force
from motionlab.kernel.effect_calls import Effects
from motionlab.kernel.law_calls import (
    Laws,
    enter_laws,
    estimate_friction,
    laws_of,
    leave_laws,
    look_ahead,
    record_laws,
)
from motionlab.kernel.layout import (
    Command,
    ControllerState,
    Inputs,
    Parameters,
    PlantState,
    State,
    groups,
    read_state,
    reads_tables,
    write_state,
)
from motionlab.kernel.motion import Motion
from motionlab.kernel.move import move, move_resisted, resisted_now
from motionlab.lanes import (
    Lanes,
    Mask,
    axes_at,
    cached,
    compiled,
    flush_subnormals,
    record,
    restore_mode,
    select,
    unpack,
)
from motionlab.lanes.bank import TABLES
from motionlab.lanes.functions import clip
from motionlab.laws.law import Estimate
from motionlab.plant.encoder import corrected, measure
from motionlab.plant.friction import friction_force
from motionlab.plant.magnetics import Phases
from motionlab.plant.mechanics import end_stop_force
from motionlab.plant.table_map import normal_force_of, thrust_of
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD


class EncoderSample(NamedTuple):
    """What the encoder reads."""

    p: Lanes  # m


class Signals(NamedTuple):
    """Intermediate signals of the controller."""

    error: Lanes  # following error, m
    v: Lanes  # velocity by differences of the encoder, m/s
    u: Lanes  # PD force, N
    z_hat: Lanes  # bristle estimate, m
    d: Lanes  # disturbance estimate, N
    f_command: Lanes  # force command within its limit, N
    limited: Mask  # some phase is at its current limit


@compiled
def observe_motion(par: Parameters, s: State, at: Inputs, p_meas: Lanes) -> Any:
    """Return `Motion`: what the controller knows, and its PD force."""
    memory, acting = s.memory, s.acting
    p_meas = corrected(par.model_subdivision, p_meas)
    last = Last(memory.p_last, memory.v_last, memory.e_last)
    motion = estimate_motion(at.p_ref, p_meas, last, s.age == 0.0)
    return Motion(
        p_ref=at.p_ref,
        v_ref=at.v_ref,
        a_ref=at.a_ref,
        p=p_meas,
        v=motion.v,
        a=motion.a,
        error=motion.error,
        error_rate=motion.error_rate,
        u=pd_force(par.controller, motion),
        f_acting=acting.force,
        estimate_acting=acting.estimate,
        K_acting=acting.K,
        age=s.age,
    )


@compiled
def command(  # noqa: PLR0913, PLR0917 - what a command depends on
    par: Parameters,
    s: State,
    motion: Any,
    estimate: Estimate,
    tables: NDArray[np.float64] | None,
    extra: Lanes | None,
) -> tuple[ControllerState, Command, Signals]:
    """Return the command of a period and the controller's next state, given a friction estimate."""
    controller, memory, acting, u = par.controller, s.memory, s.acting, motion.u
    added = select(par.compensation.enabled > 0.0, estimate.force, 0.0)

    # control
    d = disturbance_estimate(controller, memory.d, acting.force - acting.added, motion.a)
    d = select(motion.age == 0.0, 0.0, d)
    force = u + added
    force = force + select(controller.feedforward > 0.0, controller.M * motion.a_ref, 0.0)
    opposed = select(controller.observer > 0.0, d, 0.0)
    feedback = u + opposed
    passed, n_1, n_2 = filtered(par.notch, feedback, memory.n_1, memory.n_2)
    passed, f_1, f_2 = filtered(par.filter_1, passed, memory.f_1, memory.f_2)
    passed, f_3, f_4 = filtered(par.filter_2, passed, memory.f_3, memory.f_4)
    passed, f_5, f_6 = filtered(par.filter_3, passed, memory.f_5, memory.f_6)
    # Their change is added, so that filters that pass everything leave every bit of the force.
    force = force + opposed + (passed - feedback)
    if extra is not None:
        force = force + extra
    f_command = clip(force, -controller.force_limit, controller.force_limit)

    # share
    share = share_force(par.force_model, tables, motion.p, f_command)
    realised = select(controller.ideal_force > 0.0, f_command, share.force)
    i = share.current
    return (
        ControllerState(
            motion.p, motion.v, motion.error, d, n_1, n_2, f_1, f_2, f_3, f_4, f_5, f_6
        ),
        Command(realised, estimate.force, added, estimate.K, i.a, i.b, i.c),
        Signals(motion.error, motion.v, u, estimate.z, d, f_command, share.limited),
    )


@compiled
def learnt_force(par: Parameters, at: Inputs) -> Lanes:
    """Return the force that was learnt of the motion, where a controller adds it, N."""
    return select(par.controller.learnt > 0.0, at.learnt, 0.0)


@compiled
def control(  # noqa: PLR0913, PLR0917 - what a command depends on
    par: Parameters,
    s: State,
    at: Inputs,
    p_meas: Lanes,
    tables: NDArray[np.float64] | None,
    laws: Laws,
    extra: Lanes | None,
) -> tuple[ControllerState, Command, Signals]:
    """Return the controller's half of a period: its next state and its command.

    It reads the reference and the encoder, never the machine: of `s` the memory, the command in
    effect and the age, of `par` the controller's groups. What `laws` hold of the lanes is stepped,
    too. A force `extra`, N, if there is one, is added before the force limit.
    """
    motion = observe_motion(par, s, at, p_meas)
    estimate = estimate_friction(laws, motion)
    return command(par, s, motion, estimate, tables, extra)


@compiled
def in_effect(par: Parameters, pending: Command, made: Command) -> Command:
    """Return the command that acts from now on: the last one where the loop has a delay."""
    late = par.controller.delay > 0.0
    return Command(
        select(late, pending.force, made.force),
        select(late, pending.estimate, made.estimate),
        select(late, pending.added, made.added),
        select(late, pending.K, made.K),
        select(late, pending.current_a, made.current_a),
        select(late, pending.current_b, made.current_b),
        select(late, pending.current_c, made.current_c),
    )


@compiled
def tick(  # noqa: PLR0913, PLR0917 - as `control`
    par: Parameters,
    s: State,
    at: Inputs,
    tables: NDArray[np.float64] | None,
    laws: Laws,
    extra: Lanes | None,
) -> tuple[State, Sample]:
    """Return the state one control period later, and the sample taken at the period's start.

    Without `tables` every lane has analytic maps and shares its force by the closed form. A force
    `extra`, N, if there is one, is added to the controller's.
    """
    p_meas = measured_position(par, s, at)
    controlled = control(par, s, at, p_meas, tables, laws, extra)
    return act(par, s, at, controlled, tables, laws.effects)


@compiled
def measured_position(par: Parameters, s: State, at: Inputs) -> Lanes:
    """Return the position that the encoder reads at the start of a period, m."""
    late = (s.plant.v + s.plant.y_rate) * at.encoder_jitter
    return measure(par.encoder, s.plant.p + s.plant.y + late, at.encoder_noise)


@compiled
def act(  # noqa: PLR0913, PLR0917 - as `tick`
    par: Parameters,
    s: State,
    at: Inputs,
    controlled: tuple[ControllerState, Command, Signals],
    tables: NDArray[np.float64] | None,
    effects: Effects | None,
) -> tuple[State, Sample]:
    """Return what `tick` does, given what `control` made of the period's start."""
    memory, made, signals = controlled
    machine, acting = s.plant, in_effect(par, s.pending, made)

    # record
    ideal = par.controller.ideal_force > 0.0
    current = Phases(machine.i_a, machine.i_b, machine.i_c)
    thrust = thrust_of(par.force_map, tables, machine.p, current)
    force = select(ideal, acting.force, thrust)
    attraction = normal_force_of(par.force_map, tables, machine.p, current)
    f_friction = friction_force(par.friction, machine.v, machine.z)
    if effects is None:
        resistance = f_friction
        after = move(par, machine, acting, at, tables)
    else:
        time, normal = s.age * CONTROL_PERIOD, select(ideal, 0.0, attraction)
        now = resisted_now(par, machine, force, normal, time, effects)
        resistance = f_friction + now.force
        f_friction = f_friction + now.friction
        after = move_resisted(par, machine, acting, at, tables, effects, now.force, time)
    stop = end_stop_force(par.mechanics, machine.p, machine.v)
    limit = par.controller.force_limit
    sample = Sample(
        position=machine.p,
        position_measured=memory.p_last,
        following_error=signals.error,
        velocity=machine.v,
        velocity_measured=signals.v,
        acceleration=(force + stop - at.load - resistance) / par.mechanics.M,
        pd_force=signals.u,
        friction=f_friction,
        friction_estimate=made.estimate,
        bristle=machine.z,
        bristle_estimate=signals.z_hat,
        K=made.K,
        disturbance_estimate=signals.d,
        force_command=signals.f_command,
        force_realised=acting.force,
        thrust=force,
        normal_force=select(ideal, 0.0, attraction),
        current_a=current.a,
        current_b=current.b,
        current_c=current.c,
        current_command_a=made.current_a,
        current_command_b=made.current_b,
        current_command_c=made.current_c,
        force_saturated=select(abs(signals.f_command) >= limit, 1.0, 0.0),
        current_saturated=select(signals.limited & ~ideal, 1.0, 0.0),
    )

    healthy = (abs(signals.error) <= par.limits.error) & (abs(signals.f_command) < np.inf)
    state = State(
        plant=after,
        memory=memory,
        acting=acting,
        pending=made,
        age=s.age + 1.0,
        failed=select((s.failed < 0.0) & ~healthy, s.age, s.failed),
    )
    return state, sample


@cached
def control_once(
    parameters: NDArray[np.float64],
    state: NDArray[np.float64],
    inputs: NDArray[np.float64],
    p_meas: NDArray[np.float64],
    laws: Laws,
) -> None:
    """Advance the controllers of eight lanes with analytic maps by one period.

    Parameters
    ----------
    parameters, state : ndarray
        As `run_ticks` takes them; the machine's part of the state stays as it is.
    inputs : ndarray, shape (1, INPUT_ROWS or more, 2)
        Fields of `Inputs`, of which a controller sees the reference, and of `Ahead`.
    p_meas : ndarray, shape (1, WIDTH)
        Measured positions, m.
    laws : Laws
        `laws_of` the parameters.
    """
    enter_laws(parameters, state, laws)
    width = unpack(PlantState, state, 0).p
    par = groups(parameters, width)
    s = read_state(state, width)
    mode = flush_subnormals()
    look_ahead(laws, inputs, 0, width)
    measured = unpack(EncoderSample, p_meas, 0, width).p
    memory, made, _ = control(par, s, axes_at(Inputs, inputs, 0), measured, None, laws, None)
    acting = in_effect(par, s.pending, made)
    restore_mode(mode)
    write_state(State(s.plant, memory, acting, made, s.age, s.failed), state)
    leave_laws(state, laws)


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
    inputs : ndarray, shape (ticks, INPUT_ROWS or more, 2)
        Fields of `Inputs` for axis x and axis y; even lanes are x, odd lanes y. Then those of
        `Ahead`, where laws of one's own are there.
    samples : ndarray of float32, shape (ticks, SAMPLE_ROWS or more, WIDTH)
        Overwritten by the samples of each tick, and by the states of laws if it has rows for them.
    tabled : list of bool, optional
        `reads_tables` of `parameters`, for callers with few ticks at a time.
    """
    tabled = reads_tables(parameters) if tabled is None else tabled
    laws = laws_of(parameters)
    if not any(tabled):
        run_lanes(parameters, state, inputs, samples, None, laws)
    elif all(tabled):
        run_lanes(parameters, state, inputs, samples, TABLES.values, laws)
    else:
        other_state, other_samples = state.copy(), np.empty_like(samples)
        run_lanes(parameters, state, inputs, samples, None, laws)
        run_lanes(parameters, other_state, inputs, other_samples, TABLES.values, laws)
        state[:, tabled] = other_state[:, tabled]
        samples[:, :, tabled] = other_samples[:, :, tabled]


@cached
def run_lanes(  # noqa: PLR0913, PLR0917 - as `tick`
    parameters: NDArray[np.float64],
    state: NDArray[np.float64],
    inputs: NDArray[np.float64],
    samples: NDArray[np.float32],
    tables: NDArray[np.float64] | None,
    laws: Laws,
) -> None:
    """Advance eight lanes as `run_ticks` does; for compiled callers, whose lanes are all alike."""
    enter_laws(parameters, state, laws)
    width = unpack(PlantState, state, 0).p
    par = groups(parameters, width)
    s = read_state(state, width)
    mode = flush_subnormals()
    for k in range(inputs.shape[0]):
        at = axes_at(Inputs, inputs, k)
        look_ahead(laws, inputs, k, width)
        s, sample = tick(par, s, at, tables, laws, learnt_force(par, at))
        record(sample, samples, k)
        record_laws(laws, samples, k, width)
    restore_mode(mode)
    write_state(s, state)
    leave_laws(state, laws)
