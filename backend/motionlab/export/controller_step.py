"""One axis of an exported controller, in one control period."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, NamedTuple

from numpy.typing import NDArray

from motionlab.kernel.layout import Command, ControllerState, Inputs, Parameters
from motionlab.kernel.motion import Ahead, seen
from motionlab.kernel.tick import command, in_effect, observe_motion
from motionlab.lanes import Lanes, Mask
from motionlab.laws import Law
from motionlab.laws.law import Seen
from motionlab.plant.magnetics import Phases
from motionlab.targets.c_program import Program
from motionlab.targets.record import Recorder
from motionlab.targets.record_arguments import zeros
from motionlab.targets.record_source import plain


class Reference(NamedTuple):
    """Reference of one axis at the instant of sampling."""

    position: Lanes  # m
    velocity: Lanes  # m/s
    acceleration: Lanes  # m/s^2


class ReferenceAhead(NamedTuple):
    """Reference of one axis at the instant of sampling, and of the two periods after it."""

    position: Lanes  # m
    velocity: Lanes  # m/s
    acceleration: Lanes  # m/s^2
    position_1: Lanes  # a control period later, m
    velocity_1: Lanes  # m/s
    acceleration_1: Lanes  # m/s^2
    position_2: Lanes  # two control periods later, m
    velocity_2: Lanes  # m/s
    acceleration_2: Lanes  # m/s^2
    phase: Lanes  # share of the lap that is done, 0 to 1


class Signals(NamedTuple):
    """Signals of one axis, to be recorded."""

    following_error: Lanes  # m
    velocity: Lanes  # by differences of the measured position, m/s
    pd_force: Lanes  # u, N
    friction_estimate: Lanes  # N
    bristle_estimate: Lanes  # at the end of the period, m
    K: Lanes  # of the friction observer, m/s
    disturbance_estimate: Lanes  # d, N
    force_command: Lanes  # within the force limit, N
    force_realised: Lanes  # what the currents in effect are to give, N
    current_next: Phases  # computed in this period, A; in effect now without delay
    force_saturated: Mask  # the force command is at its limit
    current_saturated: Mask  # some phase is at its current limit
    healthy: Mask  # false: following error beyond its limit, or NaN


class AxisState(NamedTuple):
    """State of an axis between control periods."""

    memory: ControllerState
    law: Any
    acting: Command
    pending: Command  # computed but not yet in effect
    age: Lanes  # control periods since the start


@functools.cache
def with_law(kind: Any, record: Any) -> Any:
    """Return `Parameters` or `AxisState` with a law's own record in the field `law`."""
    body = {
        "__annotations__": kind.__annotations__ | {"law": record},
        "__doc__": kind.__doc__,
        "__module__": kind.__module__,
        "_like": kind,
    }
    return type(kind.__name__, (kind,), body)


@functools.cache
def reference_of(law: Law) -> Any:
    """Return what the step of an axis takes of the reference: more where its law looks ahead.

    Raises
    ------
    RecordError
        If the law cannot be written as C.
    """
    step: Any = plain(law.step)
    kinds = (law.Parameters, law.State, Seen)
    values = dict(zip(inspect.signature(step).parameters, map(zeros, kinds), strict=True))
    program = Program({"step": Recorder().record(step, values)})
    return Reference if set(Ahead._fields).isdisjoint(program.fields(Seen)) else ReferenceAhead


def _ahead(reference: ReferenceAhead) -> Any:
    return Ahead(
        reference.position_1,
        reference.velocity_1,
        reference.acceleration_1,
        reference.position_2,
        reference.velocity_2,
        reference.acceleration_2,
        reference.phase,
    )


def _none_ahead(_: Reference) -> Any:
    return Ahead(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def step_of(law: Law) -> Callable[..., tuple[Any, Phases, Signals]]:
    """Return the step of an axis that has a law; its reference is a `reference_of` the law."""
    step_law, axis_state = law.step, with_law(AxisState, law.State)
    ahead_of = _ahead if reference_of(law) is ReferenceAhead else _none_ahead

    def step_axis(
        par: Parameters,
        s: Any,
        reference: Any,
        position: Lanes,
        tables: NDArray | None,
    ) -> tuple[AxisState, Phases, Signals]:
        """Advance one axis by a control period, from its reference and its measured position, m.

        Return its next state, the currents that are in effect from now on, A, and its signals.
        """
        at = Inputs(
            p_ref=reference.position,
            v_ref=reference.velocity,
            a_ref=reference.acceleration,
            load=0.0,
            encoder_noise=0.0,
            current_a=0.0,
            current_b=0.0,
            current_c=0.0,
            learnt=0.0,
            encoder_jitter=0.0,
        )
        motion = observe_motion(par, s, at, position)
        estimate, law_state = step_law(
            par.law, s.law, seen(par.controller, par.model_friction, motion, ahead_of(reference))
        )
        memory, made, signals = command(par, s, motion, estimate, tables, None)
        acting = in_effect(par, s.pending, made)

        force_limit = par.controller.force_limit
        f_command = abs(signals.f_command)
        following = abs(signals.error) <= par.limits.error
        ideal = par.controller.ideal_force > 0.0
        current = Phases(acting.current_a, acting.current_b, acting.current_c)
        return (
            axis_state(memory, law_state, acting, made, s.age + 1.0),
            current,
            Signals(
                following_error=signals.error,
                velocity=signals.v,
                pd_force=signals.u,
                friction_estimate=made.estimate,
                bristle_estimate=signals.z_hat,
                K=made.K,
                disturbance_estimate=signals.d,
                force_command=signals.f_command,
                force_realised=acting.force,
                current_next=Phases(made.current_a, made.current_b, made.current_c),
                force_saturated=f_command >= force_limit,
                current_saturated=signals.limited & ~ideal,
                healthy=following & (f_command <= force_limit),
            ),
        )

    return step_axis
